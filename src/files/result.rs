//! Result files, `taut-result/1`: an answer with all that is needed to look at it, check it or go
//! on with it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{FileError, RobotFiles, read_text};
use crate::constraint::ConstraintsFile;
use crate::optimize::{ColumnTurns, KeptConstraint, Outcome, PathHold, Refusal, StageShare};
use crate::path;
use crate::scene::scene_file::SceneFile;
use crate::validation::{Certificate, LoweredFloor, NamedRequirement};
use crate::warning::Warning;

/// What a result file calls itself.
pub const RESULT_FORMAT: &str = "taut-result/1";

/// An answer. Lengths are in the metric of `weights`, distances in metres, times in seconds;
/// segments and waypoints count from 0.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct ResultFile {
    /// [`RESULT_FORMAT`].
    pub format: String,
    /// Label of the problem, or the file's name.
    pub name: String,
    /// Optimizer that was asked for.
    pub mode: String,
    /// Which of the robot's models was taken: `given`, `spheres`, or `loaded` where the daemon had
    /// it.
    pub geometry: String,
    /// Whether `path` is proved.
    pub proved: bool,
    /// Result code, MoveIt's where it has one.
    pub code: i32,
    /// Its name.
    pub code_name: String,
    /// Length of `path_before`.
    pub length_before: f64,
    /// Length of `path`.
    pub length_after: f64,
    /// Distance of the ends: no path is shorter.
    pub lower_bound: f64,
    /// By which part of the lower bound `path` is longer.
    pub gap: Option<f64>,
    /// What lengths are measured in, for people.
    pub metric: String,
    /// Clearance asked for (m).
    pub clearance_m: f64,
    /// Smallest floor of any clearance (m).
    pub floor_m: f64,
    /// Requirements with a lowered floor.
    pub floors_lowered: Vec<LoweredFloor>,
    /// What `path` keeps of each constraint; empty where it is not proved.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub keeps: Vec<ResultKept>,
    /// What pinches the path.
    pub pinched: Vec<NamedRequirement>,
    /// Angle columns whose numbers in `path` are not the given ones but whole turns away.
    pub turned: Vec<ResultTurns>,
    /// How far was looked for what is nearest (m).
    pub searched_m: Option<f64>,
    /// The smallest clearance and where it is.
    pub smallest_clearance: Option<ResultHold>,
    /// What holds the path.
    pub holds: Option<Vec<ResultHold>>,
    /// The daemon's id of the request, in 16 hexadecimal digits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub request_id: Option<String>,
    /// Age of the oldest frame among those that the scene is seen by, when the answer was sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub world_age_s: Option<f64>,
    /// CPU time of the thread that computed it.
    pub cpu_s: f64,
    /// Time on the clock.
    pub time_s: f64,
    /// Iterations of the optimizer.
    pub iterations: u64,
    /// Pairs examined.
    pub work: u64,
    /// How the run ended.
    pub termination: String,
    /// The stage that found `path`.
    pub stage: String,
    /// What each stage did.
    pub stages: Vec<ResultShare>,
    /// When each proved improvement was seen (s since the start), and its length.
    pub lengths_over_time: Vec<(f64, f64)>,
    /// Pairs of bodies that were checked.
    pub pairs: usize,
    /// Why nothing can be proved of this robot, whatever the path.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncheckable: Option<String>,
    /// Where the input is refused, if it is.
    #[serde(flatten)]
    pub refusal: Option<ResultRefusal>,
    /// What a person should know of robot, scene and request, a line each.
    pub warnings: Vec<String>,
    /// Those of them that say what the verdict does not cover, or rests on.
    pub uncovered: Vec<String>,
    /// Columns of both paths, by MoveIt's variable names.
    pub variables: Vec<String>,
    /// Weights of the metric, one per velocity coordinate.
    pub weights: Vec<f64>,
    /// The answer's waypoints (m, rad, quaternions x y z w).
    pub path: Vec<Vec<f64>>,
    /// The input's waypoints, in the same columns.
    pub path_before: Vec<Vec<f64>>,
    /// What both paths keep besides clearance, as it was asked for.
    #[serde(skip_serializing_if = "ConstraintsFile::is_empty")]
    pub path_constraints: ConstraintsFile,
    /// Where robot and scene come from.
    pub subject: ResultSubject,
    /// How far what is executed may stray from `path`, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corridor: Option<ResultCorridor>,
    /// The times of `path`, where they were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub times: Option<ResultTimes>,
    /// The proof in short.
    pub certificate: Option<Certificate>,
}

/// A corridor: every pair keeps `floor_m` at any q with Σ reach_m |q − p| ≤ slack_m around a p of
/// the segment.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ResultCorridor {
    /// What every pair keeps (m).
    pub floor_m: f64,
    /// Velocity coordinates, in the order of the columns.
    pub coordinates: Vec<ResultCoordinate>,
    /// One per segment of the path (m).
    pub slack_m: Vec<f64>,
}

/// What became of the times that were asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResultTimes {
    /// `timed`, `not-reached`, `refused` or `no-path`.
    pub status: String,
    /// Why there is no trajectory, where there is none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub message: String,
    /// The trajectory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trajectory: Option<Box<ResultTrajectory>>,
}

/// A trajectory along `path`, proved as it is written: when what is to be where. Columns are those of
/// `variables`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResultTrajectory {
    /// From the first point to the last.
    pub duration_s: f64,
    /// No trajectory between the same ends within the same limits takes less.
    pub duration_bound_s: f64,
    /// By which part of that it takes longer.
    pub gap: f64,
    /// The variable whose motor needs the time of the bound.
    pub decides: String,
    /// What the first trajectory that was proved takes, which stops where it must.
    pub stops_s: f64,
    /// What it comes of: `stops`, `rounded`, `shortcuts`.
    pub stage: String,
    /// What goes from point to point: `cubic`, `quintic`, `linear`.
    pub controller: String,
    /// Points per second of a `linear` one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Distance that every pair keeps at every instant (m); `None` where nothing is near.
    pub clearance_m: Option<f64>,
    /// What it is proved at lower floors.
    pub floors_lowered: Vec<LoweredFloor>,
    /// Where it comes nearest to anything.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nearest: Option<ResultNearest>,
    /// Work that it took.
    pub work: u64,
    /// What each column was allowed, and used.
    pub motors: Vec<ResultMotor>,
    /// When each point is passed (ns from the start).
    pub times_ns: Vec<i64>,
    /// Positions of each point.
    pub positions: Vec<Vec<f64>>,
    /// Velocities of each point; none where the controller goes straight.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub velocities: Vec<Vec<f64>>,
    /// Accelerations of each point; none where a controller that had them would go another way.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub accelerations: Vec<Vec<f64>>,
}

/// What a column of a trajectory was allowed, and used.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResultMotor {
    /// Least and greatest velocity (per s); `None` = no limit.
    pub velocity: [Option<f64>; 2],
    /// Least and greatest acceleration (per s²).
    pub acceleration: [Option<f64>; 2],
    /// Largest part of a limit of velocity; 1 is all of it.
    pub velocity_used: f64,
    /// When (s).
    pub velocity_at_s: f64,
    /// The same of acceleration.
    pub acceleration_used: f64,
    /// When (s).
    pub acceleration_at_s: f64,
}

/// A place in time where a trajectory comes nearest to anything.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResultNearest {
    /// When.
    pub time_s: f64,
    /// What is kept.
    #[serde(flatten)]
    pub requirement: NamedRequirement,
    /// How much, in its unit.
    pub amount: f64,
    /// The closest points, in the world (m).
    pub points: [[f64; 3]; 2],
    /// Unit vector from the second body towards the first.
    pub normal: [f64; 3],
}

/// A velocity coordinate of a corridor.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ResultCoordinate {
    /// The variable that it belongs to; for the three of a rotation, each of the quaternion's first
    /// three.
    pub variable: String,
    /// `line`, `circle`, or one of the three of a `rotation` vector.
    pub kind: String,
    /// How far bodies move at most against each other (m per rad or m).
    pub reach_m: f64,
}

/// An angle column whose numbers were written anew, because a step of more than half a turn means
/// the short way round.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ResultTurns {
    /// Name of the column.
    pub variable: String,
    /// Whole turns from the goal in `path_before` to the one in `path`; 0 where only numbers before
    /// it moved.
    pub turns: i64,
}

/// A place of `path` where least of a requirement is kept: of a clearance, where two bodies are
/// closest.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ResultHold {
    /// Segment.
    pub segment: usize,
    /// Ratio on it.
    pub t: f64,
    /// What is kept.
    #[serde(flatten)]
    pub requirement: NamedRequirement,
    /// How much, in its unit.
    pub amount: f64,
    /// Where that is seen, in the world (m): of a clearance the closest points.
    pub points: [[f64; 3]; 2],
    /// Unit vector along which the first point moves for more to be kept: of a clearance from the
    /// second body towards the first.
    pub normal: [f64; 3],
}

/// What `path` keeps of one constraint, of its tolerance as it is asked.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ResultKept {
    /// Where least was found to be left, and how much there (`amount`): a look, no proof.
    #[serde(flatten)]
    pub tightest: ResultHold,
    /// What is proved to be left everywhere along the path, in its unit; below 0 where the tolerance is
    /// raised and that is needed.
    pub left: f64,
    /// The tolerance that is asked, where one number says it: what is read is `asked − left` at most.
    pub asked: Option<f64>,
}

/// What one stage did.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ResultShare {
    /// Its name.
    pub stage: String,
    /// By how much it shortened the path.
    pub gain: f64,
    /// Its trials.
    pub iterations: u64,
    /// Pairs examined for it.
    pub work: u64,
}

/// Where and why the input is not proved.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ResultRefusal {
    /// `COLLISION`, `TOO_CLOSE` or `UNCERTIFIED`.
    pub reason: String,
    /// Segment.
    pub segment: usize,
    /// Ratio on it.
    pub t: f64,
    /// What is not kept.
    #[serde(flatten)]
    pub requirement: NamedRequirement,
    /// How much of it is kept, in its unit: of a clearance the distance, below 0 the penetration
    /// depth, which is from below unless both bodies are convex.
    pub amount: f64,
    /// The floor: how much must be kept.
    pub allowed: f64,
    /// Where that is seen, in the world (m): of a clearance closest or contact points.
    pub points: [[f64; 3]; 2],
    /// Unit vector along which the first point moves for more to be kept: of a clearance from the
    /// second body towards the first.
    pub normal: [f64; 3],
    /// The part before which everything is proved: segment + ratio.
    pub proved_prefix: f64,
    /// What the person who reads it may do.
    pub hint: String,
}

/// Where robot and scene come from: enough to see them again.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct ResultSubject {
    /// The robot.
    pub robot: RobotSource,
    /// The scene.
    pub scene: SceneSource,
    /// Whether columns of continuous joints count as they stand, not as angles on the circle.
    pub unwrapped: bool,
    /// Where the joints stand that the request gave a place and that are no columns (m or rad).
    pub held: BTreeMap<String, f64>,
}

/// A robot: its files, or what the daemon calls it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct RobotSource {
    /// Its label in the daemon, where it was named by it.
    pub label: Option<String>,
    /// Hash of its content, in 16 hexadecimal digits.
    pub hash: String,
    /// Its files by absolute paths; `None` where only the daemon knows them.
    pub files: Option<RobotFiles>,
}

/// A scene, with its content.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct SceneSource {
    /// Its label in the daemon, where it was named by it.
    pub label: Option<String>,
    /// Its version there.
    pub version: Option<u64>,
    /// Hash of its content, in 16 hexadecimal digits.
    pub hash: String,
    /// The absolute path of its file, where it came from one.
    pub file: Option<PathBuf>,
    /// What is in it, meshes included: what the answer is about, whatever file and label name by
    /// now. `None` where the daemon could not give it any more.
    pub content: Option<SceneFile>,
}

impl ResultFile {
    /// What an outcome says; name, code, times, subject and input are the caller's to add.
    pub fn of(outcome: &Outcome) -> Self {
        let nearest = outcome.nearest.as_ref();
        Self {
            format: RESULT_FORMAT.to_owned(),
            proved: outcome.proved,
            length_before: outcome.length_before,
            length_after: outcome.length_after,
            lower_bound: outcome.lower_bound,
            gap: outcome.gap(),
            clearance_m: outcome.clearance_m,
            floor_m: outcome.floor_m,
            floors_lowered: outcome.floors_lowered.clone(),
            keeps: outcome.keeps.iter().map(Into::into).collect(),
            pinched: outcome.pinched.clone(),
            turned: outcome.turned.iter().map(Into::into).collect(),
            searched_m: nearest.map(|nearest| nearest.searched_m),
            smallest_clearance: nearest
                .and_then(|nearest| nearest.smallest.as_ref())
                .map(Into::into),
            holds: nearest.map(|nearest| nearest.holds.iter().map(Into::into).collect()),
            iterations: outcome.iterations,
            work: outcome.work,
            termination: outcome.termination.name().to_owned(),
            stage: outcome.stage.name().to_owned(),
            stages: outcome.stages.iter().map(Into::into).collect(),
            pairs: outcome.pairs,
            uncheckable: outcome.uncheckable.clone(),
            refusal: outcome.refusal.as_ref().map(Into::into),
            warnings: texts(&outcome.warnings, |_| true),
            uncovered: texts(&outcome.warnings, Warning::is_uncovered),
            weights: outcome.weights.clone(),
            path: rows(&outcome.path),
            certificate: outcome.certificate.clone(),
            ..Self::default()
        }
    }

    /// Reads a result file.
    ///
    /// # Errors
    /// A file that cannot be read, or is no result.
    pub fn read(file: &Path) -> Result<Self, FileError> {
        let refuse = |text: String| FileError::content(file, text);
        let next =
            "write one with `taut shorten … --out RESULT.json` or `taut check … --format json`";
        let result: Self = serde_json::from_str(&read_text(file)?)
            .map_err(|error| refuse(format!("not a result file: {error}; {next}")))?;
        if result.format != RESULT_FORMAT {
            return Err(refuse(format!(
                "its format is {:?}; valid: {RESULT_FORMAT:?}; {next}",
                result.format
            )));
        }
        let columns = result.variables.len();
        let is_table =
            |rows: &[Vec<f64>]| !rows.is_empty() && rows.iter().all(|row| row.len() == columns);
        if !is_table(&result.path) || !is_table(&result.path_before) {
            return Err(refuse(format!(
                "path or path_before has rows of other than its {columns} variables, or none"
            )));
        }
        let segments = result.path.len().saturating_sub(1).max(1);
        if let Some(slack) = result
            .corridor
            .as_ref()
            .map(|corridor| corridor.slack_m.len())
            .filter(|n| *n != segments)
        {
            return Err(refuse(format!(
                "its corridor has {slack} segments, its path {segments}"
            )));
        }
        Ok(result)
    }

    /// As one line of JSON.
    pub fn json(&self) -> String {
        serde_json::to_string(self).expect("a result holds only strings, booleans and numbers")
    }
}

/// The lines of those warnings that are meant.
pub fn texts(warnings: &[Warning], is_meant: impl Fn(&Warning) -> bool) -> Vec<String> {
    warnings
        .iter()
        .filter(|warning| is_meant(warning))
        .map(Warning::to_string)
        .collect()
}

/// The waypoints of a path.
pub fn rows(path: &path::Path) -> Vec<Vec<f64>> {
    path.waypoints().map(<[f64]>::to_vec).collect()
}

impl From<&PathHold> for ResultHold {
    fn from(hold: &PathHold) -> Self {
        Self {
            segment: hold.segment,
            t: hold.t,
            requirement: hold.requirement.clone(),
            amount: hold.amount,
            points: hold.points.map(|point| point.to_array()),
            normal: hold.normal.to_array(),
        }
    }
}

impl From<&KeptConstraint> for ResultKept {
    fn from(kept: &KeptConstraint) -> Self {
        Self {
            tightest: (&kept.tightest).into(),
            left: kept.left,
            asked: kept.asked,
        }
    }
}

impl From<&ColumnTurns> for ResultTurns {
    fn from(turned: &ColumnTurns) -> Self {
        Self {
            variable: turned.variable.clone(),
            turns: turned.turns,
        }
    }
}

impl From<&StageShare> for ResultShare {
    fn from(share: &StageShare) -> Self {
        let StageShare {
            stage,
            gain,
            work,
            iterations,
        } = *share;
        Self {
            stage: stage.name().to_owned(),
            gain,
            iterations,
            work,
        }
    }
}

impl From<&Refusal> for ResultRefusal {
    fn from(refusal: &Refusal) -> Self {
        Self {
            reason: refusal.reason.name().to_owned(),
            segment: refusal.segment,
            t: refusal.t,
            requirement: refusal.requirement.clone(),
            amount: refusal.amount,
            allowed: refusal.allowed,
            points: refusal.points.map(|point| point.to_array()),
            normal: refusal.normal.to_array(),
            proved_prefix: refusal.proved_prefix,
            hint: refusal.hint.clone(),
        }
    }
}

//! `taut check --timed`: prove what a controller executes between the points of a trajectory, in
//! this process.

use std::io::Write;
use std::path::Path;
use std::time::Instant;

use serde::Serialize;
use taut::files::result::texts;
use taut::files::{FileError, Reader, Trajectory, TrajectoryPoint};
use taut::optimize::LIMIT_TOLERANCE;
use taut::robot::Kinematics;
use taut::solid::TOUCHING_M;
use taut::validation::timed::{self, Curve, Outside, Point, TimedHit, TimedProof, TimedVerdict};
use taut::validation::{HitReason, Scratch, Validator};
use taut::warning::{self, Warning};

use super::choices::Choices;
use super::code::Code;
use super::error::{CliError, stdout};
use super::load::{self, Loaded};
use super::report::{self, Subject, length};
use super::request::{Rules, Source};
use super::{Format, layout};

/// What was found, as JSON has it. Distances are in metres, times in seconds on the trajectory's
/// clock.
#[derive(Default, Serialize)]
struct Finding<'a> {
    name: &'a str,
    timed: bool,
    proved: bool,
    code: i32,
    code_name: &'static str,
    points: usize,
    duration_s: f64,
    clearance_m: Option<f64>,
    floors_lowered: Vec<(String, String, f64)>,
    pieces: u64,
    /// `COLLISION`, `TOO_CLOSE`, `UNCERTIFIED` or `LIMIT`.
    reason: Option<&'static str>,
    /// The point before the place, from 0.
    point: Option<usize>,
    at_s: Option<f64>,
    bodies: Option<[String; 2]>,
    /// No more than the penetration depth; negative is a distance.
    depth_m: Option<f64>,
    seen_s: Option<f64>,
    /// Why nothing can be proved of this robot.
    uncheckable: Option<String>,
    /// Pairs of bodies that were checked.
    pairs: usize,
    warnings: Vec<String>,
    uncovered: Vec<String>,
    variable: Option<String>,
    value: Option<f64>,
    time_s: f64,
}

/// What came of a trajectory.
enum Verdict {
    Proved(TimedProof),
    Refused {
        hit: TimedHit,
        bodies: [String; 2],
    },
    Outside {
        outside: Outside,
        variable: String,
        limits: [f64; 2],
    },
    TimedOut,
    NoGeometry(String),
}

/// A verdict and what it rests on.
struct Judged {
    verdict: Verdict,
    pairs: usize,
    warnings: Vec<Warning>,
}

/// The point as the core takes it; `None` where it has no time.
pub(super) fn point(point: TrajectoryPoint) -> Option<Point> {
    let TrajectoryPoint {
        positions,
        velocities,
        accelerations,
        time_s,
    } = point;
    Some(Point {
        time_s: time_s?,
        positions,
        velocities,
        accelerations,
    })
}

/// The points of a trajectory, each with its time.
///
/// # Errors
/// A point without a time, or columns that the robot does not have.
pub(super) fn timed_points(
    trajectory: &Trajectory,
    points: Vec<TrajectoryPoint>,
) -> Result<Vec<Point>, FileError> {
    let all: Option<Vec<Point>> = points.into_iter().map(point).collect();
    all.ok_or_else(|| {
        let text = "a point has no time_from_start; without times it is a path: leave out --timed";
        FileError::Content {
            file: trajectory.file.clone(),
            text: text.to_owned(),
        }
    })
}

/// Checks the trajectory of a file.
///
/// # Errors
/// Files that cannot be used; a trajectory that is refused is no error but an exit code.
pub(super) fn run(
    reader: &mut Reader,
    file: &Path,
    source: &Source,
    rules: &Rules,
    choices: &Choices,
    format: Format,
) -> Result<u8, CliError> {
    let trajectory = Trajectory::read(file)?;
    let loaded = load::load_holding(reader, file, source, false, choices.held())?;
    let points = timed_points(&trajectory, trajectory.for_robot(&loaded.robot)?)?;
    let refuse = |error: timed::CurveError| FileError::Content {
        file: file.to_owned(),
        text: error.to_string(),
    };
    let curve = Curve::new(&loaded.robot, &points).map_err(refuse)?;
    let start = Instant::now();
    let Judged {
        verdict,
        pairs,
        warnings,
    } = verdict(&loaded, &curve, rules, choices, start)?;
    let time_s = start.elapsed().as_secs_f64();
    let (code, reason) = code(&verdict);
    let Subject {
        warnings: of_files,
        notes,
        ..
    } = loaded.subject();
    let told = warning::told(of_files.iter().chain(&warnings).chain(&notes));
    if format == Format::Table {
        report::warn(&told, "");
    }
    let text = match format {
        Format::Json => {
            let finding = Finding {
                name: &loaded.name,
                timed: true,
                code: code.into(),
                code_name: code.name(),
                points: points.len(),
                duration_s: curve.total_s(),
                reason,
                pairs,
                warnings: texts(&told, |_| true),
                uncovered: texts(&told, Warning::is_uncovered),
                time_s,
                ..found(&loaded, &verdict)?
            };
            serde_json::to_string(&finding)
                .expect("a finding holds only strings, booleans and numbers")
        }
        Format::Table => table(&loaded, &curve, &verdict, pairs, time_s)?,
    };
    writeln!(std::io::stdout().lock(), "{text}").map_err(stdout)?;
    Ok(code.exit_code())
}

fn verdict(
    loaded: &Loaded,
    curve: &Curve,
    rules: &Rules,
    choices: &Choices,
    start: Instant,
) -> Result<Judged, CliError> {
    let robot = &loaded.robot;
    let model = loaded.model()?;
    let mut warnings = model.uncovered();
    let pairs = model.checked_pairs();
    if curve.time(0) > 0.0 {
        warnings.push(Warning::uncovered(format!(
            "the first point is at {} s: how the robot gets there is not part of the trajectory, nor of this proof",
            curve.time(0)
        )));
    }
    if let Some(outside) = curve.outside(robot) {
        let variable = &robot.variables()[outside.column];
        if outside.by > LIMIT_TOLERANCE {
            let (variable, limits) = (
                variable.name.clone(),
                [variable.hard_lower, variable.hard_upper],
            );
            return Ok(Judged {
                verdict: Verdict::Outside {
                    outside,
                    variable,
                    limits,
                },
                pairs,
                warnings,
            });
        }
        let text = format!(
            "{} leaves its limits by {:.1e} at {:.4} s",
            variable.name, outside.by, outside.time_s
        );
        warnings.push(Warning::uncovered(text));
    } else if let Some(outside) = curve.outside_soft(robot) {
        let name = &robot.variables()[outside.column].name;
        let text = format!(
            "{name} leaves its soft limits by {:.2e} at {:.4} s",
            outside.by, outside.time_s
        );
        warnings.push(Warning::uncovered(text));
    }
    let held = held(loaded, choices)?;
    let mut kinematics = Kinematics::default();
    kinematics.update(robot, &curve.at(0, 0.0), &held);
    if let Some((bodies, contact)) = model.static_contact(&kinematics) {
        let time_s = curve.time(0);
        let hit = TimedHit {
            reason: HitReason::Collision,
            point: 0,
            time_s,
            pair: 0,
            seen_s: time_s,
            contact,
        };
        return Ok(Judged {
            verdict: Verdict::Refused { hit, bodies },
            pairs,
            warnings,
        });
    }
    let space = robot.space().unwrapped();
    let mut scratch = Scratch::default();
    let mut validator = Validator::new(&model, &space, &held, rules.clearance, &mut scratch);
    let mut stop = || {
        rules
            .deadline
            .is_some_and(|deadline| start.elapsed() >= deadline)
    };
    let found = timed::prove(&mut validator, curve, rules.strict, &mut stop);
    let is_collision =
        matches!(&found, TimedVerdict::Refused(hit) if hit.reason == HitReason::Collision);
    let verdict = match (model.uncheckable().filter(|_| !is_collision), found) {
        (Some(why), _) => Verdict::NoGeometry(why),
        (None, TimedVerdict::Proved(proof)) => Verdict::Proved(proof),
        (None, TimedVerdict::Refused(hit)) => Verdict::Refused {
            bodies: model.pair_names(hit.pair),
            hit,
        },
        (None, TimedVerdict::Stopped) => Verdict::TimedOut,
    };
    Ok(Judged {
        verdict,
        pairs,
        warnings,
    })
}

fn held(loaded: &Loaded, choices: &Choices) -> Result<Vec<f64>, CliError> {
    let layout = layout::Layout::of_model(&loaded.robot, Vec::new());
    let mut held: Vec<f64> = layout.held.iter().map(|(_, value)| *value).collect();
    for (name, value) in choices.held() {
        held[layout.held_index(name)?] = *value;
    }
    Ok(held)
}

fn code(verdict: &Verdict) -> (Code, Option<&'static str>) {
    match verdict {
        Verdict::Proved(_) => (Code::Success, None),
        Verdict::Outside { .. } => (Code::Uncertified, Some("LIMIT")),
        Verdict::TimedOut => (Code::TimedOut, None),
        Verdict::NoGeometry(_) => (Code::Uncertified, Some("UNCERTIFIED")),
        Verdict::Refused { hit, .. } => match hit.reason {
            HitReason::Collision => (Code::InvalidMotionPlan, Some("COLLISION")),
            HitReason::TooClose => (Code::Uncertified, Some("TOO_CLOSE")),
            HitReason::Uncertified => (Code::Uncertified, Some("UNCERTIFIED")),
        },
    }
}

/// What of a verdict a finding holds.
fn found<'a>(loaded: &Loaded, verdict: &Verdict) -> Result<Finding<'a>, CliError> {
    Ok(match verdict {
        Verdict::Proved(proof) => Finding {
            proved: true,
            clearance_m: Some(proof.clearance_m).filter(|metres| metres.is_finite()),
            floors_lowered: lowered(loaded, proof)?,
            pieces: proof.pieces,
            ..Finding::default()
        },
        Verdict::Refused { hit, bodies } => Finding {
            point: Some(hit.point),
            at_s: Some(hit.time_s),
            bodies: Some(bodies.clone()),
            depth_m: Some(-hit.contact.distance),
            seen_s: Some(hit.seen_s),
            ..Finding::default()
        },
        Verdict::Outside {
            outside, variable, ..
        } => Finding {
            point: Some(outside.point),
            at_s: Some(outside.time_s),
            variable: Some(variable.clone()),
            value: Some(outside.value),
            ..Finding::default()
        },
        Verdict::TimedOut => Finding::default(),
        Verdict::NoGeometry(why) => Finding {
            uncheckable: Some(why.clone()),
            ..Finding::default()
        },
    })
}

fn lowered(loaded: &Loaded, proof: &TimedProof) -> Result<Vec<(String, String, f64)>, CliError> {
    if proof.lowered.is_empty() {
        return Ok(Vec::new());
    }
    let model = loaded.model()?;
    let named = |&(pair, floor): &(usize, f64)| {
        let [a, b] = model.pair_names(pair);
        (a, b, floor)
    };
    Ok(proof.lowered.iter().map(named).collect())
}

fn table(
    loaded: &Loaded,
    curve: &Curve,
    verdict: &Verdict,
    pairs: usize,
    time_s: f64,
) -> Result<String, CliError> {
    let points = curve.segments() + 1;
    let took = report::time(time_s);
    Ok(match verdict {
        Verdict::Proved(_) if pairs == 0 => format!("proved{}   {took}", report::NOTHING_TO_CHECK),
        Verdict::Proved(proof) => {
            let clearance =
                report::clearance(Some(proof.clearance_m).filter(|metres| metres.is_finite()));
            let floors = lowered(loaded, proof)?;
            let floors: Vec<String> = floors
                .iter()
                .map(|(a, b, floor)| format!("{a} × {b} {}", length(*floor)))
                .collect();
            let floors = if floors.is_empty() {
                String::new()
            } else {
                format!("   lowered: {}", floors.join(", "))
            };
            let seconds = report::time(curve.total_s());
            let pieces = proof.pieces;
            format!(
                "proved   {clearance}{floors}   {points} points, {seconds}, {pieces} pieces   {took}"
            )
        }
        Verdict::Refused {
            hit,
            bodies: [a, b],
        } => {
            let depth = match -hit.contact.distance {
                depth if depth.abs() <= TOUCHING_M => "touching".to_owned(),
                depth if depth > 0.0 => format!("depth ≥ {} at {:.4} s", length(depth), hit.seen_s),
                depth => format!("distance {}", length(-depth)),
            };
            let reason = code(verdict).1.unwrap_or_default();
            let time = hit.time_s;
            let point = hit.point + 1;
            format!(
                "{reason} at {time:.4} s, after point {point} of {points}: {a} × {b}, {depth}   {took}"
            )
        }
        Verdict::Outside {
            outside,
            variable,
            limits: [lower, upper],
        } => {
            let Outside {
                point,
                time_s,
                value,
                by,
                ..
            } = outside;
            format!(
                "LIMIT at {time_s:.4} s, after point {} of {points}: {variable} is {value:.6}, outside [{lower}, {upper}] by {by:.1e}   {took}",
                point + 1
            )
        }
        Verdict::NoGeometry(why) => format!("{}   {why}   {took}", Code::Uncertified.name()),
        Verdict::TimedOut => {
            format!(
                "{}   the deadline passed before the trajectory was proved   {took}",
                Code::TimedOut.name()
            )
        }
    })
}

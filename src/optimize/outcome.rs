//! What a request comes back with.

use crate::math::Vec3;
use crate::path::Path;
use crate::validation::{HitReason, LoweredFloor, NamedRequirement};
use crate::warning::Warning;

/// How a run ended: data, not an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Termination {
    /// Nothing to optimize: `check`, a straight path, a path without length, a refused input.
    Done,
    /// The optimizer reached its own end.
    Converged,
    /// The iteration cap of the optimizer.
    IterationLimit,
    /// The work budget.
    WorkBudget,
    /// `stop` (deadline, cancel, vanished client).
    Stopped,
}

impl Termination {
    /// Name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Converged => "converged",
            Self::IterationLimit => "iteration-limit",
            Self::WorkBudget => "work-budget",
            Self::Stopped => "stopped",
        }
    }
}

/// A part of an optimizer that finds paths on its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stage {
    /// None: the input.
    #[default]
    Input,
    /// Straight lines for all joints at once.
    Shortcut,
    /// Straight lines for one joint at a time.
    PartialShortcut,
    /// The paper's loop.
    Gradient,
    /// The loop with contact half-spaces.
    Contact,
}

impl Stage {
    /// Every stage, in the order of the wire.
    pub const ALL: [Self; 5] = [
        Self::Input,
        Self::Shortcut,
        Self::PartialShortcut,
        Self::Gradient,
        Self::Contact,
    ];

    /// Name in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Input => "input",
            Self::Shortcut => "shortcut",
            Self::PartialShortcut => "partial-shortcut",
            Self::Gradient => "gradient",
            Self::Contact => "contact",
        }
    }
}

/// What one stage of a run did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageShare {
    /// The stage.
    pub stage: Stage,
    /// By how much it shortened the path, in the request's metric.
    pub gain: f64,
    /// Pairs that were examined for it.
    pub work: u64,
    /// Its trials.
    pub iterations: u64,
}

impl StageShare {
    /// A stage that has done nothing yet.
    pub fn new(stage: Stage) -> Self {
        Self {
            stage,
            gain: 0.0,
            work: 0,
            iterations: 0,
        }
    }
}

/// An angle column whose numbers were written anew, because a step of more than half a turn means
/// the short way round.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColumnTurns {
    /// Name of the variable.
    pub variable: String,
    /// Whole turns from the given number of the goal to the answer's; 0 where only numbers before
    /// it moved.
    pub turns: i64,
}

/// Which part of a path is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RefusalPlace {
    /// The bodies that collide first do so at the first waypoint.
    Start,
    /// They do so at the last waypoint too, wherever on the path they first meet; or they first
    /// meet on the last segment, and any bodies collide at its end.
    Goal,
    /// They do so somewhere between, whatever other bodies do at the end.
    Between,
}

/// Where and why the input is not proved: the worst thing on it. A collision anywhere goes before
/// what is too close or not provable anywhere; of all collisions it is the first along the path, to
/// within [`FINEST`](crate::validation::validator::FINEST) of its segment. Bodies that get no
/// deeper into each other than 1 µm may pass as too close. Where the run was stopped, a collision
/// need not be the first.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// Why.
    pub reason: HitReason,
    /// Whether an end of the path is what collides.
    pub place: RefusalPlace,
    /// Segment of the input path, from 0.
    pub segment: usize,
    /// Ratio on the segment.
    pub t: f64,
    /// What is not kept.
    pub requirement: NamedRequirement,
    /// How much of it is kept there, in its unit: of a clearance the distance of the bodies, or less
    /// than 0 where they overlap. The least way that parts them is then no shorter than that is
    /// below 0, and for two convex ones as long.
    pub amount: f64,
    /// The floor that it was last tried at, in its unit.
    pub allowed: f64,
    /// Where that is seen, in the world (m): of a clearance the closest or contact points.
    pub points: [Vec3; 2],
    /// Unit vector along which the first point moves for more to be kept: of a clearance from the
    /// second body towards the first.
    pub normal: Vec3,
    /// Segment + ratio before which everything is proved at the floors of the answer; 0 where
    /// nothing is known. It ends at the first thing that is not proved, which may be long before a
    /// collision.
    pub proved_prefix: f64,
    /// What the person who reads it may do; empty where there is nothing to add.
    pub hint: String,
}

/// A place of a path at which least of a requirement is kept: of a clearance, where two bodies are
/// closest.
#[derive(Clone, Debug, PartialEq)]
pub struct PathHold {
    /// Segment of the path, from 0.
    pub segment: usize,
    /// Ratio on the segment, in [0, 1].
    pub t: f64,
    /// What is kept.
    pub requirement: NamedRequirement,
    /// How much, in its unit.
    pub amount: f64,
    /// Where that is seen, in the world (m): of a clearance the closest points.
    pub points: [Vec3; 2],
    /// Unit vector along which the first point moves for more to be kept: of a clearance from the
    /// second body towards the first.
    pub normal: Vec3,
}

/// What is nearest along a path, exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct NearestHolds {
    /// How far was looked (m): where nothing is named, nothing is nearer than this.
    pub searched_m: f64,
    /// The smallest clearance and where it is.
    pub smallest: Option<PathHold>,
    /// What holds the path: for each clearance and each stretch of a segment on which less than
    /// three of its floors is kept, and for each constraint and each segment on which less than 3 % of
    /// its tolerance is left, the place where it is least; in order along the path.
    pub holds: Vec<PathHold>,
}

/// What a proved path keeps of one constraint.
#[derive(Clone, Debug, PartialEq)]
pub struct KeptConstraint {
    /// Where least was found to be left of its tolerance, as it is asked: a look, no proof. Nowhere
    /// less is left than `left` says, and here no more than this.
    pub tightest: PathHold,
    /// What is proved to be left of its tolerance, as it is asked, everywhere along the path, in its
    /// unit: below 0 where the tolerance is raised and that is needed.
    pub left: f64,
    /// The tolerance that is asked, in its unit, where one number says it: then what is read of the
    /// path is proved to be `asked − left` at most. A box has several.
    pub asked: Option<f64>,
}

/// The answer to a request. `path` is always safe to take: proved, or the input itself.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The shortest path found. No step of an angle column is longer than half a turn. Its ends are
    /// bit-equal to the input's but for the columns that are [`turned`](Self::turned).
    pub path: Path,
    /// Angle columns whose numbers are not the given ones but whole turns away, in order.
    pub turned: Vec<ColumnTurns>,
    /// Whether `path` is proved at its floors.
    pub proved: bool,
    /// Where the input is refused, if it is.
    pub refusal: Option<Refusal>,
    /// Why nothing can be proved of this robot, whatever the path; then `path` is the input.
    pub uncheckable: Option<String>,
    /// Pairs of bodies that were checked.
    pub pairs: usize,
    /// Length of the input in the request's metric.
    pub length_before: f64,
    /// Length of `path`.
    pub length_after: f64,
    /// Distance of the ends: no path is shorter.
    pub lower_bound: f64,
    /// Weights of the metric.
    pub weights: Vec<f64>,
    /// Clearance asked for (m).
    pub clearance_m: f64,
    /// Smallest floor of any pair (m).
    pub floor_m: f64,
    /// Requirements with a lowered floor.
    pub floors_lowered: Vec<LoweredFloor>,
    /// What is nearest along `path`; `None` where it is not proved or not asked for, or time was up
    /// before it was known.
    pub nearest: Option<NearestHolds>,
    /// What `path` keeps of each constraint, in their order; empty where it is not proved.
    pub keeps: Vec<KeptConstraint>,
    /// What pinches the path: no step kept all half-spaces, so that those of these gave way and the
    /// path stays as near there as it was.
    pub pinched: Vec<NamedRequirement>,
    /// Iterations of the optimizer.
    pub iterations: u64,
    /// Pairs examined at nodes.
    pub work: u64,
    /// The stage that found `path`.
    pub stage: Stage,
    /// What each stage of the optimizer did, in the order in which they first came.
    pub stages: Vec<StageShare>,
    /// How the run ended.
    pub termination: Termination,
    /// What a person should know of the request; what robot and scene told when they were read is
    /// not among it.
    pub warnings: Vec<Warning>,
    /// How far what is executed may stray from `path`; `None` where it is not proved or not asked
    /// for.
    pub corridor: Option<crate::validation::Corridor>,
    /// The proof in short; `None` where `path` is not proved.
    pub certificate: Option<crate::validation::Certificate>,
}

impl Outcome {
    /// By which part of the lower bound `path` is longer than it; `None` where that bound is 0.
    pub fn gap(&self) -> Option<f64> {
        (self.lower_bound > 0.0).then(|| self.length_after / self.lower_bound - 1.0)
    }
}

//! What is told of an input that is refused.

use super::input::Input;
use super::nearest;
use super::outcome::{Refusal, RefusalPlace};
use crate::path::Path;
use crate::validation::{
    Contact, Hit, HitReason, Measure, NamedRequirement, Requirement, Validator,
};

pub(super) fn refusal(
    validator: &mut Validator,
    input: &Input,
    segment: usize,
    hit: &Hit,
    proved_prefix: f64,
) -> Refusal {
    let place = place(validator, &input.path, segment, hit);
    let measure = measure(validator, &input.path, segment, hit);
    let proved_segments = proved_prefix.floor();
    let proved_t = proved_prefix - proved_segments;
    let proved = callers_segment(input, proved_segments as usize, proved_t);
    Refusal {
        place,
        segment: callers_segment(input, segment, hit.t),
        t: hit.t,
        proved_prefix: proved as f64 + proved_t,
        allowed: validator.floors().of(hit.requirement),
        ..at_start(hit.reason, validator.named(hit.requirement), &measure)
    }
    .with_reading(validator, hit.requirement)
    .with_cell(validator, hit.requirement, ends(&input.path, segment))
}

/// What a cloud that is met where the robot stands may mean.
const IN_PICTURE: &str = "; if the sensor saw the robot itself, say where its joints stood then (at), and what lies on it is left out";

/// The ends of a segment; of a path of one waypoint, both are that.
fn ends(path: &Path, segment: usize) -> [&[f64]; 2] {
    [segment, (segment + 1).min(path.len() - 1)].map(|end| path.waypoint(end))
}

impl Refusal {
    /// The same with the point or voxel that is met, where one of the bodies is a cloud.
    fn with_cell(
        self,
        validator: &mut Validator,
        requirement: Requirement,
        ends: [&[f64]; 2],
    ) -> Self {
        match validator.cell_at(requirement, ends, self.t, self.points) {
            Some(cell) => {
                let at_start = match self.place {
                    RefusalPlace::Start => IN_PICTURE,
                    RefusalPlace::Goal | RefusalPlace::Between => "",
                };
                Self {
                    hint: format!("it is {cell}{at_start}"),
                    ..self
                }
            }
            None => self,
        }
    }

    /// The same with what is read of a constraint and what is allowed, where there is nothing else to
    /// add.
    fn with_reading(self, validator: &Validator, requirement: Requirement) -> Self {
        let Requirement::Constraint(index) = requirement else {
            return self;
        };
        let held = &validator.constraints()[index].held;
        let unit = self.requirement.unit.name();
        match held.reading(self.amount) {
            Some((is, allowed)) => Self {
                hint: format!("{is:.5} {unit}, allowed {allowed}"),
                ..self
            },
            None => self,
        }
    }
}

/// A waypoint that must stay as it is, outside of a constraint.
pub(super) fn outside(
    validator: &Validator,
    input: &Input,
    (waypoint, requirement, measure): (usize, Requirement, Measure),
) -> Refusal {
    let callers = input.origins[waypoint];
    let segment = callers.saturating_sub(1);
    let t = if waypoint == 0 { 0.0 } else { 1.0 };
    let refusal = Refusal {
        place: match waypoint {
            0 => RefusalPlace::Start,
            last if last + 1 == input.path.len() => RefusalPlace::Goal,
            _ => RefusalPlace::Between,
        },
        segment,
        t,
        allowed: validator.floors().of(requirement),
        ..at_start(HitReason::Outside, validator.named(requirement), &measure)
    };
    refusal.with_reading(validator, requirement)
}

/// Which end a collision is at, if it is at one.
fn place(validator: &mut Validator, path: &Path, segment: usize, hit: &Hit) -> RefusalPlace {
    let start = path.waypoint(0);
    let goal = path.waypoint(path.len() - 1);
    let is_on_last_segment = segment + 2 >= path.len();
    if hit.reason != HitReason::Collision {
        RefusalPlace::Between
    } else if validator.is_broken_at(hit.requirement, start) {
        RefusalPlace::Start
    } else if validator.is_broken_at(hit.requirement, goal)
        || (is_on_last_segment && validator.collides(goal))
    {
        RefusalPlace::Goal
    } else {
        RefusalPlace::Between
    }
}

/// How deep the bodies are in each other, where they are.
fn measure(validator: &mut Validator, path: &Path, segment: usize, hit: &Hit) -> Measure {
    match hit.reason {
        HitReason::Collision => {
            validator.measure_depth(hit.requirement, ends(path, segment), hit.t)
        }
        HitReason::TooClose | HitReason::Uncertified | HitReason::Outside => hit.measure,
    }
}

/// The segment of the caller's path that a place of the optimizers' form lies on.
fn callers_segment(input: &Input, segment: usize, t: f64) -> usize {
    // Nothing is proved, not even that the robot may stand where it starts.
    if (segment, t) == (0, 0.0) {
        return 0;
    }
    let segments = nearest::segments_of(&input.standing_for);
    let known = segments.get(segment).copied();
    known.unwrap_or(input.standing_for.len() - 1)
}

/// A refusal at the start, of which no more is known than how much is kept there.
fn at_start(reason: HitReason, requirement: NamedRequirement, measure: &Measure) -> Refusal {
    Refusal {
        reason,
        place: RefusalPlace::Start,
        segment: 0,
        t: 0.0,
        requirement,
        amount: measure.amount,
        allowed: 0.0,
        points: measure.points,
        normal: measure.normal,
        proved_prefix: 0.0,
        hint: String::new(),
    }
}

/// A link that no joint moves stands in an obstacle, where so much clearance is asked for (m).
pub(super) fn standing_overlap(bodies: [String; 2], contact: Contact, allowed: f64) -> Refusal {
    let [link, object] = &bodies;
    let hint = format!(
        "no joint moves {link}; if it may touch {object}, add [\"{link}\", \"{object}\"] to allowed_collisions"
    );
    let requirement = NamedRequirement::clearance(bodies);
    Refusal {
        hint,
        allowed,
        ..at_start(HitReason::Collision, requirement, &contact.into())
    }
}

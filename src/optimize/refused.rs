//! What is told of an input that is refused.

use super::input::Input;
use super::nearest;
use super::outcome::{Refusal, RefusalPlace};
use crate::path::Path;
use crate::validation::{Contact, Hit, HitReason, Validator};

pub(super) fn refusal(
    validator: &mut Validator,
    input: &Input,
    segment: usize,
    hit: &Hit,
    proved_prefix: f64,
) -> Refusal {
    let place = place(validator, &input.path, segment, hit);
    let contact = contact(validator, &input.path, segment, hit);
    let proved_segments = proved_prefix.floor();
    let proved_t = proved_prefix - proved_segments;
    let proved = callers_segment(input, proved_segments as usize, proved_t);
    Refusal {
        place,
        segment: callers_segment(input, segment, hit.t),
        t: hit.t,
        proved_prefix: proved as f64 + proved_t,
        ..touching(hit.reason, validator.model().pair_names(hit.pair), &contact)
    }
}

/// Which end a collision is at, if it is at one.
fn place(validator: &mut Validator, path: &Path, segment: usize, hit: &Hit) -> RefusalPlace {
    let start = path.waypoint(0);
    let goal = path.waypoint(path.len() - 1);
    let is_on_last_segment = segment + 2 >= path.len();
    if hit.reason != HitReason::Collision {
        RefusalPlace::Between
    } else if validator.touches(hit.pair, start) {
        RefusalPlace::Start
    } else if validator.touches(hit.pair, goal) || (is_on_last_segment && validator.collides(goal))
    {
        RefusalPlace::Goal
    } else {
        RefusalPlace::Between
    }
}

/// How deep the bodies are in each other, where they are.
fn contact(validator: &mut Validator, path: &Path, segment: usize, hit: &Hit) -> Contact {
    let from = path.waypoint(segment);
    let to = path.waypoint((segment + 1).min(path.len() - 1));
    match hit.reason {
        HitReason::Collision => validator.penetration(hit.pair, from, to, hit.t),
        HitReason::TooClose | HitReason::Uncertified => hit.contact,
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

/// A refusal at the start, of which no more is known than where two bodies touch.
fn touching(reason: HitReason, bodies: [String; 2], contact: &Contact) -> Refusal {
    Refusal {
        reason,
        place: RefusalPlace::Start,
        segment: 0,
        t: 0.0,
        points: [contact.point_a, contact.point_b],
        normal: contact.normal,
        depth_m: -contact.distance,
        proved_prefix: 0.0,
        hint: String::new(),
        bodies,
    }
}

/// A link that no joint moves stands in an obstacle.
pub(super) fn standing_overlap(bodies: [String; 2], contact: Contact) -> Refusal {
    let [link, object] = &bodies;
    let hint = format!(
        "no joint moves {link}; if it may touch {object}, add [\"{link}\", \"{object}\"] to allowed_collisions"
    );
    Refusal {
        hint,
        ..touching(HitReason::Collision, bodies, &contact)
    }
}

//! What is told of an input that is refused.

use super::input::Input;
use super::nearest;
use super::outcome::{Refusal, RefusalPlace};
use crate::validation::{Contact, Hit, HitReason, Validator};

pub(super) fn refusal(
    validator: &mut Validator,
    input: &Input,
    segment: usize,
    hit: &Hit,
    proved_prefix: f64,
) -> Refusal {
    let model = validator.model();
    let path = &input.path;
    let start = path.waypoint(0);
    let goal = path.waypoint(path.len() - 1);
    let is_on_last_segment = segment + 2 >= path.len();
    let place = if hit.reason != HitReason::Collision {
        RefusalPlace::Between
    } else if validator.touches(hit.pair, start) {
        RefusalPlace::Start
    } else if validator.touches(hit.pair, goal) || (is_on_last_segment && validator.collides(goal))
    {
        RefusalPlace::Goal
    } else {
        RefusalPlace::Between
    };
    let from = path.waypoint(segment);
    let to = path.waypoint((segment + 1).min(path.len() - 1));
    let contact = match hit.reason {
        HitReason::Collision => validator.penetration(hit.pair, from, to, hit.t),
        HitReason::TooClose | HitReason::Uncertified => hit.contact,
    };
    let segments = nearest::segments_of(&input.standing_for);
    let callers = |segment: usize, t: f64| match (segment, t) {
        // Nothing is proved, not even that the robot may stand where it starts.
        (0, 0.0) => 0,
        _ => segments
            .get(segment)
            .copied()
            .unwrap_or(input.standing_for.len() - 1),
    };
    let proved_segments = proved_prefix.floor();
    let proved_t = proved_prefix - proved_segments;
    Refusal {
        reason: hit.reason,
        place,
        segment: callers(segment, hit.t),
        t: hit.t,
        bodies: model.pair_names(hit.pair),
        points: [contact.point_a, contact.point_b],
        normal: contact.normal,
        depth_m: -contact.distance,
        proved_prefix: callers(proved_segments as usize, proved_t) as f64 + proved_t,
        hint: String::new(),
    }
}

/// A link that no joint moves stands in an obstacle.
pub(super) fn standing_overlap(bodies: [String; 2], contact: Contact) -> Refusal {
    let [link, object] = &bodies;
    let hint = format!(
        "no joint moves {link}; if it may touch {object}, add [\"{link}\", \"{object}\"] to allowed_collisions"
    );
    Refusal {
        reason: HitReason::Collision,
        place: RefusalPlace::Start,
        segment: 0,
        t: 0.0,
        points: [contact.point_a, contact.point_b],
        normal: contact.normal,
        depth_m: -contact.distance,
        proved_prefix: 0.0,
        hint,
        bodies,
    }
}

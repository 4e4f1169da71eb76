//! What tells two versions of a scene apart where things only moved.

use std::sync::Arc;

use taut::scene::{Obstacle, Scene};

use super::plain::PoseRecord;

/// Objects that went elsewhere: their numbers among all objects, those that stand first, and their
/// poses.
pub(crate) type Moves = Vec<(u32, PoseRecord)>;

/// The objects that are elsewhere in `after`, if nothing else differs from `before`.
pub(crate) fn moves_between(before: &Scene, after: &Scene) -> Option<Moves> {
    let may_only_have_moved =
        is_same_but_for_objects(before, after) && have_same_carriers(before, after);
    if may_only_have_moved {
        moves(before, after)
    } else {
        None
    }
}

fn moves(before: &Scene, after: &Scene) -> Option<Moves> {
    let mut moves = Moves::new();
    for (index, (a, b)) in before
        .objects()
        .zip(after.objects())
        .enumerate()
    {
        if !is_same_thing(a, b) {
            return None;
        }
        if a.pose != b.pose {
            moves.push((u32::try_from(index).ok()?, b.pose.into()));
        }
    }
    Some(moves)
}

fn is_same_thing(a: &Obstacle, b: &Obstacle) -> bool {
    a.id == b.id && a.sensed == b.sensed && Arc::ptr_eq(&a.shapes, &b.shapes)
}

fn is_same_but_for_objects(before: &Scene, after: &Scene) -> bool {
    before.name() == after.name()
        && before.obstacles().len() == after.obstacles().len()
        && before.attached().len() == after.attached().len()
        && before.warnings() == after.warnings()
        && have_same_frames(before, after)
        && have_same_rules(before, after)
}

fn have_same_frames(before: &Scene, after: &Scene) -> bool {
    before.frames().eq(after.frames())
        && before.subframes().eq(after.subframes())
        && before.worlds().eq(after.worlds())
}

fn have_same_rules(before: &Scene, after: &Scene) -> bool {
    before.padded().eq(after.padded())
        && before.scaled().eq(after.scaled())
        && before.allowed().eq(after.allowed())
        && before.forbidden().eq(after.forbidden())
}

fn have_same_carriers(before: &Scene, after: &Scene) -> bool {
    let mut attached = before.attached().iter().zip(after.attached());
    attached.all(|(a, b)| a.link_name == b.link_name && a.touch_links == b.touch_links)
}

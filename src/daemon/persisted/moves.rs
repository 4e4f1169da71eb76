//! What tells two versions of a scene apart where things only moved.

use std::sync::Arc;

use taut::scene::{AttachedObject, Scene};

use super::plain::PoseRecord;

/// Objects that went elsewhere: their numbers among all objects, those that stand first, and their
/// poses.
pub(in crate::daemon) type Moves = Vec<(u32, PoseRecord)>;

/// The objects that are elsewhere in `after`, if nothing else differs from `before`.
pub(in crate::daemon) fn moves_between(before: &Scene, after: &Scene) -> Option<Moves> {
    let same_lists = before.obstacles().len() == after.obstacles().len()
        && before.attached().len() == after.attached().len()
        && before.name() == after.name()
        && before.padded().eq(after.padded())
        && before.scaled().eq(after.scaled())
        && before.frames().eq(after.frames())
        && before.subframes().eq(after.subframes())
        && before.worlds().eq(after.worlds())
        && before.allowed().eq(after.allowed())
        && before.forbidden().eq(after.forbidden())
        && before.warnings() == after.warnings();
    let attached = before.attached().iter().zip(after.attached());
    let same_carriers = |(a, b): (&AttachedObject, &AttachedObject)| {
        a.link_name == b.link_name && a.touch_links == b.touch_links
    };
    if !same_lists || !attached.into_iter().all(same_carriers) {
        return None;
    }
    let mut moves = Moves::new();
    for (index, (a, b)) in before.objects().zip(after.objects()).enumerate() {
        if a.id != b.id || !Arc::ptr_eq(&a.shapes, &b.shapes) {
            return None;
        }
        if a.pose != b.pose {
            moves.push((u32::try_from(index).ok()?, b.pose.into()));
        }
    }
    Some(moves)
}

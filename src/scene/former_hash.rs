//! The content hash as it was before versions shared what changes leave: certificates of those days
//! name scenes by it.

use super::{AttachedObject, Obstacle, Scene, Verdict};
use crate::hash::ContentHasher;
use crate::math::Pose;

impl Scene {
    /// Content hash that earlier builds gave the scene; `None` where it has what they did not know
    /// (a scale, frames, what sensors see). It reads all of the scene.
    pub fn former_hash(&self) -> Option<u64> {
        let is_newer = [
            self.frames().next().is_some(),
            self.subframes().next().is_some(),
            self.worlds().next().is_some(),
            self.sensed().next().is_some(),
        ];
        if self.scaled().next().is_some() || is_newer.contains(&true) {
            return None;
        }
        let mut hasher = ContentHasher::default();
        for obstacle in &self.obstacles {
            hash_object(&mut hasher, obstacle);
        }
        let pairs = |hasher: &mut ContentHasher, pairs: &[(&str, &str)]| {
            for (a, b) in pairs {
                hasher.text(a).text(b);
            }
        };
        pairs(&mut hasher, &self.verdicts.as_told(Verdict::Allowed));
        if !self.attached.is_empty() {
            hasher
                .text("attached")
                .count(self.attached.len());
        }
        for AttachedObject {
            link_name,
            object,
            touch_links,
        } in &self.attached
        {
            hasher.text(link_name).count(touch_links.len());
            for name in touch_links {
                hasher.text(name);
            }
            hash_object(&mut hasher, object);
        }
        let padded: Vec<_> = self.padded().collect();
        if !padded.is_empty() {
            hasher.text("padding").count(padded.len());
        }
        for (name, padding) in padded {
            hasher.text(name).floats(&[padding]);
        }
        let forbidden = self.verdicts.as_told(Verdict::Forbidden);
        if !forbidden.is_empty() {
            hasher.text("forbidden").count(forbidden.len());
        }
        pairs(&mut hasher, &forbidden);
        Some(hasher.finish())
    }
}

fn hash_object(hasher: &mut ContentHasher, object: &Obstacle) {
    hasher.text(&object.id);
    if object.pose != Pose::identity() {
        hasher.text("pose").pose(&object.pose);
    }
    for shape in object.shapes.iter() {
        shape.tell(hasher);
    }
}

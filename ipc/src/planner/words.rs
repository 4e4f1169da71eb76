//! Changes of a scene as the text of a diff, in MoveIt's words.

use serde_json::{Value, json};

/// Where something stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// x y z, in metres.
    pub position: [f64; 3],
    /// Unit quaternion x y z w.
    pub orientation: [f64; 4],
}

impl Pose {
    /// Upright at a position.
    pub fn at(position: [f64; 3]) -> Self {
        Self {
            position,
            orientation: [0.0, 0.0, 0.0, 1.0],
        }
    }

    fn json(&self) -> Value {
        let [x, y, z, w] = self.orientation;
        json!({ "position": self.position, "orientation": { "x": x, "y": y, "z": z, "w": w } })
    }
}

/// Moves an object of the world; or, with a link, one that the link carries, the pose in the link's
/// frame.
pub fn moved(object: &str, link: Option<&str>, pose: &Pose) -> String {
    let moved = json!({ "id": object, "operation": "MOVE", "pose": pose.json() });
    match link {
        None => diff(json!({ "objects": [moved] })),
        Some(link) => {
            diff(json!({ "attached_collision_objects": [{ "link_name": link, "object": moved }] }))
        }
    }
}

/// Lets a link carry an object of the world, its pose in the link's frame; it may touch the link
/// and what is named.
pub fn attached(object: &str, link: &str, pose: &Pose, touch_links: &[String]) -> String {
    let object = json!({ "id": object, "operation": "ADD", "pose": pose.json() });
    diff(
        json!({ "attached_collision_objects": [{ "link_name": link, "touch_links": touch_links, "object": object }] }),
    )
}

/// Puts an attached object down, its pose in the world.
pub fn detached(object: &str, pose: &Pose) -> String {
    let object = json!({ "id": object, "operation": "REMOVE", "pose": pose.json() });
    diff(json!({ "attached_collision_objects": [{ "object": object }] }))
}

/// Takes an object out of the world.
pub fn removed(object: &str) -> String {
    diff(json!({ "objects": [{ "id": object, "operation": "REMOVE" }] }))
}

fn diff(mut diff: Value) -> String {
    diff["is_diff"] = true.into();
    diff.to_string()
}

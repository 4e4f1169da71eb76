//! Scenes that nodes say, and MoveIt's, which is followed.

use crate::cell::{Cell, request};
use crate::world::common::until;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use taut_ros::Bounded;
use taut_ros::Byte;
use taut_ros::messages::geometry_msgs::{Point, Pose, TransformStamped};
use taut_ros::messages::moveit_msgs::{
    AllowedCollisionEntry, AllowedCollisionMatrix, ApplyPlanningScene, ApplyPlanningSceneRequest,
    AttachedCollisionObject, CollisionObject, GetPlanningScene, GetPlanningSceneResponse,
    LinkPadding, LinkScale, PlanningScene,
};
use taut_ros::messages::shape_msgs::{Mesh, MeshTriangle, Plane, SolidPrimitive};

const ADD: u8 = 0;
const REMOVE: u8 = 1;
const BOX: u8 = 1;

fn at(x: f64, y: f64) -> Pose {
    let mut pose = Pose::default();
    pose.position.x = x;
    pose.position.y = y;
    pose.orientation.w = 1.0;
    pose
}

/// A pillar across the path of `corner`.
pub fn pillar(operation: u8) -> CollisionObject {
    let primitive = SolidPrimitive {
        r#type: BOX,
        dimensions: Bounded(vec![0.1, 0.1, 1.0]),
        ..SolidPrimitive::default()
    };
    let mut pillar = CollisionObject {
        id: "pillar".to_owned(),
        operation: Byte(operation),
        ..CollisionObject::default()
    };
    pillar.pose.orientation.w = 1.0;
    if operation == ADD {
        pillar.primitives = vec![primitive];
        pillar.primitive_poses = vec![at(-1.0, -0.4)];
    }
    pillar
}

fn scene(is_diff: bool, objects: Vec<CollisionObject>) -> PlanningScene {
    let mut scene = PlanningScene {
        is_diff,
        ..PlanningScene::default()
    };
    scene.robot_state.is_diff = is_diff;
    scene.world.collision_objects = objects;
    scene
}

fn apply(cell: &Cell, scene: PlanningScene) -> bool {
    let request = ApplyPlanningSceneRequest { scene };
    let name = "/taut/apply_planning_scene";
    cell.node
        .call::<ApplyPlanningScene>(name, &request)
        .success
}

#[test]
fn a_scene_that_is_applied_changes_the_verdict() {
    let Some(cell) = Cell::of("corner") else {
        return;
    };
    let corner = request("corner");
    assert_eq!(cell.verdict(&corner).0, 1);
    assert!(apply(&cell, scene(true, vec![pillar(ADD)])));
    let (code, text) = cell.verdict(&corner);
    assert_eq!(code, -2, "{text}");
    for word in ["pillar", "bar", "segment"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    // Unknown, so nothing of it is made.
    let mut unknown = pillar(REMOVE);
    unknown.id = "vase".to_owned();
    assert!(!apply(&cell, scene(true, vec![pillar(REMOVE), unknown])));
    assert_eq!(cell.verdict(&corner).0, -2);
    assert!(apply(&cell, scene(true, vec![pillar(REMOVE)])));
    assert_eq!(cell.verdict(&corner).0, 1);
    let mut whole = pillar(ADD);
    whole.primitive_poses = vec![at(5.0, 5.0)];
    assert!(apply(&cell, scene(false, vec![whole])));
    let (code, text) = cell.verdict(&corner);
    // The walls are gone.
    assert_eq!(code, 1);
    assert!(!text.contains("inner"), "{text}");
}

/// A whole scene with all that MoveIt's have, in which the bar may touch the pillar, or not.
fn full(may_touch: bool) -> PlanningScene {
    let mut scene = scene(false, vec![pillar(ADD), tetrahedron()]);
    scene.name = "(noname)".to_owned();
    scene.robot_model_name = "bar".to_owned();
    let mut world = TransformStamped {
        child_frame_id: "world".to_owned(),
        ..TransformStamped::default()
    };
    world.header.frame_id = "world".to_owned();
    world.transform.rotation.w = 1.0;
    scene.fixed_frame_transforms = vec![world];
    let names = ["bar", "pillar", "<octomap>"];
    let row = |enabled: [bool; 3]| AllowedCollisionEntry {
        enabled: enabled.to_vec(),
    };
    scene.allowed_collision_matrix = AllowedCollisionMatrix {
        entry_names: names.map(str::to_owned).to_vec(),
        entry_values: vec![
            row([false, may_touch, false]),
            row([may_touch, false, false]),
            row([false, false, false]),
        ],
        default_entry_names: vec!["<octomap>".to_owned()],
        default_entry_values: vec![true],
    };
    scene.link_padding = vec![LinkPadding {
        link_name: "bar".to_owned(),
        padding: 0.0,
    }];
    scene.link_scale = vec![LinkScale {
        link_name: "bar".to_owned(),
        scale: 1.0,
    }];
    scene.robot_state.joint_state.name = vec!["x".to_owned()];
    scene.robot_state.joint_state.position = vec![0.5];
    scene.robot_state.attached_collision_objects = vec![tool()];
    scene.world.octomap.header.frame_id = "world".to_owned();
    scene.world.octomap.origin.orientation.w = 1.0;
    scene
}

fn tetrahedron() -> CollisionObject {
    let corner = |x, y, z| Point { x, y, z };
    let side = |corners| MeshTriangle {
        vertex_indices: corners,
    };
    let mesh = Mesh {
        triangles: [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
            .map(side)
            .to_vec(),
        vertices: vec![
            corner(0.0, 0.0, 0.0),
            corner(0.1, 0.0, 0.0),
            corner(0.0, 0.1, 0.0),
            corner(0.0, 0.0, 0.1),
        ],
    };
    let mut object = pillar(REMOVE);
    object.id = "rock".to_owned();
    object.operation = Byte(ADD);
    object.header.frame_id = "world".to_owned();
    object.meshes = vec![mesh];
    object.mesh_poses = vec![at(6.0, 6.0)];
    object
}

/// Inside of the bar: it meets what the bar meets.
fn tool() -> AttachedCollisionObject {
    let mut object = pillar(ADD);
    object.id = "tool".to_owned();
    object.header.frame_id = "bar".to_owned();
    object.primitives[0].dimensions = Bounded(vec![0.01, 0.01, 0.01]);
    object.primitive_poses = vec![at(0.0, 0.0)];
    AttachedCollisionObject {
        link_name: "bar".to_owned(),
        object,
        touch_links: vec!["bar".to_owned()],
        ..AttachedCollisionObject::default()
    }
}

#[test]
fn a_whole_scene_has_all_that_moveits_have() {
    let Some(cell) = Cell::of("corner") else {
        return;
    };
    let corner = request("corner");
    assert!(apply(&cell, full(true)));
    let (code, text) = cell.verdict(&corner);
    // What the bar carries may not touch it.
    assert_eq!(code, -2, "{text}");
    assert!(text.contains("tool"), "{text}");
    let mut without = full(true);
    without
        .robot_state
        .attached_collision_objects
        .clear();
    assert!(apply(&cell, without));
    let (code, text) = cell.verdict(&corner);
    assert_eq!(code, 1, "{text}");
    let mut without = full(false);
    without
        .robot_state
        .attached_collision_objects
        .clear();
    assert!(apply(&cell, without));
    let (code, text) = cell.verdict(&corner);
    assert_eq!(code, -2, "{text}");
    let mut plane = full(true);
    plane.world.collision_objects[0].planes = vec![Plane::default()];
    assert!(!apply(&cell, plane));
}

#[test]
fn numbers_that_are_none_are_refused() {
    let Some(cell) = Cell::of("corner") else {
        return;
    };
    let mut object = pillar(ADD);
    object.primitive_poses[0].position.x = f64::NAN;
    assert!(!apply(&cell, scene(true, vec![object])));
    assert_eq!(cell.verdict(&request("corner")).0, 1);
}

/// MoveIt's scene is what stands in for it says: the whole first, then its changes; a change that is
/// lost makes the whole come again.
#[test]
fn moveits_scene_is_followed() {
    let Some(cell) = Cell::with("corner", |options| options.follows = true) else {
        return;
    };
    let corner = request("corner");
    let (code, text) = cell.verdict(&corner);
    assert_eq!(code, 1);
    assert!(text.contains("the scene is not MoveIt's"), "{text}");
    let asked = Arc::new(AtomicUsize::new(0));
    let count = asked.clone();
    cell.node
        .serve::<GetPlanningScene>("/get_planning_scene", move |request| {
            assert_eq!(request.components.components, 0x3ff);
            count.fetch_add(1, Ordering::SeqCst);
            GetPlanningSceneResponse {
                scene: scene(false, vec![pillar(ADD)]),
            }
        });
    until("the whole is there", || {
        let (code, text) = cell.verdict(&corner);
        code == -2 && !text.contains("not MoveIt's")
    });
    let publish = |operation| {
        let scene = scene(true, vec![pillar(operation)]);
        cell.node
            .publish("/monitored_planning_scene", &scene);
    };
    publish(REMOVE);
    until("a change is made", || cell.verdict(&corner).0 == 1);
    publish(ADD);
    until("another is made", || cell.verdict(&corner).0 == -2);
    let before = asked.load(Ordering::SeqCst);
    cell.node.skip();
    publish(REMOVE);
    until("the whole is fetched again", || {
        asked.load(Ordering::SeqCst) > before && cell.verdict(&corner).0 == -2
    });
    assert!(!cell.verdict(&corner).1.contains("not MoveIt's"));
    // Of an object that is not there: not the scene that is followed any more.
    publish(REMOVE);
    until("a change is made", || cell.verdict(&corner).0 == 1);
    let before = asked.load(Ordering::SeqCst);
    publish(REMOVE);
    until("what is refused makes the whole come again", || {
        asked.load(Ordering::SeqCst) > before && cell.verdict(&corner).0 == -2
    });
}

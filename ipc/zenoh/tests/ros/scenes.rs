//! Scenes that nodes say, and MoveIt's, which is followed.

use crate::cell::{Cell, request};
use crate::world::common::until;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use taut_ros::Bounded;
use taut_ros::Byte;
use taut_ros::messages::geometry_msgs::Pose;
use taut_ros::messages::moveit_msgs::{
    ApplyPlanningScene, ApplyPlanningSceneRequest, CollisionObject, GetPlanningScene,
    GetPlanningSceneResponse, PlanningScene,
};
use taut_ros::messages::shape_msgs::SolidPrimitive;

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

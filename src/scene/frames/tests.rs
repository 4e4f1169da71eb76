//! Frames of whole scenes, and of the same objects one by one.

use super::super::diff_file::{DiffFile, SceneDiff};
use super::super::scene_file;
use super::*;
use crate::math::{Quat, Vec3};
use crate::shape::MeshError;

fn read(fields: &str) -> Result<Scene, SceneError> {
    let mut none = |name: &str, _| {
        Err(MeshError::Unreadable {
            name: name.to_owned(),
            reason: "none".to_owned(),
        })
    };
    scene_file::parse(&format!("{{ {fields} }}"), &mut none)
}

/// A ball of 0.1 m at `shape` in the frame of an object, which is at `pose` (left out where empty)
/// in `frame`.
fn object(id: &str, frame: &str, pose: &str, shape: [f64; 3]) -> String {
    let pose = if pose.is_empty() {
        String::new()
    } else {
        format!(r#""pose": {{ "position": {pose} }}, "#)
    };
    format!(
        r#"{{ "id": "{id}", "header": {{ "frame_id": "{frame}" }}, {pose}"primitives": [{{ "type": "sphere",
            "dimensions": [0.1] }}], "primitive_poses": [{{ "position": {shape:?} }}] }}"#
    )
}

fn scene(objects: &[String]) -> Result<Scene, SceneError> {
    read(&format!(r#""objects": [{}]"#, objects.join(",")))
}

/// Where the first shape of an object is in the world.
fn shape_of(scene: &Scene, id: &str) -> Vec3 {
    let object = scene.object(id).unwrap();
    (object.pose * object.shapes[0].pose).translation
}

fn diff(objects: &str) -> SceneDiff {
    let text = format!(r#"{{ "is_diff": true, "objects": [{objects}] }}"#);
    DiffFile::parse(&text)
        .and_then(SceneDiff::try_from)
        .unwrap()
}

#[test]
fn objects_are_placed_by_one_another_in_any_order() {
    let chain = [
        object("a", "b", "[0, 0, 1]", [0.0; 3]),
        object("b", "/c", "[0, 1, 0]", [0.0; 3]),
        object("c", "", "[1, 0, 0]", [0.0; 3]),
    ];
    for order in [[0, 1, 2], [2, 1, 0], [1, 0, 2], [0, 2, 1]] {
        let made = scene(&order.map(|index| chain[index].clone())).unwrap();
        assert_eq!(
            ["a", "b", "c"].map(|id| shape_of(&made, id)),
            [Vec3::ONE, Vec3::new(1.0, 1.0, 0.0), Vec3::X]
        );
    }
    // Thousands of them need no deep stack.
    let long = |id: usize| {
        object(
            &format!("o{id}"),
            &format!("o{}", id + 1),
            "[1, 0, 0]",
            [0.0; 3],
        )
    };
    let mut objects: Vec<String> = (0..20_000).map(long).collect();
    objects.push(object("o20000", "", "[1, 0, 0]", [0.0; 3]));
    assert_eq!(shape_of(&scene(&objects).unwrap(), "o0").x, 20_001.0);
}

#[test]
fn a_circle_of_frames_is_refused() {
    for (objects, ids) in [
        (vec![object("a", "a", "[1, 0, 0]", [0.0; 3])], "\"a\""),
        (
            vec![
                object("a", "b", "", [0.0; 3]),
                object("b", "/a", "", [0.0; 3]),
            ],
            "\"a\" → \"b\"",
        ),
    ] {
        let text = scene(&objects).unwrap_err().to_string();
        assert!(text.contains(ids) && text.contains("circle"), "{text}");
    }
    let itself =
        diff(&object("a", "a", "[1, 0, 0]", [0.0; 3]).replacen('{', r#"{ "operation": "ADD","#, 1));
    let before = scene(&[object("a", "", "[1, 0, 0]", [0.0; 3])]).unwrap();
    assert!(
        itself
            .apply(&before)
            .unwrap_err()
            .to_string()
            .contains("circle")
    );
}

#[test]
fn sub_frames_have_any_names_and_turn_with_their_object() {
    let turn = Quat::from_rotation_z(std::f64::consts::FRAC_PI_2);
    let turned = format!(r#"{{ "x": 0, "y": 0, "z": {}, "w": {} }}"#, turn.z, turn.w);
    let table = format!(
        r#"{{ "id": "big table/1", "pose": {{ "position": [1, 0, 0], "orientation": {turned} }}, "primitives": [],
            "subframe_names": ["left handle", "a/b"],
            "subframe_poses": [{{ "position": [1, 0, 0] }}, {{ "position": [2, 0, 0] }}] }}"#
    );
    for (frame, y) in [
        ("big table/1/left handle", 1.0),
        ("/big table/1/a/b", 2.0),
        ("big table/1", 0.0),
    ] {
        let cup = object("cup", frame, "[0, 0, 0.5]", [0.0; 3]);
        let made = scene(&[cup.clone(), table.clone()]).unwrap();
        assert!(
            (shape_of(&made, "cup") - Vec3::new(1.0, y, 0.5)).length() < 1e-12,
            "{frame}"
        );
        let before = scene(std::slice::from_ref(&table)).unwrap();
        let after = diff(&cup.replacen('{', r#"{ "operation": "ADD","#, 1))
            .apply(&before)
            .unwrap();
        assert_eq!(shape_of(&after, "cup"), shape_of(&made, "cup"), "{frame}");
    }
    let made = scene(&[
        table.clone(),
        object("cup", "big table/1/right handle", "", [0.0; 3]),
    ])
    .unwrap();
    assert_eq!(
        made.world_of("cup"),
        Some("big table/1/right handle"),
        "no robot calls the world so"
    );
    let before = scene(&[table]).unwrap();
    let typo = diff(&object("cup", "big table/1/lid", "", [0.0; 3]).replacen(
        '{',
        r#"{ "operation": "ADD","#,
        1,
    ));
    let text = typo.apply(&before).unwrap_err().to_string();
    assert!(
        text.contains("no frame") && text.contains("big table/1/left handle, big table/1/a/b")
            || text.contains("a/b, big table/1/left handle"),
        "{text}"
    );
}

/// MoveIt takes the pose of an object's one shape for the object's where that is not set.
#[test]
fn an_object_whose_pose_is_not_set_has_its_frame_at_its_one_shape() {
    let table = object("table", "", "", [0.6, 0.5, 0.0]);
    let cup = object("cup", "table", "[0, 0, 0.2]", [0.0; 3]);
    let made = scene(&[cup.clone(), table.clone()]).unwrap();
    assert!((shape_of(&made, "cup") - Vec3::new(0.6, 0.5, 0.2)).length() < 1e-12);
    let before = scene(std::slice::from_ref(&table)).unwrap();
    assert_eq!(
        before
            .in_world("table", &Pose::identity())
            .unwrap()
            .translation,
        Vec3::new(0.6, 0.5, 0.0)
    );
    let moved =
        diff(r#"{ "id": "table", "operation": "MOVE", "pose": { "position": [0, 0, 3] } }"#)
            .apply(&before);
    assert_eq!(shape_of(&moved.unwrap(), "table"), Vec3::Z * 3.0);
    // What is then moved to the origin stays an object whose pose is set.
    let text = r#"{ "id": "table", "operation": "MOVE", "pose": {} }"#;
    let twice = format!(
        r#"{text}, {{ "id": "table", "operation": "MOVE", "pose": {{ "position": [1, 0, 0] }} }}"#
    );
    assert_eq!(
        shape_of(&diff(&twice).apply(&before).unwrap(), "table"),
        Vec3::X
    );
    let set = table.replace(
        r#""primitives""#,
        r#""pose": { "position": [0, 0, 1] }, "primitives""#,
    );
    let at_origin = diff(&twice)
        .apply(&scene(&[set]).unwrap())
        .unwrap();
    assert_eq!(shape_of(&at_origin, "table"), Vec3::new(1.6, 0.5, 0.0));
    // More shapes come in the object's frame.
    let more =
        object("table", "", "", [0.0, 0.0, 1.0]).replacen('{', r#"{ "operation": "APPEND","#, 1);
    for made in [
        diff(&more).apply(&before).unwrap(),
        scene(&[table, more]).unwrap(),
    ] {
        let table = made.object("table").unwrap();
        assert_eq!(
            (table.pose * table.shapes[1].pose).translation,
            Vec3::new(0.6, 0.5, 1.0)
        );
    }
}

/// In MoveIt's messages the header has the frame's name, and `child_frame_id` that of the world.
#[test]
fn fixed_frames_are_read_as_moveit_writes_them() {
    let frames = |entries: &str| {
        let cup = object("cup", "camera", "[0, 0, 1]", [0.0; 3]);
        read(&format!(
            r#""objects": [{cup}], "fixed_frame_transforms": [{entries}]"#
        ))
    };
    let entry = |frame: &str, world: &str, x: f64| {
        format!(
            r#"{{ "header": {{ "frame_id": "{frame}", "stamp": {{ "sec": 0, "nanosec": 0 }} }}, "child_frame_id": "{world}",
                "transform": {{ "translation": {{ "x": {x}, "y": 0, "z": 0 }}, "rotation": [0, 0, 0, 1] }} }}"#
        )
    };
    let base = entry("base", "base", 0.0);
    for text in [
        format!("{base}, {}", entry("camera", "base", 2.0)),
        entry("camera", "world", 2.0),
    ] {
        let made = frames(&text).unwrap();
        assert_eq!(shape_of(&made, "cup"), Vec3::new(2.0, 0.0, 1.0));
    }
    let ours = r#"{ "child_frame_id": "camera", "transform": { "translation": [2, 0, 0] } }"#;
    assert_eq!(
        shape_of(&frames(ours).unwrap(), "cup"),
        Vec3::new(2.0, 0.0, 1.0)
    );
    for (text, part) in [
        (
            entry("world", "camera", 2.0),
            "\"world\" is given in \"camera\", which is not the world",
        ),
        (format!("{ours}, {ours}"), "\"camera\" twice"),
        (entry("base", "base", 1.0), "circle"),
    ] {
        let refused = frames(&text).unwrap_err().to_string();
        assert!(refused.contains(part), "{refused}");
    }
}

#[test]
fn a_frame_that_a_link_carries_or_nobody_knows_is_told() {
    let carried =
        r#""attached_collision_objects": [{ "link_name": "hand", "object": { "id": "tool" } }]"#;
    let cup = object("cup", "tool", "", [0.0; 3]);
    let text = read(&format!(r#""objects": [{cup}], {carried}"#))
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("\"cup\" is placed by \"tool\", which a link carries"),
        "{text}"
    );
    let made = scene(&[
        object("cup", "odom", "[1, 0, 0]", [0.0; 3]),
        object("jug", "/world", "", [0.0; 3]),
    ])
    .unwrap();
    assert_eq!(made.worlds().collect::<Vec<_>>(), [("cup", "odom")]);
    let plain = scene(&[
        object("cup", "", "[1, 0, 0]", [0.0; 3]),
        object("jug", "", "", [0.0; 3]),
    ])
    .unwrap();
    assert!(
        made.hash() != plain.hash(),
        "a proof in one is none in the other"
    );
    let moved = diff(r#"{ "id": "cup", "operation": "MOVE", "pose": { "position": [1, 0, 0] } }"#)
        .apply(&made)
        .unwrap();
    assert_eq!(moved.hash(), plain.hash());
}

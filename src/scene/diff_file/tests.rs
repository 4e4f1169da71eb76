use proptest::prelude::*;

use super::super::scene_file;
use super::*;
use crate::math::{Quat, Vec3};
use crate::scene::{Obstacle, Scene};
use crate::shape::{Mesh, MeshError, PlacedShape, Shape};
use std::sync::Arc;

fn no_mesh(name: &str, _: Vec3) -> Result<Arc<Mesh>, MeshError> {
    Err(MeshError::Unreadable {
        name: name.to_owned(),
        reason: "none here".to_owned(),
    })
}

/// A table and a cup in the world, a tool on the hand, a frame on the table.
fn kitchen() -> Scene {
    let ball =
        r#""primitives": [{ "type": "sphere", "dimensions": [0.1] }], "primitive_poses": [{}]"#;
    let object = |id: &str| format!(r#"{{ "id": "{id}", {ball} }}"#);
    let text = format!(
        r#"{{ "objects": [{}, {}],
            "attached_collision_objects": [{{ "link_name": "hand", "object": {}, "touch_links": ["finger"] }}],
            "allowed_collisions": [["cup", "table"], ["tool", "table"]], "link_padding": {{ "table": 0.01 }},
            "fixed_frame_transforms": [{{ "child_frame_id": "tray", "transform": {{ "translation": [0, 0, 1] }} }}] }}"#,
        object("table"),
        object("cup"),
        object("tool"),
    );
    scene_file::parse(&text, &mut no_mesh).unwrap()
}

fn apply(fields: &str) -> Result<Scene, SceneError> {
    let diff = DiffFile::parse(&format!(r#"{{ "is_diff": true, {fields} }}"#))?;
    SceneDiff::try_from(diff)?.apply(&kitchen())
}

fn position(scene: &Scene, id: &str) -> Vec3 {
    let standing = scene.obstacles().get(id);
    let object = standing.or_else(|| {
        scene
            .attached()
            .get(id)
            .map(|attached| &attached.object)
    });
    object
        .unwrap_or_else(|| panic!("{id} is there"))
        .pose
        .translation
}

const BALL: &str =
    r#""primitives": [{ "type": "sphere", "dimensions": [0.2] }], "primitive_poses": [{}]"#;

#[test]
fn every_operation_does_what_it_does_in_moveit() {
    let scene = apply(
        r#""objects": [{ "id": "cup", "operation": "MOVE", "pose": { "position": [1, 2, 3] } },
                       { "id": "table", "operation": 3, "header": { "frame_id": "cup" }, "pose": {} }]"#,
    );
    let scene = scene.unwrap();
    assert_eq!(
        (position(&scene, "cup"), position(&scene, "table")),
        (Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.0, 2.0, 3.0))
    );

    let scene = apply(&format!(
        r#""objects": [{{ "id": "vase", "operation": "ADD", "header": {{ "frame_id": "tray" }}, {BALL} }},
            {{ "id": "vase", "operation": "APPEND", {BALL} }}, {{ "id": "pot", "operation": 2, {BALL} }},
            {{ "id": "cup", "operation": 1 }}]"#
    ));
    let scene = scene.unwrap();
    assert_eq!(
        scene
            .obstacles()
            .get("vase")
            .unwrap()
            .shapes
            .len(),
        2
    );
    assert_eq!(
        position(&scene, "vase"),
        Vec3::Z,
        "in the frame of the tray"
    );
    assert!(
        scene.obstacles().get("pot").is_some(),
        "appending to nothing makes the object"
    );
    assert!(scene.obstacles().get("cup").is_none());

    let scene = apply(&format!(
        r#""objects": [{{ "id": "table", "operation": "ADD", {BALL} }}]"#
    ))
    .unwrap();
    assert_eq!(
        scene.obstacles().get("table").unwrap().shapes[0].shape,
        Shape::sphere(0.2).unwrap()
    );
    assert_eq!(scene.padding("table"), 0.01, "what names it stays");
    assert_eq!(scene.allowed().count(), 2);

    let scene = apply(r#""objects": [{ "id": "", "operation": "REMOVE" }]"#).unwrap();
    assert_eq!(
        (scene.obstacles().len(), scene.attached().len()),
        (0, 1),
        "what links carry stays"
    );
}

#[test]
fn links_take_and_put_back() {
    let taken = r#"{ "link_name": "hand", "touch_links": ["finger"],
        "object": { "id": "cup", "operation": "ADD", "pose": { "position": [0, 0, 0.1] } } }"#;
    let scene = apply(&format!(r#""attached_collision_objects": [{taken}]"#)).unwrap();
    let cup = scene.attached().get("cup").unwrap();
    assert_eq!(
        (
            cup.link_name.as_str(),
            &*cup.touch_links,
            cup.object.pose.translation.z
        ),
        ("hand", &["finger".to_owned()][..], 0.1)
    );
    assert!(scene.obstacles().get("cup").is_none());
    assert_eq!(scene.allowed().count(), 2, "its pairs stay");

    let put = r#"{ "object": { "id": "tool", "operation": "REMOVE", "header": { "frame_id": "tray" }, "pose": {} } }"#;
    let moved = r#"{ "link_name": "hand", "object": { "id": "tool", "operation": "MOVE", "pose": { "position": [0, 1, 0] } } }"#;
    let scene = apply(&format!(
        r#""attached_collision_objects": [{taken}, {put}]"#
    ))
    .unwrap();
    assert_eq!(
        (scene.attached().len(), position(&scene, "tool")),
        (1, Vec3::Z)
    );
    let scene = apply(&format!(r#""attached_collision_objects": [{moved}]"#)).unwrap();
    assert_eq!(position(&scene, "tool"), Vec3::Y);

    let own = format!(
        r#"{{ "link_name": "wrist", "object": {{ "id": "camera", "operation": 0, {BALL} }} }}"#
    );
    let scene = apply(&format!(r#""attached_collision_objects": [{own}]"#)).unwrap();
    assert_eq!(
        scene
            .attached()
            .get("camera")
            .unwrap()
            .link_name,
        "wrist"
    );
    let gone = apply(r#""objects": [{ "id": "tool", "operation": "REMOVE" }]"#).unwrap();
    assert!(gone.attached().is_empty());
}

#[test]
fn pairs_sizes_and_frames_are_set_and_taken_away() {
    let scene = apply(
        r#""default_collisions": [["table", "cup"]], "allowed_collisions": [["hand", "cup"]],
           "forbidden_collisions": [["table", "tool"]], "link_padding": { "table": 0, "cup": 0.02 },
           "link_scale": [{ "link_name": "hand", "scale": 1.5 }],
           "fixed_frame_transforms": [{ "child_frame_id": "tray", "transform": null },
                                      { "child_frame_id": "wall", "transform": { "translation": [0, 5, 0] } }]"#,
    );
    let scene = scene.unwrap();
    assert_eq!(scene.allowed().collect::<Vec<_>>(), [("hand", "cup")]);
    assert_eq!(scene.forbidden().collect::<Vec<_>>(), [("table", "tool")]);
    assert_eq!(
        (
            scene.padding("table"),
            scene.padding("cup"),
            scene.scale("hand")
        ),
        (0.0, 0.02, 1.5)
    );
    assert_eq!(
        scene
            .frames()
            .map(|(name, _)| name)
            .collect::<Vec<_>>(),
        ["wall"]
    );
}

#[test]
fn what_is_wrong_is_named_in_one_line() {
    let attached = |entry: &str| format!(r#""attached_collision_objects": [{entry}]"#);
    let object = |entry: &str| format!(r#""objects": [{entry}]"#);
    for (fields, parts) in [
        (
            r#""objcts": []"#.to_owned(),
            ["\"objcts\", did you mean `objects`", "not a diff", "line 1"],
        ),
        (
            object(r#"{ "id": "cup" }"#),
            ["\"cup\"", "no operation", "ADD, REMOVE, APPEND, MOVE"],
        ),
        (
            object(r#"{ "id": "cup", "operation": "PUT" }"#),
            ["\"PUT\"", "ADD (0)", "column"],
        ),
        (
            object(r#"{ "id": "cup", "operation": 4 }"#),
            ["4", "MOVE (3)", "column"],
        ),
        (
            object(r#"{ "id": "cup", "operation": "MOVE" }"#),
            ["\"cup\"", "no pose", "the world"],
        ),
        (
            object(r#"{ "id": "vase", "operation": "MOVE", "pose": {} }"#),
            ["\"vase\"", "not in the scene", "table, cup"],
        ),
        (
            object(r#"{ "id": "tool", "operation": "MOVE", "pose": {} }"#),
            ["\"tool\"", "attached to \"hand\"", "attached_c"],
        ),
        (
            object(&format!(
                r#"{{ "id": "tool", "operation": "APPEND", {BALL} }}"#
            )),
            ["\"tool\"", "attached to \"hand\"", "not in"],
        ),
        (
            object(&format!(
                r#"{{ "id": "cup", "operation": "MOVE", "pose": {{}}, {BALL} }}"#
            )),
            ["\"cup\"", "shapes", "MOVE"],
        ),
        (
            object(&format!(
                r#"{{ "id": "cup", "operation": "APPEND", "pose": {{ "position": [1, 0, 0] }}, {BALL} }}"#
            )),
            ["\"cup\"", "pose", "APPEND"],
        ),
        (
            object(r#"{ "id": "vase", "operation": "REMOVE" }"#),
            ["\"vase\"", "remove", "table, cup"],
        ),
        (
            object(&format!(
                r#"{{ "id": "tool", "operation": "ADD", {BALL} }}"#
            )),
            ["\"tool\"", "twice", "unique"],
        ),
        (
            object(&format!(
                r#"{{ "id": "tray", "operation": "ADD", {BALL} }}"#
            )),
            ["\"tray\"", "frame", "object"],
        ),
        (
            object(
                r#"{ "id": "cup", "operation": "MOVE", "header": { "frame_id": "shelf" }, "pose": {} }"#,
            ),
            ["\"shelf\"", "frames tray", "objects table"],
        ),
        (
            object(
                r#"{ "id": "cup", "operation": "MOVE", "pose": { "orientation": { "x": 0, "y": 0, "z": 0, "w": 2 } } }"#,
            ),
            ["\"cup\"", "norm 2", "unit quaternion"],
        ),
        (
            object(
                r#"{ "id": "vase", "operation": "ADD", "meshes": [{ "file": "vase.stl" }], "mesh_poses": [{}] }"#,
            ),
            ["\"vase\"", "vase.stl", "vertices"],
        ),
        (
            attached(r#"{ "object": { "id": "cup", "operation": "ADD", "pose": {} } }"#),
            ["\"cup\"", "no link", "link_name"],
        ),
        (
            attached(r#"{ "link_name": "hand", "object": { "id": "cup", "operation": "ADD" } }"#),
            ["\"cup\"", "no pose", "link's frame"],
        ),
        (
            attached(
                r#"{ "link_name": "hand", "object": { "id": "vase", "operation": "ADD", "pose": {} } }"#,
            ),
            ["\"vase\"", "attach", "objects: table"],
        ),
        (
            attached(
                r#"{ "link_name": "hand", "object": { "id": "tool", "operation": "ADD", "pose": {} } }"#,
            ),
            ["\"tool\"", "already attached", "detach"],
        ),
        (
            attached(
                r#"{ "link_name": "hand", "object": { "id": "cup", "operation": 0, "header": { "frame_id": "tray" }, "pose": {} } }"#,
            ),
            ["\"cup\"", "\"tray\"", "frame of \"hand\""],
        ),
        (
            attached(r#"{ "object": { "id": "tool", "operation": "REMOVE" } }"#),
            ["\"tool\"", "no pose", "the world"],
        ),
        (
            attached(r#"{ "object": { "id": "cup", "operation": "MOVE", "pose": {} } }"#),
            ["\"cup\"", "no link", "tool"],
        ),
        (
            attached(
                r#"{ "link_name": "wrist", "object": { "id": "tool", "operation": "MOVE", "pose": {} } }"#,
            ),
            ["\"tool\"", "attached to \"hand\"", "\"wrist\""],
        ),
        (
            attached(
                r#"{ "touch_links": ["a"], "object": { "id": "tool", "operation": "MOVE", "pose": {} } }"#,
            ),
            ["\"tool\"", "touch_links", "ADD does"],
        ),
        (
            r#""link_padding": { "cup": -1 }"#.to_owned(),
            ["\"cup\"", "-1", "at least 0"],
        ),
        (
            r#""link_scale": { "cup": 0 }"#.to_owned(),
            ["\"cup\"", "is 0", "1 leaves sizes"],
        ),
        (
            r#""link_scale": [{ "link_name": "cup", "padding": 1 }]"#.to_owned(),
            ["missing field", "scale", "column"],
        ),
        (
            r#""fixed_frame_transforms": [{ "child_frame_id": "wall", "transform": null }]"#
                .to_owned(),
            ["\"wall\"", "no frame", "tray"],
        ),
        (
            r#""fixed_frame_transforms": [{ "child_frame_id": "wall" }]"#.to_owned(),
            ["missing field", "transform", "line 1"],
        ),
    ] {
        let text = apply(&fields).expect_err(&fields).to_string();
        assert!(
            parts.iter().all(|part| text.contains(part)) && !text.contains('\n'),
            "{fields}\n{text}"
        );
    }
    for (text, part) in [
        (r#"{ "is_diff": false }"#, "set it to true"),
        (r#"{ "objects": [] }"#, "missing field `is_diff`"),
        ("{\n \"is_diff\": tru }", "line 2"),
        ("", "line 1"),
    ] {
        let refused = DiffFile::parse(text)
            .expect_err(text)
            .to_string();
        assert!(
            refused.contains(part) && !refused.contains('\n'),
            "{refused}"
        );
    }
    let whole = scene_file::parse(r#"{ "is_diff": true, "objects": [] }"#, &mut no_mesh)
        .unwrap_err()
        .to_string();
    assert!(
        whole.contains("is a diff") && whole.contains("apply"),
        "{whole}"
    );
    let moved = r#"{ "objects": [{ "id": "cup", "operation": "MOVE", "pose": {} }] }"#;
    let whole = scene_file::parse(moved, &mut no_mesh)
        .unwrap_err()
        .to_string();
    assert!(
        whole.contains("\"cup\"") && whole.contains("MOVE") && whole.contains("is_diff"),
        "{whole}"
    );
}

#[test]
fn a_list_is_one_change_and_the_first_error_undoes_all() {
    let out = r#"{ "is_diff": true, "attached_collision_objects": [
        { "object": { "id": "tool", "operation": "REMOVE", "pose": {} } }] }"#;
    let away = r#"{ "is_diff": true, "objects": [{ "id": "tool", "operation": "MOVE", "pose": { "position": [1, 0, 0] } }] }"#;
    let list = |parts: &[&str]| {
        DiffFile::parse(&format!("[{}]", parts.join(",")))
            .and_then(SceneDiff::try_from)
            .unwrap()
    };
    let before = kitchen();
    assert_eq!(
        position(&list(&[out, away]).apply(&before).unwrap(), "tool"),
        Vec3::X
    );
    assert!(list(&[away, out]).apply(&before).is_err());
    assert_eq!(before.hash(), kitchen().hash());
}

#[test]
fn names_that_a_robot_or_scene_has_to_know_are_listed() {
    let text = r#"{ "is_diff": true, "attached_collision_objects": [{ "link_name": "hand", "touch_links": ["finger"],
        "object": { "id": "cup", "operation": "ADD", "pose": {} } }], "allowed_collisions": [["a", "b"]],
        "default_collisions": [["x", "y"]], "link_padding": { "c": 0.1, "z": 0 }, "link_scale": { "d": 2, "z": 1 } }"#;
    let diff = SceneDiff::try_from(DiffFile::parse(text).unwrap()).unwrap();
    assert_eq!(diff.links().collect::<Vec<_>>(), ["hand"]);
    assert_eq!(
        diff.names().collect::<Vec<_>>(),
        ["finger", "a", "b", "c", "d"]
    );
}

#[test]
fn a_mesh_without_its_content_is_found_again_or_refused() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let faces = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let mesh = |size: f64| {
        Arc::new(
            Mesh::new(
                "wedge.stl",
                corners.map(|c| c * size).to_vec(),
                faces.clone(),
            )
            .unwrap(),
        )
    };
    let shape = PlacedShape {
        pose: Pose::identity(),
        shape: Shape::Mesh(mesh(1.0)),
    };
    let scene = Scene::new(
        "",
        vec![Obstacle::new("wedge", vec![shape])],
        Vec::new(),
        Vec::new(),
    )
    .unwrap();
    let read =
        |text: &str, found: Arc<Mesh>| scene_file::parse(text, &mut |_, _| Ok(found.clone()));
    let short = scene_file::text(&scene, false);
    assert!(!short.contains("vertices"), "{short}");
    assert_eq!(read(&short, mesh(1.0)).unwrap().hash(), scene.hash());
    let error = read(&short, mesh(2.0)).unwrap_err().to_string();
    assert!(
        error.contains("wedge.stl") && error.contains(&format!("{:016x}", mesh(1.0).hash())),
        "{error}"
    );
    let full = scene_file::text(&scene, true);
    assert_eq!(
        scene_file::parse(&full, &mut no_mesh)
            .unwrap()
            .hash(),
        scene.hash()
    );
}

/// A scene of up to six of eight objects, each somewhere, with some of everything that a scene can
/// have.
fn any_scene() -> impl Strategy<Value = Scene> {
    let number = -1.0..1.0_f64;
    let pose = (
        number.clone(),
        number.clone(),
        number.clone(),
        number.clone(),
        number,
    );
    let pose = pose.prop_map(|(x, y, z, a, b)| {
        let rotation = Quat::from_xyzw(a, b, 0.3, 0.7).normalize();
        Pose::from_parts(Vec3::new(x, y, z), rotation)
    });
    let set_identity = Pose::from_parts(Vec3::ZERO, Quat::from_xyzw(0.0, 0.0, 0.0, -1.0));
    // The identity is a pose that is not set, or that is, by its other quaternion.
    let pose = prop_oneof![4 => pose, 1 => Just(Pose::identity()), 1 => Just(set_identity)];
    let shape = prop_oneof![
        (0.01..1.0_f64).prop_map(|r| Shape::sphere(r).unwrap()),
        (0.01..1.0_f64, 0.01..1.0_f64).prop_map(|(a, b)| Shape::cylinder(a, b).unwrap()),
        (0.01..1.0_f64, 0.01..1.0_f64).prop_map(|(a, b)| Shape::capsule(a, b).unwrap()),
        (0.01..1.0_f64, 0.01..1.0_f64)
            .prop_map(|(a, b)| Shape::cuboid(Vec3::new(a, b, a + b)).unwrap()),
        (0.1..1.0_f64).prop_map(|size| {
            let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::X]
                .map(|c| c * size)
                .to_vec();
            let faces = vec![[0, 2, 1], [0, 4, 3], [0, 3, 2], [1, 2, 3]];
            Shape::Mesh(Arc::new(Mesh::new("wedge", corners, faces).unwrap()))
        }),
    ];
    let placed = (pose.clone(), shape).prop_map(|(pose, shape)| PlacedShape { pose, shape });
    let object = (
        0..8_usize,
        any::<bool>(),
        pose.clone(),
        prop::collection::vec(placed, 1..3),
    );
    let names = || prop::sample::select(vec!["o0", "o1", "o2", "hand", "finger"]);
    let pairs = prop::collection::vec((names(), names(), 0..2_u8), 0..4);
    let sizes = prop::collection::vec((names(), 0.0..0.1_f64, 0.5..2.0_f64), 0..3);
    let frames = prop::collection::vec((0..3_u8, pose.clone()), 0..3);
    let on_objects = prop::collection::vec((0..8_u8, prop::option::of(pose)), 0..4);
    let objects = prop::collection::vec(object, 0..6);
    (objects, pairs, sizes, frames, on_objects).prop_map(
        move |(objects, pairs, sizes, frames, on_objects)| {
            let mut changes = Vec::new();
            let mut seen = std::collections::BTreeSet::new();
            for (id, is_attached, pose, shapes) in objects
                .into_iter()
                .filter(|object| seen.insert(object.0))
            {
                let id = format!("o{id}");
                let is_plain = shapes.len() == 1 || pose != set_identity;
                let pose = if is_plain { pose } else { Pose::identity() };
                changes.push(SceneChange::Add(Obstacle::new(id.clone(), shapes).at(pose)));
                let link_name = "hand".to_owned();
                let touch_links = vec!["finger".to_owned(); usize::from(pose.translation.x > 0.0)];
                changes.extend(is_attached.then_some(SceneChange::Attach {
                    id,
                    link_name,
                    touch_links,
                    pose,
                }));
            }
            for (a, b, kind) in pairs.into_iter().filter(|(a, b, _)| a != b) {
                let a = a.to_owned();
                let b = b.to_owned();
                changes.push(if kind == 0 {
                    SceneChange::Allow(a, b)
                } else {
                    SceneChange::Forbid(a, b)
                });
            }
            for (name, padding, scale) in sizes {
                changes.push(SceneChange::Pad {
                    name: name.to_owned(),
                    padding,
                });
                changes.push(SceneChange::Scale {
                    name: name.to_owned(),
                    scale,
                });
            }
            let frames = frames.into_iter();
            changes.extend(frames.map(|(name, pose)| SceneChange::Frame {
                name: format!("f{name}"),
                pose: Some(pose),
            }));
            let scene = Scene::default().with(changes).unwrap();
            // A frame on an object, or what it calls the world, where the object is there.
            on_objects
                .into_iter()
                .fold(scene, |scene, (id, pose)| {
                    let id = format!("o{id}");
                    let change = match pose {
                        Some(pose) => SceneChange::Subframe {
                            object: id,
                            name: "a handle".into(),
                            pose: Some(pose),
                        },
                        None => SceneChange::World {
                            id,
                            frame: Some("odom".into()),
                        },
                    };
                    scene.with([change]).unwrap_or(scene)
                })
        },
    )
}

#[test]
fn what_a_diff_cannot_say_is_told() {
    let change = SceneChange::Replace(Obstacle::new("tool", Vec::new()));
    let error = text(&kitchen(), &[change], true)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("\"tool\"") && error.contains("no shapes"),
        "{error}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_text_of_a_scene_gives_its_hash(scene in any_scene()) {
        let read = scene_file::parse(&scene_file::text(&scene, true), &mut no_mesh);
        prop_assert_eq!(read.map(|read| read.hash()), Ok(scene.hash()));
    }

    #[test]
    fn the_text_of_what_leads_to_another_scene_gives_that_ones_hash(a in any_scene(), b in any_scene()) {
        let text = text(&a, &a.changes_to(&b), true).unwrap();
        let diff = DiffFile::parse(&text).and_then(SceneDiff::try_from).unwrap();
        prop_assert_eq!(diff.apply_among(&a, &["odom".to_owned()]).map(|scene| scene.hash()), Ok(b.hash()), "{}", text);
    }
}

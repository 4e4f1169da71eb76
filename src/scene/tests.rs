//! Scene files and changes to scenes.

use super::scene_file::parse;
use super::*;
use crate::math::Vec3;
use crate::shape::{MeshError, Shape};

fn parse_objects(objects: &str) -> Result<Scene, SceneError> {
    let mut no_mesh = |name: &str, _| {
        Err(MeshError::Unreadable {
            name: name.to_owned(),
            reason: "none".to_owned(),
        })
    };
    parse(
        &format!(r#"{{ "name": "s", "objects": [{objects}] }}"#),
        &mut no_mesh,
    )
}

fn message(objects: &str) -> String {
    parse_objects(objects)
        .expect_err("must be refused")
        .to_string()
}

#[test]
fn dimensions_are_moveits() {
    let object = r#"{ "id": "a",
        "primitives": [{ "type": "box", "dimensions": [1, 2, 3] }, { "type": "cylinder", "dimensions": [4, 0.5] }],
        "primitive_poses": [{ "position": [1, 0, 0] }, { "orientation": { "x": 0, "y": 0, "z": 0, "w": 1 } }] }"#;
    let scene = parse_objects(object).unwrap();
    let [cuboid, cylinder] = &scene.obstacles()[0].shapes[..] else {
        panic!("two shapes")
    };
    assert_eq!(
        cuboid.shape,
        Shape::Box {
            half_extents: Vec3::new(0.5, 1.0, 1.5)
        }
    );
    assert_eq!(cuboid.pose.translation, Vec3::X);
    assert_eq!(
        cylinder.shape,
        Shape::Cylinder {
            radius: 0.5,
            half_height: 2.0
        }
    );
}

#[test]
fn the_objects_own_pose_carries_its_shapes() {
    let object = r#"{ "id": "a", "pose": { "position": [0, 0, 1] },
        "primitives": [{ "type": "sphere", "dimensions": [1] }], "primitive_poses": [{ "position": [0, 2, 0] }] }"#;
    let scene = parse_objects(object).unwrap();
    assert_eq!(
        scene.obstacles()[0]
            .placed_shapes()
            .next()
            .unwrap()
            .pose
            .translation,
        Vec3::new(0.0, 2.0, 1.0)
    );
}

#[test]
fn a_quaternion_that_is_not_unit_is_refused_and_a_rounded_one_normalised() {
    let with_w = |w: f64| {
        format!(
            r#"{{ "id": "cup", "primitives": [{{ "type": "sphere", "dimensions": [1] }}],
            "primitive_poses": [{{ "position": [0, 0, 0], "orientation": {{ "x": 0, "y": 0, "z": 0, "w": {w} }} }}] }}"#
        )
    };
    let text = message(&with_w(1.01));
    assert!(
        text.contains("cup") && text.contains("1.01") && text.contains("unit quaternion"),
        "{text}"
    );
    let scene = parse_objects(&with_w(1.0001)).unwrap();
    assert_eq!(scene.obstacles()[0].shapes[0].pose.rotation.w, 1.0);
}

#[test]
fn what_is_no_solid_is_named() {
    let one = |shape: &str| {
        format!(r#"{{ "id": "cup", "primitives": [{shape}], "primitive_poses": [{{}}] }}"#)
    };
    for (objects, parts) in [
        (
            one(r#"{ "type": "cone", "dimensions": [1, 1] }"#),
            ["\"cup\" has a cone", "not read", "cylinder or a mesh"],
        ),
        (
            one(r#"{ "type": "box", "dimensions": [1, 1] }"#),
            ["cup", "2 dimensions", "box [x, y, z]"],
        ),
        (
            one(r#"{ "type": "sphere", "dimensions": [-1] }"#),
            ["cup", "radius is -1", "greater than 0"],
        ),
        (
            r#"{ "id": "cup", "primitives": [{ "type": "sphere", "dimensions": [1] }] }"#.into(),
            ["cup", "1 primitives", "0 poses"],
        ),
        (
            r#"{ "id": "cup", "planes": [{}] }"#.into(),
            ["cup", "planes", "box"],
        ),
        (
            r#"{ "id": "cup", "meshes": [{ "file": "cup.stl" }], "mesh_poses": [{}] }"#.into(),
            ["cup", "cup.stl", "none"],
        ),
        (
            r#"{ "id": "cup" }, { "id": "cup" }"#.into(),
            ["cup", "twice", "unique"],
        ),
        (
            r#"{ "primitives": [] }"#.into(),
            ["missing field", "id", "line 1"],
        ),
    ] {
        let text = message(&objects);
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    }
}

fn parse_scene(fields: &str) -> Result<Scene, SceneError> {
    let mut no_mesh = |name: &str, _| {
        Err(MeshError::Unreadable {
            name: name.to_owned(),
            reason: "none".to_owned(),
        })
    };
    parse(
        &format!(r#"{{ "objects": [{}], {fields} }}"#, object("table", "")),
        &mut no_mesh,
    )
}

/// A ball of 0.1 m.
fn object(id: &str, more: &str) -> String {
    let ball =
        r#""primitives": [{ "type": "sphere", "dimensions": [0.1] }], "primitive_poses": [{}]"#;
    format!(r#"{{ "id": "{id}", {more} {ball} }}"#)
}

fn attached(object: &str) -> String {
    format!(
        r#""attached_collision_objects": [{{ "link_name": "hand", "touch_links": ["left"], "object": {object} }}]"#
    )
}

#[test]
fn a_file_says_what_links_carry_what_is_thicker_and_what_is_checked_in_any_case() {
    let cup = object(
        "cup",
        r#""header": { "frame_id": "hand" }, "pose": { "position": [0, 0, 0.2] },"#,
    );
    let more =
        r#""forbidden_collisions": [["hand", "table"]], "allowed_collisions": [["left", "table"]]"#;
    let list =
        r#"[{ "link_name": "hand", "padding": 0.02 }, { "link_name": "table", "padding": 0.01 }]"#;
    let map = r#"{ "hand": 0.02, "table": 0.01 }"#;
    for padding in [list, map] {
        let scene = parse_scene(&format!(
            r#"{}, {more}, "link_padding": {padding}"#,
            attached(&cup)
        ))
        .unwrap();
        let carried = &scene.attached()[0];
        assert_eq!(
            (carried.link_name.as_str(), carried.touch_links.as_slice()),
            ("hand", &["left".to_owned()][..])
        );
        assert_eq!(
            (
                carried.object.id.as_str(),
                carried.object.pose.translation.z
            ),
            ("cup", 0.2)
        );
        assert_eq!(scene.forbidden().collect::<Vec<_>>(), [("hand", "table")]);
        assert_eq!(
            (
                scene.padding("hand"),
                scene.padding("table"),
                scene.padding("cup")
            ),
            (0.02, 0.01, 0.0)
        );
    }
}

#[test]
fn what_a_file_says_wrongly_is_named() {
    let of_world = object("cup", r#""header": { "frame_id": "world" },"#);
    for (fields, parts) in [
        (attached(&object("table", "")), ["table", "twice"]),
        (attached(&of_world), ["\"world\"", "frame of \"hand\""]),
        (
            r#""link_padding": { "hand": -0.01 }"#.to_owned(),
            ["hand", "-0.01"],
        ),
        (
            r#""link_padding": { "hand": 0.1, "hand": 0.2 }"#.to_owned(),
            ["hand", "both 0.1 and 0.2"],
        ),
        (
            r#""link_padding": 0.1"#.to_owned(),
            ["\"padding\": …", "line 1"],
        ),
        (
            r#""attached_collision_objects": [{ "link_name": "hand" }]"#.to_owned(),
            ["object", "line 1"],
        ),
    ] {
        let text = parse_scene(&fields)
            .expect_err("must be refused")
            .to_string();
        assert!(
            parts.iter().all(|part| text.contains(part)) && !text.contains('\n'),
            "{text}"
        );
    }
}

fn table_and_cup() -> Scene {
    let [table, cup] = ["table", "cup"].map(|id| {
        parse_objects(&object(id, ""))
            .unwrap()
            .obstacles()[0]
            .clone()
    });
    Scene::new("two", vec![table, cup], Vec::new(), Vec::new()).unwrap()
}

fn attach(id: &str) -> SceneChange {
    let touch_links = vec!["left".into(), "table".into()];
    SceneChange::Attach {
        id: id.into(),
        link_name: "hand".into(),
        touch_links,
        pose: Pose::identity(),
    }
}

#[test]
fn changes_leave_the_scene_that_they_are_made_from_and_share_its_shapes() {
    let scene = table_and_cup();
    let pose = Pose::from_translation(Vec3::X);
    let changed = scene
        .with([
            attach("cup"),
            SceneChange::Move {
                id: "table".into(),
                pose,
            },
        ])
        .unwrap();
    assert_eq!((scene.obstacles().len(), scene.attached().len()), (2, 0));
    assert_eq!(
        (changed.obstacles().len(), changed.attached().len()),
        (1, 1)
    );
    assert_eq!(
        (changed.obstacles()[0].pose, scene.obstacles()[0].pose),
        (pose, Pose::identity())
    );
    assert!(std::sync::Arc::ptr_eq(
        &changed.obstacles()[0].shapes,
        &scene.obstacles()[0].shapes
    ));
    assert!(std::sync::Arc::ptr_eq(
        &changed.attached()[0].object.shapes,
        &scene.obstacles()[1].shapes
    ));
}

#[test]
fn what_is_removed_is_named_nowhere_any_more() {
    let name = |text: &str| text.to_owned();
    let changes = [
        attach("cup"),
        SceneChange::Allow(name("table"), name("hand")),
        SceneChange::Forbid(name("left"), name("table")),
        SceneChange::Pad {
            name: name("table"),
            padding: 0.1,
        },
        SceneChange::Scale {
            name: name("table"),
            scale: 1.1,
        },
        SceneChange::Remove { id: name("table") },
    ];
    let scene = table_and_cup().with(changes).unwrap();
    assert!(
        scene.obstacles().is_empty()
            && scene.allowed().count() == 0
            && scene.forbidden().count() == 0
    );
    assert_eq!((scene.padded().count(), scene.scaled().count()), (0, 0));
    assert_eq!(scene.attached()[0].touch_links, ["left"]);
    assert!(
        scene
            .with([SceneChange::Remove { id: name("cup") }])
            .unwrap()
            .attached()
            .is_empty()
    );
}

#[test]
fn allowing_and_forbidding_take_each_other_back() {
    let allow = SceneChange::Allow("a".into(), "b".into());
    let forbid = SceneChange::Forbid("b".into(), "a".into());
    let scene = table_and_cup()
        .with([allow.clone(), allow.clone(), forbid.clone()])
        .unwrap();
    assert_eq!((scene.allowed().count(), scene.forbidden().count()), (0, 1));
    let scene = scene.with([forbid, allow]).unwrap();
    assert_eq!((scene.allowed().count(), scene.forbidden().count()), (1, 0));
    let scene = scene
        .with([SceneChange::ClearPair("b".into(), "a".into())])
        .unwrap();
    assert_eq!((scene.allowed().count(), scene.forbidden().count()), (0, 0));
    assert_eq!(scene.hash(), table_and_cup().hash());
}

#[test]
fn changes_that_cannot_be_made_are_refused_and_say_what_could() {
    let scene = table_and_cup().with([attach("cup")]).unwrap();
    let id = "vase".to_owned();
    let pose = Pose::identity();
    let stretched = Pose::from_parts(Vec3::ZERO, crate::math::Quat::from_xyzw(0.0, 0.0, 0.0, 1.1));
    let pad = |padding| SceneChange::Pad {
        name: "hand".into(),
        padding,
    };
    let scale = |scale| SceneChange::Scale {
        name: "hand".into(),
        scale,
    };
    let frame = |name: &str, pose| SceneChange::Frame {
        name: name.into(),
        pose,
    };
    let cup = scene.attached()[0].object.clone();
    for (change, parts) in [
        (SceneChange::Add(cup), ["\"cup\"", "twice"]),
        (
            SceneChange::Remove { id: id.clone() },
            ["cannot remove object \"vase\"", "table, cup"],
        ),
        (
            SceneChange::Move {
                id: id.clone(),
                pose,
            },
            ["cannot move object \"vase\"", "table, cup"],
        ),
        (
            SceneChange::Move {
                id: "table".into(),
                pose: stretched,
            },
            ["table", "unit quaternion"],
        ),
        (
            SceneChange::Move {
                id: "cup".into(),
                pose: Pose::from_translation(Vec3::NAN),
            },
            ["cup", "finite"],
        ),
        (
            attach("vase"),
            ["cannot attach object \"vase\"", "objects: table"],
        ),
        (
            attach("cup"),
            ["\"cup\" is already attached to \"hand\"", "detach"],
        ),
        (
            SceneChange::Detach {
                id: "table".into(),
                pose,
            },
            ["\"table\" stands in the world", "attached objects: cup"],
        ),
        (
            SceneChange::Detach {
                id: id.clone(),
                pose,
            },
            ["cannot detach object \"vase\"", "objects: cup"],
        ),
        (pad(-0.1), ["hand", "-0.1"]),
        (pad(f64::NAN), ["hand", "NaN"]),
        (pad(f64::INFINITY), ["hand", "inf"]),
        (scale(0.0), ["scale of \"hand\" is 0", "from 0.001 to 1000"]),
        (scale(f64::NAN), ["hand", "NaN"]),
        (
            frame("table", Some(pose)),
            ["\"table\"", "a frame and of an object"],
        ),
        (
            frame("map", Some(stretched)),
            ["frame \"map\"", "unit quaternion"],
        ),
        (frame("map", None), ["\"map\" is no frame", "frames none"]),
        (
            SceneChange::Append {
                id,
                shapes: Vec::new(),
            },
            ["cannot append to object \"vase\"", "table, cup"],
        ),
    ] {
        let text = scene
            .with([change])
            .expect_err("must be refused")
            .to_string();
        assert!(
            parts.iter().all(|part| text.contains(part)) && !text.contains('\n'),
            "{text}"
        );
    }
}

/// Every field is in the hash, and so is the order.
#[test]
fn the_hash_is_of_everything() {
    let scene = table_and_cup();
    let touching = |touch: &str| match attach("cup") {
        SceneChange::Attach {
            id,
            link_name,
            pose,
            ..
        } => SceneChange::Attach {
            id,
            link_name,
            touch_links: vec![touch.into()],
            pose,
        },
        _ => unreachable!(),
    };
    let moved = |id: &str| SceneChange::Move {
        id: id.into(),
        pose: Pose::from_translation(Vec3::X),
    };
    let pad = |padding| SceneChange::Pad {
        name: "cup".into(),
        padding,
    };
    let with = |changes: &[SceneChange]| scene.with(changes.to_vec()).unwrap().hash();
    let hashes = [
        scene.hash(),
        with(&[moved("cup")]),
        with(&[attach("cup")]),
        with(&[touching("left")]),
        with(&[touching("right")]),
        with(&[touching("right"), moved("cup")]),
        with(&[pad(0.1)]),
        with(&[pad(0.2)]),
        with(&[SceneChange::Allow("cup".into(), "hand".into())]),
        with(&[SceneChange::Forbid("cup".into(), "hand".into())]),
        with(&[SceneChange::Scale {
            name: "cup".into(),
            scale: 0.1,
        }]),
        with(&[SceneChange::Frame {
            name: "map".into(),
            pose: Some(Pose::identity()),
        }]),
        with(&[SceneChange::Append {
            id: "cup".into(),
            shapes: scene.obstacles()[0].shapes.to_vec(),
        }]),
        // Last in the order instead of first.
        with(&[
            SceneChange::Remove { id: "table".into() },
            SceneChange::Add(scene.obstacles()[0].clone()),
        ]),
    ];
    // What earlier builds made of it, by another implementation.
    let plain = scene
        .with([SceneChange::Allow("a".into(), "b".into())])
        .unwrap();
    assert_eq!(plain.former_hash(), Some(0x1647_877c_b362_d176));
    let scaled = plain
        .with([SceneChange::Scale {
            name: "cup".into(),
            scale: 2.0,
        }])
        .unwrap();
    assert_eq!(
        scaled.former_hash(),
        None,
        "no proof of the plain one is taken for it"
    );
    let different: std::collections::BTreeSet<_> = hashes.iter().collect();
    assert_eq!(different.len(), hashes.len());
    assert_eq!(
        with(&[
            pad(0.0),
            moved("cup"),
            SceneChange::Move {
                id: "cup".into(),
                pose: Pose::identity()
            }
        ]),
        hashes[0]
    );
}

#[test]
fn poses_may_be_given_in_a_named_frame_or_in_that_of_an_object_which_stands() {
    let map = Pose::from_translation(Vec3::X);
    let up = Pose::from_translation(Vec3::Z);
    let turned = Pose::from_parts(
        Vec3::Y,
        crate::math::Quat::from_rotation_z(std::f64::consts::FRAC_PI_2),
    );
    let changes = [
        SceneChange::Frame {
            name: "map".into(),
            pose: Some(map),
        },
        SceneChange::Move {
            id: "table".into(),
            pose: turned,
        },
        attach("cup"),
    ];
    let scene = table_and_cup().with(changes).unwrap();
    assert_eq!(scene.in_world("", &up).unwrap(), up);
    assert_eq!(
        scene.in_world("map", &up).unwrap().translation,
        Vec3::new(1.0, 0.0, 1.0)
    );
    assert!(
        (scene
            .in_world("table", &map)
            .unwrap()
            .translation
            - Vec3::Y * 2.0)
            .length()
            < 1e-15
    );
    let text = scene
        .in_world("cup", &up)
        .expect_err("where it is nobody knows here")
        .to_string();
    assert!(
        text.contains("\"cup\" is no frame") && text.contains("frames map; objects table"),
        "{text}"
    );
    let without = scene
        .with([SceneChange::Frame {
            name: "map".into(),
            pose: None,
        }])
        .unwrap();
    assert_eq!(
        without.hash(),
        table_and_cup()
            .with([
                SceneChange::Move {
                    id: "table".into(),
                    pose: turned
                },
                attach("cup")
            ])
            .unwrap()
            .hash()
    );
    assert!(without.in_world("map", &up).is_err());
    let taken = Obstacle::new("map", Vec::new());
    assert_eq!(
        scene
            .with([SceneChange::Add(taken)])
            .unwrap_err(),
        SceneError::NameTaken("map".into())
    );
}

#[test]
fn shapes_come_to_an_object_wherever_it_is() {
    let scene = table_and_cup().with([attach("cup")]).unwrap();
    let more = scene.obstacles()[0].shapes.to_vec();
    for id in ["table", "cup"] {
        let longer = scene
            .with([SceneChange::Append {
                id: id.into(),
                shapes: more.clone(),
            }])
            .unwrap();
        assert_eq!(
            longer
                .objects()
                .find(|object| object.id == id)
                .unwrap()
                .shapes
                .len(),
            2
        );
        assert!(longer.hash() != scene.hash());
    }
}

#[test]
fn the_world_is_emptied_at_once() {
    let scene = table_and_cup()
        .with([attach("cup"), SceneChange::RemoveAll])
        .unwrap();
    assert!(scene.obstacles().is_empty());
    assert_eq!(
        scene.attached()[0].touch_links,
        ["left"],
        "nothing names the table any more"
    );
}

//! Scene files and changes to scenes.

use super::scene_file::parse;
use super::*;
use crate::math::Vec3;
use crate::shape::{MeshError, Shape};

fn parse_objects(objects: &str) -> Result<Scene, SceneError> {
    let mut no_mesh = |name: &str, _| Err(MeshError::Unreadable { name: name.to_owned(), reason: "none".to_owned() });
    parse(&format!(r#"{{ "name": "s", "objects": [{objects}] }}"#), &mut no_mesh)
}

fn message(objects: &str) -> String {
    parse_objects(objects).expect_err("must be refused").to_string()
}

#[test]
fn dimensions_are_moveits() {
    let object = r#"{ "id": "a",
        "primitives": [{ "type": "box", "dimensions": [1, 2, 3] }, { "type": "cylinder", "dimensions": [4, 0.5] }],
        "primitive_poses": [{ "position": [1, 0, 0] }, { "orientation": { "x": 0, "y": 0, "z": 0, "w": 1 } }] }"#;
    let scene = parse_objects(object).unwrap();
    let [cuboid, cylinder] = &scene.obstacles()[0].shapes[..] else { panic!("two shapes") };
    assert_eq!(cuboid.shape, Shape::Box { half_extents: Vec3::new(0.5, 1.0, 1.5) });
    assert_eq!(cuboid.pose.translation, Vec3::X);
    assert_eq!(cylinder.shape, Shape::Cylinder { radius: 0.5, half_height: 2.0 });
}

#[test]
fn the_objects_own_pose_carries_its_shapes() {
    let object = r#"{ "id": "a", "pose": { "position": [0, 0, 1] },
        "primitives": [{ "type": "sphere", "dimensions": [1] }], "primitive_poses": [{ "position": [0, 2, 0] }] }"#;
    let scene = parse_objects(object).unwrap();
    assert_eq!(scene.obstacles()[0].placed_shapes().next().unwrap().pose.translation, Vec3::new(0.0, 2.0, 1.0));
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
    assert!(text.contains("cup") && text.contains("1.01") && text.contains("unit quaternion"), "{text}");
    let scene = parse_objects(&with_w(1.0001)).unwrap();
    assert_eq!(scene.obstacles()[0].shapes[0].pose.rotation.w, 1.0);
}

#[test]
fn what_is_no_solid_is_named() {
    let one = |shape: &str| format!(r#"{{ "id": "cup", "primitives": [{shape}], "primitive_poses": [{{}}] }}"#);
    for (objects, parts) in [
        (one(r#"{ "type": "cone", "dimensions": [1, 1] }"#), ["cup", "cone", "cylinder [height, radius]"]),
        (one(r#"{ "type": "box", "dimensions": [1, 1] }"#), ["cup", "2 dimensions", "box [x, y, z]"]),
        (one(r#"{ "type": "sphere", "dimensions": [-1] }"#), ["cup", "radius is -1", "greater than 0"]),
        (
            r#"{ "id": "cup", "primitives": [{ "type": "sphere", "dimensions": [1] }] }"#.into(),
            ["cup", "1 primitives", "0 poses"],
        ),
        (r#"{ "id": "cup", "planes": [{}] }"#.into(), ["cup", "planes", "box"]),
        (
            r#"{ "id": "cup", "meshes": [{ "file": "cup.stl" }], "mesh_poses": [{}] }"#.into(),
            ["cup", "cup.stl", "none"],
        ),
        (r#"{ "id": "cup" }, { "id": "cup" }"#.into(), ["cup", "twice", "unique"]),
        (r#"{ "primitives": [] }"#.into(), ["missing field", "id", "line 1"]),
    ] {
        let text = message(&objects);
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    }
}

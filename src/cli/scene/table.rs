//! Scenes and diffs for people, from their JSON.

use std::fmt::Write;

use serde_json::Value;

use crate::cli::report::listed;
/// What is in a scene, a line each.
pub(super) fn scene(json: &str) -> String {
    let scene: Value = serde_json::from_str(json).unwrap_or_default();
    let mut text = String::new();
    for object in list(&scene, "objects") {
        line(&mut text, &name(object), &[&place(object), &shapes(object)]);
    }
    for attached in list(&scene, "attached_collision_objects") {
        carried(&mut text, attached);
    }
    rules(&mut text, &scene);
    text
}

/// An object that a link carries.
fn carried(text: &mut String, attached: &Value) {
    let object = &attached["object"];
    let on = format!("on {}", name_of(&attached["link_name"]));
    line(
        text,
        &name(object),
        &[&on, &place(object), &shapes(object), &touching(attached)],
    );
}

/// What a diff, or each of a list of them, does, a line each.
pub(super) fn diff(json: &str) -> String {
    let diff: Value = serde_json::from_str(json).unwrap_or_default();
    let mut text = String::new();
    match &diff {
        Value::Array(parts) => parts
            .iter()
            .for_each(|part| changes(&mut text, part)),
        part => changes(&mut text, part),
    }
    if text.is_empty() {
        "\n  the same".to_owned()
    } else {
        text
    }
}

/// What one diff does.
fn changes(text: &mut String, diff: &Value) {
    for object in list(diff, "objects") {
        let rest = [&*name(object), &place(object), &shapes(object)];
        line(text, operation(object), &rest);
    }
    for attached in list(diff, "attached_collision_objects") {
        attachment(text, attached);
    }
    rules(text, diff);
}

/// What a diff does to an object that a link carries.
fn attachment(text: &mut String, attached: &Value) {
    let object = &attached["object"];
    let (what, on) = attaching(operation(object), attached["link_name"].as_str());
    let rest = [
        &*name(object),
        &on,
        &place(object),
        &shapes(object),
        &touching(attached),
    ];
    line(text, what, &rest);
}

/// The word for an operation on a carried object, and the link.
fn attaching<'a>(operation: &'a str, link: Option<&str>) -> (&'a str, String) {
    let on = link.map_or_else(String::new, |link| format!("on {link}"));
    match (operation, link) {
        ("ADD", Some(_)) => ("ATTACH", on),
        ("REMOVE", _) => ("DETACH", String::new()),
        (other, _) => (other, on),
    }
}

fn line(text: &mut String, head: &str, rest: &[&str]) {
    let rest: Vec<&str> = rest
        .iter()
        .copied()
        .filter(|part| !part.is_empty())
        .collect();
    let _ = write!(text, "\n  {head:<8} {}", rest.join("   "));
}

/// Frames, pairs and sizes.
fn rules(text: &mut String, scene: &Value) {
    frames(text, scene);
    for (field, head) in [
        ("default_collisions", "default"),
        ("allowed_collisions", "allowed"),
        ("forbidden_collisions", "checked"),
    ] {
        pairs(text, list(scene, field), head);
    }
    for (field, head) in [("link_padding", "padding"), ("link_scale", "scale")] {
        sizes(text, &scene[field], head);
    }
}

fn frames(text: &mut String, scene: &Value) {
    for frame in list(scene, "fixed_frame_transforms") {
        let to = match &frame["transform"] {
            Value::Null => "gone".to_owned(),
            pose => pose_text(pose),
        };
        line(text, "frame", &[&name_of(&frame["child_frame_id"]), &to]);
    }
}

fn pairs(text: &mut String, pairs: &[Value], head: &str) {
    for pair in pairs {
        let names = format!("{} × {}", name_of(&pair[0]), name_of(&pair[1]));
        line(text, head, &[&names]);
    }
}

fn sizes(text: &mut String, numbers: &Value, head: &str) {
    for (name, number) in numbers.as_object().into_iter().flatten() {
        line(text, head, &[name, &number.to_string()]);
    }
}

fn list<'a>(scene: &'a Value, field: &str) -> &'a [Value] {
    scene[field]
        .as_array()
        .map_or(&[], Vec::as_slice)
}

fn name_of(value: &Value) -> String {
    value.as_str().unwrap_or("?").to_owned()
}

fn name(object: &Value) -> String {
    match object["id"].as_str() {
        Some("") => "all objects of the world".to_owned(),
        id => id.unwrap_or("?").to_owned(),
    }
}

fn operation(object: &Value) -> &str {
    object["operation"].as_str().unwrap_or("?")
}

fn place(object: &Value) -> String {
    match &object["pose"] {
        Value::Null => String::new(),
        pose => pose_text(pose),
    }
}

fn pose_text(pose: &Value) -> String {
    let position = joined(list(pose, "position").iter(), " ");
    match &pose["orientation"] {
        Value::Null => format!("at {position}"),
        q => {
            let axes = ["x", "y", "z", "w"].iter().map(|axis| &q[axis]);
            format!("at {position} turned {}", joined(axes, " "))
        }
    }
}

fn joined<'a>(numbers: impl Iterator<Item = &'a Value>, between: &str) -> String {
    numbers
        .map(short)
        .collect::<Vec<_>>()
        .join(between)
}

/// A number to a millionth.
fn short(number: &Value) -> String {
    let number = number.as_f64().unwrap_or(f64::NAN);
    ((number * 1e6).round() / 1e6).to_string()
}

fn shapes(object: &Value) -> String {
    let primitives = placed(object, "primitives", "primitive_poses", primitive);
    let meshes = placed(object, "meshes", "mesh_poses", mesh);
    [primitives, meshes].concat().join(", ")
}

fn primitive(shape: &Value) -> String {
    let dimensions = joined(list(shape, "dimensions").iter(), " × ");
    format!("{} {dimensions}", name_of(&shape["type"]))
}

fn mesh(mesh: &Value) -> String {
    let triangles = list(mesh, "triangles").len();
    format!("mesh {} of {triangles} triangles", name_of(&mesh["file"]))
}

/// Shapes of one kind, each with its pose where it has one.
fn placed(object: &Value, shapes: &str, poses: &str, text: fn(&Value) -> String) -> Vec<String> {
    let poses = list(object, poses).iter().map(Some);
    list(object, shapes)
        .iter()
        .zip(poses.chain(std::iter::repeat(None)))
        .map(|(shape, pose)| text(shape) + &within(pose))
        .collect()
}

/// Where a shape is in its object's frame, unless it is that.
fn within(pose: Option<&Value>) -> String {
    pose.filter(|pose| !is_identity(pose))
        .map_or_else(String::new, |pose| format!(" {}", pose_text(pose)))
}

fn is_identity(pose: &Value) -> bool {
    let turn = &pose["orientation"];
    let is_turned = turn.is_object() && turn["w"].as_f64() != Some(1.0);
    let mut position = list(pose, "position").iter();
    position.all(|number| number.as_f64() == Some(0.0)) && !is_turned
}

fn touching(attached: &Value) -> String {
    let names = list(attached, "touch_links")
        .iter()
        .map(name_of);
    listed("may touch ", names)
}

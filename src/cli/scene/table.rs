//! Scenes and diffs for people, from their JSON.

use std::fmt::Write;

use serde_json::Value;

/// What is in a scene, a line each.
pub(super) fn scene(json: &str) -> String {
    let scene: Value = serde_json::from_str(json).unwrap_or_default();
    let mut text = String::new();
    for object in list(&scene, "objects") {
        line(&mut text, &name(object), &[&place(object), &shapes(object)]);
    }
    for attached in list(&scene, "attached_collision_objects") {
        let object = &attached["object"];
        let on = format!("on {}", name_of(&attached["link_name"]));
        line(
            &mut text,
            &name(object),
            &[&on, &place(object), &shapes(object), &touching(attached)],
        );
    }
    rules(&mut text, &scene);
    text
}

/// What a diff, or each of a list of them, does, a line each.
pub(super) fn diff(json: &str) -> String {
    let diff: Value = serde_json::from_str(json).unwrap_or_default();
    let mut text = String::new();
    let parts = match &diff {
        Value::Array(parts) => parts.as_slice(),
        part => std::slice::from_ref(part),
    };
    for part in parts {
        for object in list(part, "objects") {
            line(
                &mut text,
                operation(object),
                &[&name(object), &place(object), &shapes(object)],
            );
        }
        for attached in list(part, "attached_collision_objects") {
            let object = &attached["object"];
            let (what, on) = match (operation(object), attached["link_name"].as_str()) {
                ("ADD", Some(link)) => ("ATTACH", format!("on {link}")),
                ("REMOVE", _) => ("DETACH", String::new()),
                (other, link) => (
                    other,
                    link.map_or_else(String::new, |link| format!("on {link}")),
                ),
            };
            line(
                &mut text,
                what,
                &[
                    &name(object),
                    &on,
                    &place(object),
                    &shapes(object),
                    &touching(attached),
                ],
            );
        }
        rules(&mut text, part);
    }
    if text.is_empty() {
        "\n  the same".to_owned()
    } else {
        text
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
    for frame in list(scene, "fixed_frame_transforms") {
        let to = match &frame["transform"] {
            Value::Null => "gone".to_owned(),
            pose => pose_text(pose),
        };
        line(text, "frame", &[&name_of(&frame["child_frame_id"]), &to]);
    }
    for (field, head) in [
        ("default_collisions", "default"),
        ("allowed_collisions", "allowed"),
        ("forbidden_collisions", "checked"),
    ] {
        for pair in list(scene, field) {
            line(
                text,
                head,
                &[&format!("{} × {}", name_of(&pair[0]), name_of(&pair[1]))],
            );
        }
    }
    for (field, head) in [("link_padding", "padding"), ("link_scale", "scale")] {
        for (name, number) in scene[field].as_object().into_iter().flatten() {
            line(text, head, &[name, &number.to_string()]);
        }
    }
}

fn list<'a>(scene: &'a Value, field: &str) -> &'a [Value] {
    scene[field].as_array().map_or(&[], Vec::as_slice)
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
    let numbers = |value: &Value| {
        value
            .as_array()
            .map_or_else(String::new, |numbers| joined(numbers.iter(), " "))
    };
    let position = format!("at {}", numbers(&pose["position"]));
    match &pose["orientation"] {
        Value::Null => position,
        q => format!(
            "{position} turned {}",
            joined(["x", "y", "z", "w"].iter().map(|axis| &q[axis]), " ")
        ),
    }
}

fn joined<'a>(numbers: impl Iterator<Item = &'a Value>, between: &str) -> String {
    let short = |number: &Value| {
        format!(
            "{}",
            (number.as_f64().unwrap_or(f64::NAN) * 1e6).round() / 1e6
        )
    };
    numbers.map(short).collect::<Vec<_>>().join(between)
}

fn shapes(object: &Value) -> String {
    let primitive = |shape: &Value| {
        let dimensions = shape["dimensions"]
            .as_array()
            .map_or_else(String::new, |all| joined(all.iter(), " × "));
        format!("{} {dimensions}", name_of(&shape["type"]))
    };
    let mesh = |mesh: &Value| {
        let triangles = list(mesh, "triangles").len();
        format!("mesh {} of {triangles} triangles", name_of(&mesh["file"]))
    };
    let placed = |shapes: &str, poses: &str, text: &dyn Fn(&Value) -> String| {
        let poses = list(object, poses)
            .iter()
            .map(Some)
            .chain(std::iter::repeat(None));
        let placed =
            |(shape, pose): (&Value, Option<&Value>)| format!("{}{}", text(shape), within(pose));
        list(object, shapes)
            .iter()
            .zip(poses)
            .map(placed)
            .collect::<Vec<_>>()
    };
    let primitives = placed("primitives", "primitive_poses", &primitive);
    [primitives, placed("meshes", "mesh_poses", &mesh)]
        .concat()
        .join(", ")
}

/// Where a shape is in its object's frame, unless it is that.
fn within(pose: Option<&Value>) -> String {
    let Some(pose) = pose else {
        return String::new();
    };
    let position = list(pose, "position");
    let turn = &pose["orientation"];
    let is_there = position.iter().all(|number| number.as_f64() == Some(0.0));
    let is_turned = turn.is_object() && turn["w"].as_f64() != Some(1.0);
    if is_there && !is_turned {
        String::new()
    } else {
        format!(" {}", pose_text(pose))
    }
}

fn touching(attached: &Value) -> String {
    let names: Vec<String> = list(attached, "touch_links").iter().map(name_of).collect();
    if names.is_empty() {
        String::new()
    } else {
        format!("may touch {}", names.join(", "))
    }
}

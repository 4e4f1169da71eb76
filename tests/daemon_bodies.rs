//! Attached objects, padding and pairs in problem and scene files: the same verdict with and
//! without a daemon.
#![cfg(feature = "daemon")]

mod common;

use common::*;
use serde_json::{Value, json};

/// The shelf's problem with more fields in its scene.
fn problem_with(place: &Place, name: &str, fields: Value) -> String {
    let mut problem = problem("arm_shelf");
    let file = |name: &str| config(&format!("robots/{name}"));
    problem["robot"]["urdf"] = file("panda_like.urdf").into();
    problem["robot"]["srdf"] = file("panda_like.srdf").into();
    problem["scene"]["name"] = name.into();
    for (field, value) in fields.as_object().unwrap() {
        problem["scene"][field] = value.clone();
    }
    place.file(&format!("{name}.json"), &problem.to_string())
}

fn tool(link_name: &str, size: f64) -> Value {
    let shape = json!([{ "type": "box", "dimensions": [size, size, size] }]);
    let object = json!({ "id": "tool", "primitives": shape, "primitive_poses": [{ "position": [0, 0, 0.05] }] });
    let touch_links = ["left_finger", "right_finger", "link7"];
    json!([{ "link_name": link_name, "object": object, "touch_links": touch_links }])
}

#[test]
fn the_daemon_sees_what_the_file_attaches_pads_and_forbids() {
    let place = Place::new();
    let _daemon = place.serve("");
    for (name, fields, exit, said) in [
        (
            "small",
            json!({ "attached_collision_objects": tool("hand", 0.01) }),
            0,
            "proved",
        ),
        (
            "large",
            json!({ "attached_collision_objects": tool("hand", 0.3) }),
            1,
            "tool",
        ),
        (
            "spread",
            json!({ "link_padding": [{ "link_name": "hand", "padding": 0.2 }] }),
            1,
            "hand × ",
        ),
        (
            "thin",
            json!({ "link_padding": { "hand": 0.0005, "bottle": 0.0005 } }),
            0,
            "proved",
        ),
        (
            "thick",
            json!({ "link_padding": { "shelf_middle": 0.3 } }),
            1,
            " × shelf_middle",
        ),
        (
            "strict",
            json!({ "forbidden_collisions": [["link1", "link2"]] }),
            1,
            "link1 × link2",
        ),
    ] {
        let file = problem_with(&place, name, fields);
        for local in [true, false] {
            let mut arguments = vec!["check", file.as_str()];
            arguments.extend(local.then_some("--local"));
            let run = place.taut(&arguments);
            assert_eq!(
                run.exit, exit,
                "{name}, local {local}: {}{}",
                run.out, run.err
            );
            assert!(run.out.contains(said), "{name}, local {local}: {}", run.out);
        }
        assert!(
            place
                .taut(&["list"])
                .out
                .contains(&format!("scene {name}"))
        );
    }
}

#[test]
fn names_that_do_not_fit_the_robot_are_refused_by_both() {
    let place = Place::new();
    let _daemon = place.serve("");
    for (name, fields, said) in [
        (
            "claw",
            json!({ "attached_collision_objects": tool("claw", 0.01) }),
            "\"claw\", which is no link; links: base",
        ),
        (
            "pad",
            json!({ "link_padding": { "claw": 0.01 } }),
            "the scene pads claw, but \"claw\" is neither",
        ),
        (
            "negative",
            json!({ "link_padding": { "hand": -0.01 } }),
            "the padding of \"hand\" is -0.01",
        ),
    ] {
        let file = problem_with(&place, name, fields);
        for local in [true, false] {
            let mut arguments = vec!["check", file.as_str()];
            arguments.extend(local.then_some("--local"));
            let run = place.taut(&arguments);
            assert!(
                run.exit != 0 && run.exit != 1,
                "{name}, local {local}: {}",
                run.exit
            );
            assert!(
                run.err.contains(said) && run.err.lines().count() == 1,
                "{name}, local {local}: {}",
                run.err
            );
        }
    }
}

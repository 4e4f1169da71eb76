//! Scenes that others read another way than they looked: frames, messages as they are printed,
//! fields that are misspelt or would be left out. The folders of `tests/cases` with their right
//! values, by `--local` and by the daemon.
#![cfg(feature = "daemon")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use common::*;
use proptest::prelude::*;
use serde_json::{Value, json};
use taut::files::Reader;
use taut::scene::diff_file::{DiffFile, SceneDiff};
use taut::scene::{Scene, SceneError, scene_file};
use taut_ipc::control::{ControlReply, ControlRequest};

fn case(name: &str) -> String {
    let file: PathBuf = [env!("CARGO_MANIFEST_DIR"), "tests/cases", name]
        .iter()
        .collect();
    file.to_str().unwrap().to_owned()
}

/// A folder of cases with its robot and its path.
struct Case {
    robot: String,
    path: String,
    folder: tempfile::TempDir,
}

impl Case {
    fn new(robot: &str, path: &str) -> Self {
        Self {
            robot: case(robot),
            path: case(path),
            folder: tempfile::tempdir().unwrap(),
        }
    }

    fn check(&self, scene: &str) -> Run {
        let arguments = [
            "check",
            &self.path,
            "--robot",
            &self.robot,
            "--scene",
            scene,
            "--local",
            "--format",
            "json",
        ];
        Run::of(
            Command::new(env!("CARGO_BIN_EXE_taut"))
                .args(arguments)
                .output()
                .unwrap(),
        )
    }

    /// The same with a scene of this text.
    fn check_text(&self, name: &str, text: &str) -> Run {
        let file = self.folder.path().join(name);
        fs::write(&file, text).unwrap();
        self.check(file.to_str().unwrap())
    }

    /// A collision of `fore` with the crate at this time.
    fn meets_crate(&self, scene: &str, t: f64) {
        let run = self.check(scene);
        assert_eq!(run.exit, 1, "{scene}: {}{}", run.out, run.err);
        is_collision(&run.json(), t);
    }

    fn refuses(&self, scene: &str, parts: &[&str]) {
        is_refusal(&self.check(scene), parts);
    }
}

fn is_collision(answer: &Value, t: f64) {
    assert_eq!(answer["names"], json!(["fore", "crate"]), "{answer}");
    let found = answer["collision"]["t"]
        .as_f64()
        .or(answer["t"].as_f64())
        .unwrap_or_else(|| panic!("{answer}"));
    // The first collision is told to within 1/2048 of its segment, and `t` is rounded.
    assert!((found - t).abs() < 1e-3, "{found} is not {t}");
}

fn is_refusal(run: &Run, parts: &[&str]) {
    assert_eq!(
        (run.exit, run.err.trim().lines().count()),
        (65, 1),
        "{}{}",
        run.out,
        run.err
    );
    assert!(
        parts.iter().all(|part| run.err.contains(part)),
        "{:?} lacks one of {parts:?}",
        run.err
    );
}

fn frames() -> Case {
    Case::new("object-frames/arm2.urdf", "object-frames/p2.csv")
}

fn dumps() -> Case {
    Case::new("octomap-in-scene/arm2.urdf", "octomap-in-scene/path2.csv")
}

#[test]
fn a_frame_is_an_objects_whatever_text_says_it() {
    let case_of = frames();
    for name in ["f.json", "f_ref.json"] {
        case_of.meets_crate(&case(&format!("object-frames/{name}")), 0.079);
    }
    assert_eq!(
        case_of
            .check(&case("object-frames/f_base.json"))
            .exit,
        0
    );
    let text = fs::read_to_string(case("object-frames/f.json")).unwrap();
    let whole: Value = serde_json::from_str(&text).unwrap();
    // The crate first, as YAML, below a sub-frame, in a problem, and by a table whose own pose is
    // not set.
    let mut turned = whole.clone();
    turned["objects"]
        .as_array_mut()
        .unwrap()
        .reverse();
    let mut on_lid = whole.clone();
    on_lid["objects"][0]["subframe_names"] = json!(["the lid"]);
    on_lid["objects"][0]["subframe_poses"] = json!([{ "position": [0, 0, 0.2] }]);
    on_lid["objects"][1]["header"]["frame_id"] = "/table/the lid".into();
    on_lid["objects"][1]["pose"] = json!({});
    let mut unset = whole.clone();
    let pose = unset["objects"][0]["pose"].take();
    unset["objects"][0]["primitive_poses"] = json!([pose]);
    unset["objects"][0]["pose"] = json!({});
    let mut message =
        json!({ "world": { "collision_objects": whole["objects"] }, "is_diff": false });
    message["world"]["collision_objects"][0]["operation"] = "\u{0}".into();
    for (name, text) in [
        ("turned.json", turned.to_string()),
        ("lid.json", on_lid.to_string()),
        ("unset.json", unset.to_string()),
        ("message.json", message.to_string()),
        ("whole.yaml", yaml(&whole)),
        ("message.yaml", yaml(&message)),
        ("held.json", json!({ "scene": whole }).to_string()),
    ] {
        let run = case_of.check_text(name, &text);
        assert_eq!(run.exit, 1, "{name}: {}{}", run.out, run.err);
        is_collision(&run.json(), 0.079);
    }
    case_of.refuses(
        &case("object-frames/c.json"),
        &[
            "\"crate\"",
            "link \"tool\"",
            "attach it",
            "pose in the world",
        ],
    );
    let parts = [
        "\"crate\"",
        "\"shelff\" is no frame",
        "or \"base\"",
        "frames shelf",
        "objects crate",
    ];
    case_of.refuses(&case("object-frames/d.json"), &parts);
    case_of.refuses(
        &case("object-frames/f_diff.json"),
        &["is a diff", "taut scene apply"],
    );
}

#[test]
fn a_name_of_the_world_is_the_robots_to_say() {
    let case_of = frames();
    let reference = fs::read_to_string(case("object-frames/f_ref.json")).unwrap();
    let in_frame = |frame: &str| {
        let mut scene: Value = serde_json::from_str(&reference).unwrap();
        scene["objects"][1]["header"] = json!({ "frame_id": frame });
        scene
    };
    for frame in ["", "world", "/world", "base", "/base"] {
        let run = case_of.check_text("s.json", &in_frame(frame).to_string());
        assert_eq!(run.exit, 1, "{frame}: {}", run.err);
        is_collision(&run.json(), 0.079);
    }
    // The virtual joint's parent, with a root that is fixed, and with one that is not.
    let check = |kind: &str, frame: &str| {
        let srdf = format!(
            "<robot name='arm2'><virtual_joint name='v' type='{kind}' parent_frame='odom' child_link='base'/><disable_collisions link1='upper' link2='fore' reason='Adjacent'/></robot>"
        );
        let srdf_file = case_of.folder.path().join("v.srdf");
        let scene_file = case_of.folder.path().join("v.json");
        fs::write(&srdf_file, srdf).unwrap();
        fs::write(&scene_file, in_frame(frame).to_string()).unwrap();
        let path = case_of.folder.path().join("v.csv");
        let columns = if kind == "planar" {
            "v/x,v/y,v/theta,j1,j2\n0,0,0,0.2,0.9\n0,0,0,1.0,0.3\n"
        } else {
            "j1,j2\n0.2,0.9\n1.0,0.3\n"
        };
        fs::write(&path, columns).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_taut"));
        command.arg("check").arg(path).args([
            "--robot",
            &case_of.robot,
            "--local",
            "--format",
            "json",
            "--srdf",
        ]);
        Run::of(
            command
                .arg(srdf_file)
                .arg("--scene")
                .arg(scene_file)
                .output()
                .unwrap(),
        )
    };
    for (kind, frame) in [("fixed", "odom"), ("fixed", "base"), ("planar", "odom")] {
        let run = check(kind, frame);
        assert_eq!(run.exit, 1, "{kind} {frame}: {}{}", run.out, run.err);
        is_collision(&run.json(), 0.079);
    }
    is_refusal(&check("planar", "base"), &["link \"base\"", "attach it"]);
    // A frame of the scene by the name of a link that is elsewhere.
    let mut taken = in_frame("tool");
    taken["fixed_frame_transforms"] = json!([{ "child_frame_id": "tool", "transform": {} }]);
    is_refusal(
        &case_of.check_text("taken.json", &taken.to_string()),
        &["\"tool\"", "elsewhere", "rename"],
    );
    let named = in_frame("")
        .to_string()
        .replace("\"crate\"", "\"tool\"");
    let run = case_of.check_text("named.json", &named);
    assert!(
        run.exit == 1 && format!("{}{}", run.out, run.err).contains("has the name of a link"),
        "{}",
        run.err
    );
}

/// The virtual joint's parent is a frame of diffs, too: whichever robot is loaded says the world's
/// name.
#[test]
fn a_diff_knows_the_parent_of_the_virtual_joint() {
    let place = Place::new();
    let _daemon = place.serve("");
    let file = |name: &str| case(&format!("object-frames/{name}"));
    let text = fs::read_to_string(file("arm2.srdf")).unwrap();
    let joint = |kind: &str| {
        format!("<virtual_joint name='v' type='{kind}' parent_frame='odom' child_link='base'/>")
    };
    let load = |label: &str, kind: &str| {
        let srdf = place.file(
            &format!("{label}.srdf"),
            &text.replace("</robot>", &(joint(kind) + "</robot>")),
        );
        place.taut(&[
            "load-robot",
            label,
            "--urdf",
            &file("arm2.urdf"),
            "--srdf",
            &srdf,
        ])
    };
    let diff = fs::read_to_string(file("f_diff.json")).unwrap();
    let apply = |label: &str, frame: &str| {
        let mut diff: Value = serde_json::from_str(&diff).unwrap();
        diff["objects"][0]["header"]["frame_id"] = json!(frame);
        diff["objects"][0]["pose"]["position"] = json!([0.6, 0.55, 0.0]);
        let name = format!("{label}.{}.json", frame.replace('/', "_"));
        assert_eq!(
            place
                .taut(&["load-scene", label, &file("f_base.json")])
                .exit,
            0
        );
        place.taut(&[
            "scene",
            "apply",
            label,
            &place.file(&name, &diff.to_string()),
        ])
    };
    is_refusal(&apply("early", "odom"), &["\"odom\"", "the world"]);
    assert_eq!(load("arm", "fixed").exit, 0);
    for (label, frame) in [("plain", "odom"), ("slash", "/odom"), ("root", "base")] {
        let run = apply(label, frame);
        assert_eq!(run.exit, 0, "{frame}: {}", run.err);
        let run = place.taut(&[
            "check",
            &file("p2.csv"),
            "--robot",
            "arm",
            "--scene",
            label,
            "--format",
            "json",
        ]);
        is_collision(&run.json(), 0.079);
    }
    is_refusal(&apply("typo", "odon"), &["\"odon\"", "odom"]);
    // Of a root that moves, only the joint's parent stands; whether "base" does, another robot may
    // say.
    assert_eq!(load("cart", "planar").exit, 0);
    let path = place.file(
        "cart.csv",
        "v/x,v/y,v/theta,j1,j2\n0,0,0,0.2,0.9\n0,0,0,1.0,0.3\n",
    );
    let check = |scene: &str| {
        place.taut(&[
            "check", &path, "--robot", "cart", "--scene", scene, "--format", "json",
        ])
    };
    assert_eq!(apply("moving", "odom").exit, 0);
    is_collision(&check("moving").json(), 0.079);
    assert_eq!(apply("carried", "base").exit, 0);
    is_refusal(&check("carried"), &["link \"base\"", "attach it"]);
}

#[test]
fn the_daemon_reads_frames_alike() {
    let place = Place::new();
    let _daemon = place.serve("");
    let file = |name: &str| case(&format!("object-frames/{name}"));
    let check = |scene: &str| {
        place.taut(&[
            "check",
            &file("p2.csv"),
            "--robot",
            "arm",
            "--scene",
            scene,
            "--format",
            "json",
        ])
    };
    // With no robot of its kind loaded, a frame that the file does not know is not refused yet.
    let load = |label: &str, name: &str| place.taut(&["load-scene", label, &file(name)]);
    let run = place.taut(&[
        "load-robot",
        "arm",
        "--urdf",
        &file("arm2.urdf"),
        "--srdf",
        &file("arm2.srdf"),
    ]);
    assert_eq!(run.exit, 0, "{}", run.err);
    for (label, name) in [
        ("f", "f.json"),
        ("ref", "f_ref.json"),
        ("base", "f_base.json"),
    ] {
        assert_eq!(load(label, name).exit, 0);
    }
    is_collision(&check("f").json(), 0.079);
    is_collision(&check("ref").json(), 0.079);
    assert_eq!(check("base").exit, 0);
    is_refusal(
        &place.taut(&["scene", "apply", "base", &file("f_diff_typo.json")]),
        &["\"tabel\"", "objects table"],
    );
    assert_eq!(
        place
            .taut(&["scene", "apply", "base", &file("f_diff.json")])
            .exit,
        0
    );
    is_collision(&check("base").json(), 0.079);
    is_refusal(&load("c", "c.json"), &["link \"tool\"", "attach it"]);
    is_refusal(&load("d", "d.json"), &["\"shelff\"", "frames shelf"]);
    let hashes: Vec<u64> = match place
        .client()
        .control(&ControlRequest::List, PATIENCE)
        .unwrap()
    {
        ControlReply::Listing(listing) => listing
            .scenes
            .iter()
            .filter(|scene| ["f", "base"].contains(&scene.label.as_str()))
            .map(|s| s.scene_hash)
            .collect(),
        other => panic!("{other:?}"),
    };
    assert_eq!(hashes[0], hashes[1], "a diff makes the same scene");
    // A diff as a message that is printed goes where diffs go; its octomap is empty.
    let text = fs::read_to_string(case("octomap-in-scene/diff.yaml")).unwrap();
    let full = place.file("full.yaml", &text.replace("data: []", "data: [0, -128]"));
    let scene = place.file("empty.json", r#"{ "objects": [] }"#);
    let diff = place.file("diff.yaml", &text);
    assert_eq!(place.taut(&["load-scene", "live", &scene]).exit, 0);
    is_refusal(
        &place.taut(&["scene", "apply", "live", &full]),
        &[
            "world.octomap: it is a tree of kind \"\"",
            "\"OcTree\" is read",
        ],
    );
    let run = place.taut(&["scene", "apply", "live", &diff]);
    assert_eq!(run.exit, 0, "{}", run.err);
    let path = case("octomap-in-scene/path2.csv");
    let run = place.taut(&[
        "check", &path, "--robot", "arm", "--scene", "live", "--format", "json",
    ]);
    assert_eq!(
        (run.exit, run.json()["names"].clone()),
        (1, json!(["fore", "box_far"])),
        "{}",
        run.err
    );
    is_refusal(
        &load("misspelt", "../misspelt-field/s.json"),
        &["did you mean `primitives`"],
    );
    is_refusal(
        &load("map", "../octomap-in-scene/scene_c.json"),
        &["octomap world.octomap has", "say \"unknown\""],
    );
    let run = load("unset", "../pose-not-set/z.yaml");
    assert!(
        run.exit == 0 && run.err.contains("pose is 0 0 0 0"),
        "{}",
        run.err
    );
}

/// The text of a dump with nothing in its octomap.
fn without_octomap(text: &str) -> String {
    let empty = text
        .replace("data: [0, -128]", "data: []")
        .replace("\"data\": [0, -128]", "\"data\": []");
    assert!(empty != text, "{text}");
    empty
}

#[test]
fn what_would_be_left_out_is_refused_by_name() {
    let case_of = dumps();
    for name in [
        "scene.yaml",
        "scene_type.yaml",
        "scene_c.yaml",
        "scene_c.json",
    ] {
        let file = case(&format!("octomap-in-scene/{name}"));
        // What is unknown in it is nobody's guess.
        case_of.refuses(&file, &["world.octomap", "unknown cells", "\"free\""]);
        // Without it, or with one that nothing was put into, all of them are read alike.
        let run = case_of.check_text(name, &without_octomap(&fs::read_to_string(&file).unwrap()));
        assert_eq!(run.exit, 0, "{name}: {}{}", run.out, run.err);
    }
    case_of.refuses(
        &case("octomap-in-scene/diff.yaml"),
        &["is a diff", "taut scene apply"],
    );
    case_of.refuses(
        &case("pose-not-set/cone.yaml"),
        &["\"crate\" has a cone", "cylinder or a mesh"],
    );
    let misspelt = Case::new("misspelt-field/r.urdf", "misspelt-field/p.csv");
    misspelt.refuses(
        &case("misspelt-field/s.json"),
        &[
            "unknown field \"primitves\", did you mean `primitives`",
            "line 1",
        ],
    );
    let object = |more: &str| format!(r#"{{ "objects": [{{ "id": "wall", {more} }}] }}"#);
    for (text, parts) in [
        (
            object(r#""planes": [{ "coef": [0, 0, 1, 0] }], "plane_poses": [{}]"#),
            ["\"wall\" has planes", "thick box"],
        ),
        (
            object(r#""primitives": [{ "type": 5, "dimensions": [1] }], "primitive_poses": [{}]"#),
            ["has a prism", "mesh"],
        ),
        (
            object(
                r#""primitives": [{ "type": 4, "dimensions": [1, 1] }], "primitive_poses": [{}]"#,
            ),
            ["has a cone", "mesh"],
        ),
        (
            object(r#""primitives": [{ "type": "box", "dimension": [1] }]"#),
            ["did you mean `dimensions`", "line 1"],
        ),
        (
            object(r#""pose": { "positon": [0, 0, 0] }"#),
            ["did you mean `position`", "line 1"],
        ),
        (
            object(r#""operation": "MOVE", "pose": {}"#),
            ["operation MOVE in a whole scene", "set is_diff"],
        ),
        (
            object(r#""operation": "\u0001""#),
            ["operation REMOVE in a whole scene", "set is_diff"],
        ),
        (
            r#"{ "objects": [], "octomap": { "data": [1] } }"#.to_owned(),
            ["octomap: it is a tree of kind", "only \"OcTree\" is read"],
        ),
        (
            r#"{ "objects": [], "path_constraints": { "orientation_constraints": [{}] } }"#
                .to_owned(),
            ["path_constraints", "not supported"],
        ),
        (
            r#"{ "objects": [], "attached_objects": [] }"#.to_owned(),
            ["unknown field \"attached_objects\"", "line 1"],
        ),
        (
            r#"{ "name": "s" }"#.to_owned(),
            ["missing field `objects`", "world"],
        ),
    ] {
        is_refusal(&misspelt.check_text("s.json", &text), &parts);
    }
}

#[test]
fn constraints_of_paths_are_refused_by_name() {
    let case_of = frames();
    let scene = case("object-frames/f_base.json");
    let joint = |name: &str, position: f64| json!({ "joint_name": name, "position": position, "tolerance_above": 0.01 });
    let request = json!({
        "start_state": { "joint_state": { "name": ["j1", "j2"], "position": [0.2, 0.9] }, "attached_collision_objects": [] },
        "goal_constraints": [{ "name": "", "joint_constraints": [joint("j1", 1.0), joint("j2", 0.3)],
            "position_constraints": [], "orientation_constraints": [], "visibility_constraints": [] }],
        "path_constraints": { "name": "", "joint_constraints": [], "orientation_constraints": [] },
        "trajectory_constraints": { "constraints": [] },
    });
    let check = |request: &Value| {
        let file = case_of.folder.path().join("request.yaml");
        fs::write(&file, yaml(request)).unwrap();
        let arguments = [
            "check",
            file.to_str().unwrap(),
            "--robot",
            &case_of.robot,
            "--scene",
            &scene,
            "--local",
        ];
        Run::of(
            Command::new(env!("CARGO_BIN_EXE_taut"))
                .args(arguments)
                .output()
                .unwrap(),
        )
    };
    let run = check(&request);
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    for (pointer, value, part) in [
        (
            "/path_constraints/orientation_constraints",
            json!([{ "link_name": "tool" }]),
            "path_constraints: missing field",
        ),
        (
            "/trajectory_constraints/constraints",
            json!([{ "name": "a" }]),
            "it has trajectory_constraints",
        ),
        (
            "/start_state/attached_collision_objects",
            json!([{ "link_name": "tool" }]),
            "attached_collision_objects",
        ),
        (
            "/goal_constraints/0/orientation_constraints",
            json!([{ "link_name": "tool" }]),
            "orientation_constraints",
        ),
    ] {
        let mut other = request.clone();
        *other.pointer_mut(pointer).unwrap() = value;
        is_refusal(&check(&other), &[part]);
    }
    // A problem whose path had to keep to something.
    let mut problem: Value =
        serde_json::from_str(&fs::read_to_string(config("problems/corner.json")).unwrap()).unwrap();
    problem["path_constraints"] =
        json!({ "name": "upright", "orientation_constraints": [{ "link_name": "hand" }] });
    let file = case_of.folder.path().join("problem.json");
    fs::write(&file, problem.to_string()).unwrap();
    let arguments = ["check", file.to_str().unwrap(), "--local"];
    is_refusal(
        &Run::of(
            Command::new(env!("CARGO_BIN_EXE_taut"))
                .args(arguments)
                .output()
                .unwrap(),
        ),
        &["path_constraints"],
    );
}

#[test]
fn a_pose_that_is_not_set_is_read_as_moveit_reads_it() {
    let case_of = Case::new("pose-not-set/arm2.urdf", "pose-not-set/path2.csv");
    let file = case("pose-not-set/z.yaml");
    let run = case_of.check(&file);
    assert_eq!(
        (run.exit, run.json()["names"].clone()),
        (1, json!(["fore", "crate"])),
        "{}",
        run.err
    );
    let warned = |run: &Run, what: &str| {
        let text = format!("object \\\"crate\\\": the orientation of its {what} is 0 0 0 0");
        assert!(
            run.out.contains(&text) || run.err.contains(&text.replace('\\', "")),
            "{}{}",
            run.out,
            run.err
        );
    };
    warned(&run, "pose");
    let text = fs::read_to_string(&file).unwrap();
    let set = text.replace(
        r#"{"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0}"#,
        r#"{"x": 0, "y": 0, "z": 0, "w": 1}"#,
    );
    assert!(set != text);
    let reference = case_of.check_text("set.yaml", &set).json();
    assert_eq!(run.json()["t"], reference["t"]);
    let shape = set.replace(
        r#""z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}]"#,
        r#""z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 0}}]"#,
    );
    assert!(shape != set);
    warned(
        &case_of.check_text("shape.yaml", &shape),
        "primitive_poses[0]",
    );
    let long = set.replacen(r#""w": 1"#, r#""w": 1.1"#, 1);
    is_refusal(
        &case_of.check_text("long.yaml", &long),
        &["\"crate\"", "the orientation of its pose", "norm 1.1"],
    );
}

#[test]
fn what_ros_prints_is_read_and_what_is_wrong_with_it_has_its_place() {
    let case_of = dumps();
    let text = without_octomap(&fs::read_to_string(case("octomap-in-scene/scene.yaml")).unwrap());
    let near = text.replace("x: 0.0, y: 2.0, z: 0.0", "x: 0.8, y: 0.3, z: 0.0");
    assert!(near != text);
    let bodies = json!(["fore", "box_far"]);
    for printed in [
        near.clone(),
        format!("---\n{near}---\n"),
        near.replace("operation: \"\\0\"", "operation: 0"),
        near.replace("operation: \"\\0\"", "operation: ADD"),
        near.replace("operation: \"\\0\"", "operation: \"\\x00\""),
        near.replace("[0.1, 0.1, 0.1]", "\n      - 0.1\n      - 0.1\n      - 0.1"),
    ] {
        let run = case_of.check_text("echo.yaml", &printed);
        assert_eq!(
            (run.exit, run.json()["names"].clone()),
            (1, bodies.clone()),
            "{printed}{}",
            run.err
        );
    }
    let line = near
        .lines()
        .position(|line| line.contains("dimensions: [0.1"))
        .unwrap()
        + 1;
    for (old, new, parts) in [
        (
            "dimensions: [0.1, 0.1, 0.1]",
            "dimensions: [0.1, .nan, 0.1]",
            vec![format!("line {line} column"), "finite".into()],
        ),
        (
            "dimensions: [0.1, 0.1, 0.1]",
            "dimensoins: [0.1, 0.1, 0.1]",
            vec![
                format!("line {line} column"),
                "did you mean `dimensions`".into(),
            ],
        ),
        (
            "type: 1",
            "type: 9",
            vec![format!("line {} column", line - 1), "sphere (2)".into()],
        ),
        (
            "operation: \"\\0\"",
            "operation: \"\\x04\"",
            vec!["line".into(), "MOVE (3)".into()],
        ),
        (
            "dimensions: [0.1, 0.1, 0.1]",
            "dimensions: [0.1, '...']",
            vec!["--full-length".into()],
        ),
    ] {
        assert!(near.contains(old), "{old}");
        let run = case_of.check_text("echo.yaml", &near.replace(old, new));
        is_refusal(
            &run,
            &parts
                .iter()
                .map(String::as_str)
                .collect::<Vec<_>>(),
        );
    }
    let several = format!("{near}---\n{near}---\n");
    let second = near.lines().count() + 2;
    let parts = [
        "2 YAML documents",
        &format!("lines 1, {second}"),
        "keep the one",
    ];
    is_refusal(&case_of.check_text("echo.yaml", &several), &parts);
}

/// A matrix of MoveIt's decides about the pairs that it names, whatever the SRDF disables.
#[test]
fn a_matrix_switches_pairs_on_and_tells_of_its_defaults() {
    let case_of = frames();
    let matrix = |is_allowed: bool, default: bool| {
        json!({ "world": { "collision_objects": serde_json::from_str::<Value>(&fs::read_to_string(case("object-frames/f_ref.json")).unwrap()).unwrap()["objects"] },
            "allowed_collision_matrix": {
                "entry_names": ["crate", "fore"],
                "entry_values": [{ "enabled": [true, is_allowed] }, { "enabled": [is_allowed, true] }],
                "default_entry_names": ["<octomap>", "crate"], "default_entry_values": [true, default] } })
    };
    assert_eq!(
        case_of
            .check_text("m.json", &matrix(true, false).to_string())
            .exit,
        0
    );
    let run = case_of.check_text("m.yaml", &yaml(&matrix(false, true)));
    is_collision(&run.json(), 0.079);
    let said = format!("{}{}", run.out, run.err);
    assert!(
        said.contains("lets crate touch anything by default, which is not followed"),
        "{said}"
    );
    let scene = Reader::default()
        .scene_of_text(&matrix(false, false).to_string(), Path::new("m.json"))
        .unwrap();
    assert_eq!(scene.forbidden().collect::<Vec<_>>(), [("crate", "fore")]);
}

/// What the robot carries, as a message says it.
#[test]
fn a_message_says_what_links_carry() {
    let ball = json!([{ "type": 2, "dimensions": [0.1] }]);
    let object = |frame: &str| {
        json!({ "link_name": "tool", "touch_links": ["fore"], "detach_posture": { "joint_names": [] }, "weight": 1.5,
            "object": { "id": "ball", "header": { "frame_id": frame }, "primitives": ball, "primitive_poses": [{}],
                "subframe_names": ["tip"], "subframe_poses": [{}], "operation": 0 } })
    };
    let message = |attached: Value, is_diff: bool| {
        json!({ "is_diff": is_diff, "robot_state": { "joint_state": {}, "is_diff": true, "attached_collision_objects": [attached] },
            "world": { "collision_objects": [] } }).to_string()
    };
    let read = |text: &str| Reader::default().scene_of_text(text, Path::new("m.json"));
    let scene = read(&message(object("tool"), false)).unwrap();
    assert_eq!(scene.attached()[0].touch_links, ["fore"]);
    let text = read(&message(object("fore"), false))
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("attached to \"tool\"") && text.contains("\"fore\""),
        "{text}"
    );
    let diff = |text: &str| Reader::default().diff_of_text(text, Path::new("m.json"));
    let made = diff(&message(object(""), true))
        .unwrap()
        .apply(&Scene::default())
        .unwrap();
    assert_eq!(made.hash(), scene.hash());
    // Where MoveIt lets the robot's state decide, nobody here knows.
    let mut taken = object("tool");
    taken["object"]["primitives"] = json!([]);
    taken["object"]["primitive_poses"] = json!([]);
    let text = diff(&message(taken.clone(), true))
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("\"ball\" is taken up where the robot then stands"),
        "{text}"
    );
    taken["object"]["operation"] = 1.into();
    let text = diff(&message(taken, true))
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("\"ball\" is put down where the robot then stands"),
        "{text}"
    );
}

/// A value as YAML in block style, as ROS prints messages; strings as JSON has them.
fn yaml(value: &Value) -> String {
    fn block(value: &Value, depth: usize, text: &mut String) {
        let pad = "  ".repeat(depth);
        match value {
            Value::Object(fields) if !fields.is_empty() => {
                for (name, field) in fields {
                    text.push_str(&format!("\n{pad}{name}:"));
                    block(field, depth + 1, text);
                }
            }
            Value::Array(items) if !items.is_empty() => {
                for item in items {
                    text.push_str(&format!("\n{pad}-"));
                    block(item, depth + 1, text);
                }
            }
            other => text.push_str(&format!(" {other}")),
        }
    }
    let mut text = String::new();
    block(value, 0, &mut text);
    text + "\n"
}

fn no_mesh(
    name: &str,
    _: taut::math::Vec3,
) -> Result<std::sync::Arc<taut::shape::Mesh>, taut::shape::MeshError> {
    Err(taut::shape::MeshError::Unreadable {
        name: name.to_owned(),
        reason: "none".to_owned(),
    })
}

/// Objects each of which is placed by the world, a frame, or an object before it, or a frame on
/// that.
fn objects() -> impl Strategy<Value = Vec<Value>> {
    let number = || (-20..20_i32).prop_map(|n| f64::from(n) / 8.0);
    let pose = move || {
        (number(), number(), number(), 0..4_u8).prop_map(|(x, y, z, turn)| {
            let quaternion = match turn {
                0 => [0.0, 0.0, 0.0, 1.0],
                1 => [0.6, 0.0, 0.0, 0.8],
                2 => [0.0, 0.0, -0.6, 0.8],
                _ => [0.0, 0.0, 0.0, 0.0],
            };
            let [qx, qy, qz, qw] = quaternion;
            json!({ "position": { "x": x, "y": y, "z": z }, "orientation": { "x": qx, "y": qy, "z": qz, "w": qw } })
        })
    };
    let one = (
        prop::option::of(pose()),
        prop::collection::vec(pose(), 1..3),
        pose(),
        any::<u8>(),
    );
    prop::collection::vec(one, 1..7).prop_map(|objects| {
        let of = |(index, (own, shapes, on_it, choice)): (usize, (Option<Value>, Vec<Value>, Value, u8))| {
            let before = usize::from(choice) % index.max(1);
            let frame = match (choice >> 4) % 5 {
                0 => String::new(),
                1 => "shelf".to_owned(),
                2 if index > 0 => format!("object {before}"),
                3 if index > 0 => format!("object {before}/on it"),
                _ => "world".to_owned(),
            };
            let primitives: Vec<Value> = shapes.iter().map(|_| json!({ "type": 1, "dimensions": [0.5, 0.25, 1.0] })).collect();
            let mut object = json!({ "id": format!("object {index}"), "header": { "frame_id": frame }, "operation": 0,
                "primitives": primitives, "primitive_poses": shapes, "subframe_names": ["on it"], "subframe_poses": [on_it] });
            if let Some(own) = own {
                object["pose"] = own;
            }
            object
        };
        objects.into_iter().enumerate().map(of).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    /// As a file, a message, YAML, and as diffs on nothing, the same objects are the same scene.
    #[test]
    fn one_scene_has_one_hash_whatever_text_says_it(objects in objects(), turn in any::<prop::sample::Index>()) {
        let frames = json!([{ "child_frame_id": "shelf", "transform": { "translation": [1, 0, 0.5], "rotation": [0, 0.6, 0, 0.8] } }]);
        let ours = json!({ "objects": objects, "fixed_frame_transforms": frames });
        let scene = scene_file::parse(&ours.to_string(), &mut no_mesh).unwrap();
        let theirs = json!({ "header": { "frame_id": "shelf" }, "child_frame_id": "world", "transform": frames[0]["transform"] });
        let message = json!({ "is_diff": false, "world": { "collision_objects": objects }, "fixed_frame_transforms": [theirs],
            "robot_state": { "attached_collision_objects": [] } });
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [("m.json", message.to_string()), ("o.yaml", yaml(&ours)), ("m.yml", yaml(&message))] {
            let file = folder.path().join(name);
            fs::write(&file, &text).unwrap();
            let sent = taut::files::scene_text(&file).unwrap();
            for read in [Reader::default().scene(&file), Reader::default().scene_of_text(&sent, Path::new("label"))] {
                let read = read.unwrap();
                prop_assert_eq!((read.hash(), read.warnings()), (scene.hash(), scene.warnings()), "{}", text);
            }
        }
        let mut parts = vec![json!({ "is_diff": true, "fixed_frame_transforms": frames })];
        parts.extend(objects.iter().map(|object| json!({ "is_diff": true, "objects": [object] })));
        let diff = |parts: &[Value]| -> Result<SceneDiff, SceneError> {
            DiffFile::parse(&Value::from(parts).to_string()).and_then(SceneDiff::try_from)
        };
        let made = diff(&parts).unwrap().apply(&Scene::default()).unwrap();
        prop_assert_eq!((made.hash(), made.warnings()), (scene.hash(), scene.warnings()));
        let again = scene_file::parse(&scene_file::text(&made, true), &mut no_mesh).unwrap();
        prop_assert_eq!(again.hash(), scene.hash());
        // In another order of the text every object still is where it is.
        let mut turned = objects.clone();
        turned.rotate_left(turn.index(objects.len()));
        let text = json!({ "objects": turned, "fixed_frame_transforms": frames }).to_string();
        let turned = scene_file::parse(&text, &mut no_mesh).unwrap();
        for object in scene.obstacles() {
            prop_assert_eq!(turned.obstacles().get(&object.id), Some(object));
        }
    }
}

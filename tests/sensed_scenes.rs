//! Clouds and octomaps in scenes, as planners bring them: by files, messages and `taut scene cloud`,
//! in this process and by a daemon. An arm of two links in a plane, and walls that it sweeps over.
#![cfg(feature = "daemon")]

mod common;

use std::fs;
use std::path::PathBuf;

use common::*;
use serde_json::{Value, json};

fn case(name: &str) -> String {
    let file: PathBuf = [
        env!("CARGO_MANIFEST_DIR"),
        "tests/cases/octomap-in-scene",
        name,
    ]
    .iter()
    .collect();
    file.to_str().unwrap().to_owned()
}

/// A wall at x (m) across the arm's plane, seen each centimetre.
fn wall(x: f64) -> String {
    let steps = (-10..=10).flat_map(|y| (-10..=10).map(move |z| (y, z)));
    let line = |(y, z)| format!("{x} {} {}\n", 0.01 * f64::from(y), 0.01 * f64::from(z));
    steps.map(line).collect()
}

/// Points of a box that is a link of the arm where it begins, on its upper side.
fn on_the_arm() -> String {
    let [c, s] = [(-1.0f64).cos(), (-1.0f64).sin()];
    let point = |i: i32| {
        let along = 0.05 + 0.04 * f64::from(i);
        format!("{} {} 0.032\n", along * c, along * s)
    };
    (0..10).map(point).collect()
}

/// A room of cells of 5 cm that is free, but for one cell in the arm's way and a corner far away.
fn room(last: u16, corner: u16) -> Vec<u8> {
    let cell = [0.6f64, 0.01, 0.01].map(|x| (x / 0.05).floor() as i64 + (1 << 15));
    let mut bytes =
        b"# Octomap OcTree binary file\nid OcTree\nsize SIZE\nres 0.05\ndata\n".to_vec();
    let mut count = 1;
    for level in 0..16 {
        let bit = |axis: usize| (cell[axis] >> (15 - level) & 1) as usize;
        let child = bit(0) | bit(1) << 1 | bit(2) << 2;
        let way = if level == 15 { last } else { 0b11 };
        let free = 0b0101_0101_0101_0101u16 & !(0b11 << (2 * child));
        // Of a node of 12.8 m, the octant that is farthest from the arm.
        let free = if level == 8 {
            free & 0x3fff | corner << 14
        } else {
            free
        };
        bytes.extend((free | way << (2 * child)).to_le_bytes());
        count += if way == 0 { 7 } else { 8 };
    }
    let text = bytes
        .windows(4)
        .position(|part| part == b"SIZE")
        .unwrap();
    bytes.splice(text..text + 4, count.to_string().into_bytes());
    bytes
}

fn check_locally(place: &Place, scene: &Value) -> Run {
    let scene = place.file("scene.json", &scene.to_string());
    place.taut(&[
        "check",
        &case("path2.csv"),
        "--robot",
        &case("arm2.urdf"),
        "--scene",
        &scene,
        "--local",
        "--format",
        "json",
    ])
}

fn meets(run: &Run, object: &str) {
    assert_eq!(run.exit, 1, "{}{}", run.out, run.err);
    let names = run.json()["names"].clone();
    assert_eq!(names, json!(["fore", object]), "{}", run.out);
}

fn is_proved(run: &Run) {
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
}

#[test]
fn a_scene_file_names_its_cloud() {
    let place = Place::new();
    place.file("wall.xyz", &wall(0.6));
    let scene = |cloud: Value| json!({ "objects": [{ "id": "wall", "cloud": cloud }] });
    let near = scene(json!({ "file": "wall.xyz", "radius": 0.006 }));
    let run = check_locally(&place, &near);
    meets(&run, "wall");
    let far =
        scene(json!({ "file": "wall.xyz", "radius": 0.006, "pose": { "position": [0.5, 0, 0] } }));
    is_proved(&check_locally(&place, &far));
    let thin = scene(json!({ "file": "wall.xyz", "radius": 0.002, "thin": 0.05 }));
    let run = check_locally(&place, &thin);
    meets(&run, "wall");
    let said = format!("{}{}", run.out, run.err);
    assert!(said.contains("its points lie 10.00 mm apart"), "{said}");
    assert!(
        said.contains("thinned by cells of 50.00 mm from 441 to 2"),
        "{said}"
    );
}

#[test]
fn unknown_space_is_what_the_scene_says() {
    let place = Place::new();
    let of = |file: &str, unknown: Value| json!({ "objects": [{ "id": "<octomap>", "octomap": { "file": file, "unknown": unknown } }] });
    for (file, last, corner) in [
        ("unknown.bt", 0b00, 0b01),
        ("occupied.bt", 0b10, 0b01),
        ("seen.bt", 0b00, 0b10),
    ] {
        fs::write(place.folder.path().join(file), room(last, corner)).unwrap();
    }
    let run = check_locally(&place, &of("occupied.bt", "free".into()));
    meets(&run, "<octomap>");
    for file in ["unknown.bt", "seen.bt"] {
        let run = check_locally(&place, &of(file, "obstacle".into()));
        meets(&run, "<octomap>");
        let cell = "it is an unknown cell of 0.05 m of <octomap> at (0.5750, 0.0250, 0.0250)";
        assert!(run.out.contains(cell), "{}", run.out);
    }
    let run = check_locally(&place, &of("seen.bt", "free".into()));
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    let run = check_locally(&place, &of("unknown.bt", Value::Null));
    assert_eq!(run.exit, 65, "{}{}", run.out, run.err);
    let said = "octomap unknown.bt has 1 unknown cells of 0.05 m within its bounds";
    assert!(
        run.err.contains(said) && run.err.lines().count() == 1,
        "{}",
        run.err
    );
    // Nothing of it is occupied.
    let run = check_locally(&place, &of("unknown.bt", "free".into()));
    assert_eq!(run.exit, 65, "{}{}", run.out, run.err);
    assert!(
        run.err
            .contains("octomap unknown.bt has no occupied cell"),
        "{}",
        run.err
    );
}

/// The daemon: named by a path, kept over its end, shown and read again.
#[test]
fn a_daemon_takes_a_cloud_and_keeps_it() {
    let place = Place::new();
    let wall = place.file("wall.xyz", &wall(0.6));
    let check = || {
        place.taut(&[
            "check",
            &case("path2.csv"),
            "--robot",
            "arm",
            "--scene",
            "live",
            "--format",
            "json",
        ])
    };
    let shown = || place.taut(&["scene", "show", "live", "--format", "json"]);
    let before = {
        let _daemon = place.serve("");
        let scene = place.file("empty.json", r#"{ "objects": [] }"#);
        for arguments in [
            &["load-robot", "arm", "--urdf", &case("arm2.urdf")][..],
            &["load-scene", "live", &scene],
        ] {
            is_proved(&place.taut(arguments));
        }
        is_proved(&check());
        is_proved(&place.taut(&["scene", "cloud", "live", &wall, "--radius", "6mm"]));
        meets(&check(), "cloud");
        let shown = shown();
        let object = shown.json()["objects"][0].clone();
        assert_eq!(object["cloud"]["file"], "wall.xyz", "{}", shown.out);
        assert_eq!(object["cloud"]["radius"], 0.006);
        shown.out
    };
    let _daemon = place.serve("");
    assert_eq!(shown().out, before);
    meets(&check(), "cloud");
    // The next one takes its place; elsewhere nothing is hit.
    let run = place.taut(&[
        "scene", "cloud", "live", &wall, "--radius", "6mm", "--pose", "0.5", "0", "0",
    ]);
    is_proved(&run);
    is_proved(&check());
}

#[test]
fn what_a_sensor_sees_of_the_robot_is_left_out() {
    let place = Place::new();
    let seen = place.file("seen.xyz", &(wall(0.6) + &on_the_arm()));
    let _daemon = place.serve("");
    let scene = place.file("empty.json", r#"{ "objects": [] }"#);
    is_proved(&place.taut(&["load-robot", "arm", "--urdf", &case("arm2.urdf")]));
    is_proved(&place.taut(&["load-scene", "live", &scene]));
    let diff = place.folder.path().join("diff.json");
    let diff = diff.to_str().unwrap();
    let robot = case("arm2.urdf");
    let own = |at: &str, padding: &str| {
        place.taut(&[
            "scene",
            "cloud",
            "live",
            &seen,
            "--radius",
            "1mm",
            "--robot",
            &robot,
            "--at",
            at,
            "--self-padding",
            padding,
            "--write",
            diff,
        ])
    };
    let run = own("j1=-1 j2=0.2", "5mm");
    is_proved(&run);
    assert!(run.err.contains("10 points or cells on the robot, or within 5.0 mm of it, are left out; 10 of them do not touch it"), "{}", run.err);
    let written: Value = serde_json::from_str(&fs::read_to_string(diff).unwrap()).unwrap();
    let cells = &written["objects"][0]["cloud"]["content"]["cells"];
    assert_eq!(
        cells.as_array().unwrap().len(),
        441,
        "all of the wall is left"
    );
    is_proved(&place.taut(&["scene", "apply", "live", diff]));
    let run = place.taut(&[
        "check",
        &case("path2.csv"),
        "--robot",
        "arm",
        "--scene",
        "live",
        "--format",
        "json",
    ]);
    meets(&run, "cloud");
    // Two millimetres from the arm's surface are more than a millimetre.
    let run = own("j1=-1 j2=0.2", "1mm");
    assert!(
        run.err
            .contains("0 points or cells on the robot"),
        "{}",
        run.err
    );
    let run = own("j1=-1", "1mm");
    assert_eq!(run.exit, 65, "{}", run.err);
    assert!(
        run.err
            .contains("--at does not say where j2 stood"),
        "{}",
        run.err
    );
    let run = own("j1=-1 j3=0", "1mm");
    assert!(
        run.err
            .contains("\"j3\" is no variable of the robot; valid: j1, j2"),
        "{}",
        run.err
    );
}

#[test]
fn what_cannot_be_a_cloud_is_refused_in_one_line() {
    let place = Place::new();
    for (file, text, cloud, parts) in [
        (
            "nan.xyz",
            "nan 0 0\n0 inf 0\n",
            json!({ "radius": 0.01 }),
            ["nan.xyz", "none of its 2 points is finite"],
        ),
        (
            "empty.xyz",
            "",
            json!({ "radius": 0.01 }),
            ["empty.xyz", "holds no point"],
        ),
        (
            "none.xyz",
            "0 0 0\n0.01 0 0\n",
            json!({}),
            ["none.xyz", "has no radius"],
        ),
        (
            "zero.xyz",
            "0 0 0\n0.01 0 0\n",
            json!({ "radius": 0 }),
            ["radius is 0 m", "lie 10.00 mm apart"],
        ),
        (
            "huge.pcd",
            "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 100000000\nHEIGHT 1\nDATA binary\n",
            json!({ "radius": 0.01 }),
            ["100 000 000 points", "at most 16 777 216"],
        ),
        (
            "short.pcd",
            "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nDATA ascii\n1 2 3\n",
            json!({ "radius": 0.01 }),
            ["cut short", "1 of its 2 points"],
        ),
    ] {
        place.file(file, text);
        let mut words = cloud;
        words["file"] = file.into();
        let run = check_locally(
            &place,
            &json!({ "objects": [{ "id": "scan", "cloud": words }] }),
        );
        assert_eq!(
            (run.exit, run.err.lines().count()),
            (65, 1),
            "{file}: {}{}",
            run.out,
            run.err
        );
        assert!(
            parts.iter().all(|part| run.err.contains(part)),
            "{file}: {}",
            run.err
        );
    }
    let lost = json!({ "objects": [{ "id": "scan", "header": { "frame_id": "camera" }, "cloud": { "file": "none.xyz", "radius": 0.01 } }] });
    let run = check_locally(&place, &lost);
    assert_eq!(run.exit, 65);
    assert!(run.err.contains("\"camera\""), "{}", run.err);
}

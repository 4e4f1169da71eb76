//! What an answer says of what it does not cover: robots without geometry, warnings, columns that
//! are missing, models that are still made.
#![cfg(feature = "daemon")]

mod common;

use std::fs;
use std::process::Stdio;

use common::*;
use serde_json::Value;
use taut_ipc::control::{ControlReply, ControlRequest};

/// A file of `tests/cases`.
fn case(name: &str) -> String {
    format!("{}/tests/cases/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// A daemon with nothing loaded.
fn serve(place: &Place) -> Daemon {
    let config = place.file("empty.toml", "");
    let mut daemon = Daemon(
        place
            .command(&["serve", "--config", &config])
            .stdout(Stdio::null())
            .spawn()
            .unwrap(),
    );
    until("daemon is up", || {
        assert!(daemon.is_alive(), "the daemon ended");
        let state = taut_ipc::daemon_state(&place.instance);
        matches!(state, Ok(taut_ipc::DaemonState::Running { pid, .. }) if pid == daemon.pid())
    });
    daemon
}

/// An answer and its exit code.
fn json(place: &Place, arguments: &[&str]) -> (i32, Value) {
    let run = place.taut(&[arguments, &["--format", "json"]].concat());
    (run.exit, run.json())
}

fn texts(answer: &Value, field: &str) -> Vec<String> {
    let lines = answer[field]
        .as_array()
        .unwrap_or_else(|| panic!("{field}: {answer}"));
    lines
        .iter()
        .map(|line| line.as_str().unwrap().to_owned())
        .collect()
}

/// Warnings of a run for people.
fn warned(run: &Run) -> Vec<&str> {
    run.err
        .lines()
        .filter_map(|line| line.strip_prefix("warning: "))
        .collect()
}

const NOTHING: &str = "no link of robot arm2 has collision geometry: nothing is checked";

#[test]
fn a_robot_without_geometry_is_uncertified_in_every_mode_and_place() {
    let place = Place::new();
    let _daemon = serve(&place);
    let robot = case("visual-only/visual.urdf");
    let path = case("visual-only/path2.csv");
    let scene = case("visual-only/s.json");
    let about = [path.as_str(), "--robot", &robot, "--scene", &scene];
    for local in [&["--local"][..], &[]] {
        for mode in [
            "check",
            "gradient",
            "random-shortcut",
            "partial-shortcut",
            "contact",
            "hybrid",
        ] {
            let command = if mode == "check" {
                vec!["check"]
            } else {
                vec!["shorten", "--mode", mode]
            };
            let (exit, answer) = json(&place, &[&command[..], &about[..], local].concat());
            assert_eq!(
                (exit, &answer["code"], &answer["proved"]),
                (2, &(-1001).into(), &false.into()),
                "{mode}"
            );
            assert_eq!(answer["pairs"], 0);
            assert!(
                answer["uncheckable"]
                    .as_str()
                    .unwrap()
                    .starts_with(NOTHING),
                "{answer}"
            );
            assert!(
                answer["certificate"].is_null() && answer["path"] == answer["path_before"],
                "{mode}"
            );
        }
        let run = place.taut(&[&["check"][..], &about[..], local].concat());
        assert!(
            run.exit == 2
                && run
                    .out
                    .starts_with(&format!("UNCERTIFIED   {NOTHING}")),
            "{}",
            run.out
        );
    }
    let points = "joint_names: [j1, j2]\npoints:\n- {positions: [-1, 0.2], velocities: [0, 0], time_from_start: {sec: 0}}\n\
        - {positions: [0.3, 0.9], velocities: [0, 0], time_from_start: {sec: 2}}\n";
    let timed = place.file("timed.yaml", points);
    let (exit, answer) = json(&place, &["check", &timed, "--timed", "--robot", &robot]);
    assert!(
        exit == 2
            && answer["uncheckable"]
                .as_str()
                .unwrap()
                .starts_with(NOTHING),
        "{answer}"
    );
}

/// The case's robot with this collision shape in the named link.
fn with_shape(link: &str, shape: &str) -> String {
    let text = fs::read_to_string(case("visual-only/visual.urdf")).unwrap();
    let collision = format!("<collision><geometry>{shape}</geometry></collision>");
    let open = format!("<link name=\"{link}\"");
    let (before, after) = text.split_once(&open).unwrap();
    match after.strip_prefix("/>") {
        Some(after) => format!("{before}{open}>{collision}</link>{after}"),
        None => format!(
            "{before}{open}{}",
            after.replacen('>', &format!(">{collision}"), 1)
        ),
    }
}

#[test]
fn geometry_and_no_pair_is_proved_and_says_that_nothing_was_checked() {
    let place = Place::new();
    let _daemon = serve(&place);
    let path = case("visual-only/path2.csv");
    let one = place.file("one.urdf", &with_shape("tool", "<sphere radius='0.03'/>"));
    let crate_at = |x: f64| {
        let object = fs::read_to_string(case("visual-only/s.json")).unwrap();
        object.replace("[0.5, 0, 0]", &format!("[{x}, 0, 0]"))
    };
    let allowed = place.file(
        "allowed.json",
        &crate_at(5.0).replacen('{', r#"{"allowed_collisions": [["tool", "crate"]], "#, 1),
    );
    let far = place.file("far.json", &crate_at(5.0));
    for local in [&["--local"][..], &[]] {
        for scene in [&[][..], &["--scene", &allowed][..]] {
            let about = [&[path.as_str(), "--robot", &one], scene, local].concat();
            for command in ["check", "shorten"] {
                let run = place.taut(&[&[command][..], &about].concat());
                assert!(
                    run.exit == 0
                        && run
                            .out
                            .contains("proved, nothing to check: 0 pairs"),
                    "{}",
                    run.out
                );
                let (exit, answer) = json(&place, &[&[command][..], &about].concat());
                assert_eq!(
                    (exit, &answer["proved"], &answer["pairs"]),
                    (0, &true.into(), &0.into())
                );
            }
        }
        let (exit, answer) = json(
            &place,
            &[
                &["check", &path, "--robot", &one, "--scene", &far][..],
                local,
            ]
            .concat(),
        );
        assert_eq!(
            (exit, &answer["pairs"]),
            (0, &1.into()),
            "one pair that is checked is no nothing"
        );
        // Only what stands still has geometry: it is checked, and the answer says that nothing that
        // moves was.
        let base = place.file("base.urdf", &with_shape("base", "<sphere radius='0.03'/>"));
        let (exit, answer) = json(
            &place,
            &[
                &["check", &path, "--robot", &base, "--scene", &far][..],
                local,
            ]
            .concat(),
        );
        assert_eq!((exit, &answer["pairs"]), (0, &1.into()));
        let told = texts(&answer, "uncovered").concat();
        assert!(
            told.contains("no link that a joint of the path moves has collision geometry"),
            "{told}"
        );
    }
}

#[test]
fn what_a_robot_without_geometry_carries_may_collide_but_proves_nothing() {
    let place = Place::new();
    let _daemon = serve(&place);
    let robot = case("visual-only/visual.urdf");
    let path = case("visual-only/path2.csv");
    // The tool starts at (0.5489, -0.7077, 0).
    for (at, exit, code) in [("[5, 0, 0]", 2, -1001), ("[0.5489, -0.7077, 0]", 1, -10)] {
        let carried = r#""attached_collision_objects": [{"link_name": "tool", "object": {"id": "part",
            "primitives": [{"type": "sphere", "dimensions": [0.02]}], "primitive_poses": [{}]}}]"#;
        let text = fs::read_to_string(case("visual-only/s.json"))
            .unwrap()
            .replace("[0.5, 0, 0]", at);
        let scene = place.file(
            "carried.json",
            &text.replacen('{', &format!("{{{carried}, "), 1),
        );
        for local in [&["--local"][..], &[]] {
            let (got, answer) = json(
                &place,
                &[
                    &["check", &path, "--robot", &robot, "--scene", &scene][..],
                    local,
                ]
                .concat(),
            );
            assert_eq!(
                (got, &answer["code"], &answer["pairs"]),
                (exit, &code.into(), &1.into()),
                "{answer}"
            );
            let why = answer["uncheckable"]
                .as_str()
                .unwrap_or_default();
            assert_eq!(
                why.contains("only what it carries is checked (1 pair)"),
                code == -1001,
                "{answer}"
            );
        }
    }
}

#[test]
fn warnings_come_with_every_answer_in_full_or_counted() {
    let place = Place::new();
    let _daemon = serve(&place);
    let pairs: String = (0..104)
        .map(|n| format!("<disable_collisions link1='gone{n}' link2='tool'/>"))
        .collect();
    let srdf = place.file("many.srdf", &format!("<robot name='arm2'>{pairs}</robot>"));
    let robot = place.file("one.urdf", &with_shape("tool", "<sphere radius='0.03'/>"));
    let path = case("visual-only/path2.csv");
    let scene = place.file(
        "empty.json",
        r#"{"objects": [{"id": "ghost"}, {"id": "ghoul"}]}"#,
    );
    let expected = [
        "object \"ghost\" has no shapes; nothing can collide with it",
        "object \"ghoul\" has no shapes; nothing can collide with it",
        "the SRDF disables gone0 × tool, not both links of this robot (and 103 more like it)",
    ];
    let files = [
        "check", &path, "--robot", &robot, "--srdf", &srdf, "--scene", &scene,
    ];
    let local = place.taut(&[&files[..], &["--local"]].concat());
    assert_eq!(warned(&local), expected, "{}", local.err);
    let loaded = place.taut(&["load-robot", "one", "--urdf", &robot, "--srdf", &srdf]);
    assert_eq!(warned(&loaded), expected[2..], "{}", loaded.err);
    place.taut(&["load-scene", "ghosts", &scene]);
    let labels = ["check", &path, "--robot", "one", "--scene", "ghosts"];
    for way in [&files[..], &labels[..]] {
        let run = place.taut(way);
        assert_eq!(
            (run.exit, warned(&run)),
            (0, expected.to_vec()),
            "{} {}",
            run.out,
            run.err
        );
        let (_, answer) = json(&place, way);
        assert_eq!(texts(&answer, "warnings"), expected);
        assert_eq!(texts(&answer, "uncovered"), expected[..2]);
    }
    let (_, answer) = json(&place, &[&files[..], &["--local"]].concat());
    assert_eq!(
        (texts(&answer, "warnings"), texts(&answer, "uncovered")),
        (
            expected.map(str::to_owned).to_vec(),
            expected[..2]
                .iter()
                .map(|text| (*text).to_owned())
                .collect()
        )
    );

    // Without an SRDF the answer says what is left out, by label as by file.
    let bare = ["check", &path, "--robot", &robot];
    place.taut(&["load-robot", "bare", "--urdf", &robot]);
    for way in [
        &[&bare[..], &["--local"]].concat()[..],
        &bare,
        &["check", &path, "--robot", "bare"],
    ] {
        let told = "no SRDF: links joined by one joint are not checked against each other";
        assert_eq!(warned(&place.taut(way)), [told], "{way:?}");
    }
}

#[test]
fn an_answer_holds_so_many_warnings_and_counts_the_rest() {
    let place = Place::new();
    let _daemon = serve(&place);
    let robot = place.file("one.urdf", &with_shape("tool", "<sphere radius='0.03'/>"));
    let path = case("visual-only/path2.csv");
    let objects: Vec<String> = (0..300)
        .map(|n| format!(r#"{{"id": "ghost{n}"}}"#))
        .collect();
    let scene = place.file(
        "ghosts.json",
        &format!(r#"{{"objects": [{}]}}"#, objects.join(", ")),
    );
    assert_eq!(
        place
            .taut(&["load-robot", "one", "--urdf", &robot])
            .exit,
        0
    );
    assert_eq!(
        place
            .taut(&["load-scene", "ghosts", &scene])
            .exit,
        0
    );
    let (exit, answer) = json(
        &place,
        &["check", &path, "--robot", "one", "--scene", "ghosts"],
    );
    let told = texts(&answer, "uncovered");
    assert_eq!((exit, told.len()), (0, 256));
    // 300 objects and the missing SRDF.
    assert!(
        told[255].starts_with("46 warnings more than an answer holds"),
        "{}",
        told[255]
    );
    // Who read the files knows them all.
    let (_, answer) = json(
        &place,
        &["check", &path, "--robot", &robot, "--scene", &scene],
    );
    assert!((0..300).all(|n| {
        texts(&answer, "uncovered")
            .iter()
            .any(|text| text.contains(&format!("\"ghost{n}\"")))
    }));
}

#[test]
fn a_group_s_trajectory_is_taken_by_label_as_by_file() {
    let place = Place::new();
    let _daemon = serve(&place);
    let file = |name: &str| case(&format!("group-trajectory/{name}"));
    let robot = file("hand.urdf");
    let srdf = file("hand.srdf");
    let loaded = place.taut(&["load-robot", "hand", "--urdf", &robot, "--srdf", &srdf]);
    assert_eq!(loaded.exit, 0, "{}", loaded.err);
    for (path, hold) in [
        ("p.csv", None),
        ("jt.yaml", None),
        ("p.csv", Some("f_l=0.03")),
        ("jt.yaml", Some("caster_yaw=1")),
    ] {
        let path = file(path);
        let more: Vec<&str> = hold
            .iter()
            .flat_map(|hold| ["--hold", hold])
            .collect();
        let by_file = [
            &["check", &path, "--robot", &robot, "--srdf", &srdf][..],
            &more,
        ]
        .concat();
        let by_label = [&["check", &path, "--robot", "hand"][..], &more].concat();
        let of_file = place.taut(&[&by_file[..], &["--local"]].concat());
        let of_label = place.taut(&by_label);
        assert_eq!(
            (of_file.exit, of_label.exit),
            (0, 0),
            "{} {}",
            of_file.err,
            of_label.err
        );
        assert_eq!(warned(&of_file), warned(&of_label), "{path} {hold:?}");
        let still = match hold {
            None => "f_l, caster_yaw",
            Some("f_l=0.03") => "caster_yaw",
            Some(_) => "f_l",
        };
        let note = format!("the path has no column for {still}: held still at 0");
        assert!(
            warned(&of_label).contains(&note.as_str()),
            "{}",
            of_label.err
        );
        let (_, by_file) = json(&place, &[&by_file[..], &["--local"]].concat());
        let (_, by_label) = json(&place, &by_label);
        // The same robot, whoever made it: the certificates are equal to the last bit.
        assert!(
            by_file["certificate"]["robot_hash"].is_string()
                || by_file["certificate"]["robot_hash"].is_number()
        );
        assert_eq!(
            by_file["certificate"], by_label["certificate"],
            "{path} {hold:?}"
        );
        assert_eq!(
            (&by_file["path"], &by_file["variables"]),
            (&by_label["path"], &by_label["variables"])
        );
        assert_eq!(by_file["pairs"], by_label["pairs"], "{by_file}");
    }
    // What is handed to a controller has the columns that were given, also where the robot has
    // more.
    let out = place.file("out.csv", "");
    let run = place.taut(&["shorten", &file("p.csv"), "--robot", "hand", "-o", &out]);
    assert_eq!(run.exit, 0, "{} {}", run.out, run.err);
    let text = fs::read_to_string(&out).unwrap();
    assert!(
        text.lines().any(|line| line == "swing") && !text.contains("f_l"),
        "{text}"
    );
}

#[test]
fn columns_that_cannot_be_left_out_are_refused_by_label_as_by_file() {
    let place = Place::new();
    let _daemon = serve(&place);
    let text = fs::read_to_string(case("group-trajectory/hand.urdf")).unwrap();
    let robot = place.file(
        "open.urdf",
        &text.replacen(
            r#"<limit lower="0" upper="0.04"/>"#,
            r#"<limit lower="0.01" upper="0.04"/>"#,
            1,
        ),
    );
    place.taut(&["load-robot", "open", "--urdf", &robot]);
    let path = case("group-trajectory/p.csv");
    for robot in [&[robot.as_str(), "--local"][..], &["open"]] {
        let about = [&["check", &path, "--robot"][..], robot].concat();
        let run = place.taut(&about);
        let why =
            "column \"f_l\" is missing, and the joint cannot be held at 0, outside [0.01, 0.04]";
        assert!(run.exit == 65 && run.err.contains(why), "{}", run.err);
        let run = place.taut(&[&about[..], &["--hold", "f_l=0.02"]].concat());
        assert!(run.exit != 65, "{}", run.err);
        let run = place.taut(&[&about[..], &["--hold", "f_l=0.02", "--hold", "swing=1"]].concat());
        assert!(run.exit >= 64 && run.err.contains("swing"), "{}", run.err);
    }
}

/// A ball of `2 n (n - 1)` triangles as binary STL.
fn ball(n: usize) -> Vec<u8> {
    let at = |i: usize, j: usize| -> [f32; 3] {
        let t = i as f64 / n as f64 * std::f64::consts::PI;
        let f = j as f64 / n as f64 * std::f64::consts::TAU;
        let ring = if i == 0 || i == n { 0.0 } else { t.sin() };
        let turn = f64::from(!j.is_multiple_of(n)) * f;
        [
            0.1 * ring * turn.cos(),
            0.1 * ring * turn.sin(),
            0.1 * t.cos(),
        ]
        .map(|x| x as f32)
    };
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        triangles.extend((i + 1 < n).then_some([a, b, c]));
        triangles.extend((i > 0).then_some([a, c, d]));
    }
    let mut bytes = vec![b' '; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend(
            [0.0_f32; 3]
                .iter()
                .chain(triangle.as_flattened())
                .flat_map(|x| x.to_le_bytes()),
        );
        bytes.extend([0, 0]);
    }
    bytes
}

/// Three balls on sliding joints, half a metre apart, and a path on which each moves 1 cm.
fn heavy(place: &Place) -> (String, String) {
    fs::write(place.folder.path().join("ball.stl"), ball(60)).unwrap();
    let shape = "<collision><geometry><mesh filename='ball.stl'/></geometry></collision>";
    let link = |k: usize| format!("<link name='l{k}'>{shape}</link>");
    let joint = |k: usize| {
        let ends = format!(
            "<parent link='l{}'/><child link='l{k}'/><origin xyz='0.5 0 0'/>",
            k - 1
        );
        format!(
            "<joint name='j{k}' type='prismatic'>{ends}<limit lower='-0.1' upper='0.1'/></joint>"
        )
    };
    let text = [
        (0..3).map(link).collect::<String>(),
        (1..3).map(joint).collect(),
    ]
    .concat();
    let robot = place.file("heavy.urdf", &format!("<robot name='heavy'>{text}</robot>"));
    (robot, place.file("heavy.csv", "j1,j2\n0,0\n0.01,0.01\n"))
}

fn made(place: &Place) -> [f64; 2] {
    let numbers = stats(&place.client()).numbers;
    ["robots_made", "models_made"].map(|name| numbers[name])
}

#[test]
fn a_robot_s_model_is_made_once_and_a_request_that_comes_too_early_hears_why() {
    let place = Place::new();
    let _daemon = serve(&place);
    let (robot, path) = heavy(&place);
    assert_eq!(made(&place), [0.0, 0.0]);
    assert_eq!(
        place
            .taut(&["load-robot", "heavy", "--urdf", &robot])
            .exit,
        0
    );
    assert_eq!(made(&place), [1.0, 0.0], "made while it was loaded");
    let check = |more: &[&str]| {
        let run = place.taut(&[&["check", &path, "--deadline", "60s"], more].concat());
        assert_eq!(run.exit, 0, "{} {}", run.out, run.err);
        made(&place)
    };
    for _ in 0..2 {
        let made = check(&["--robot", "heavy"]);
        assert_eq!(
            made,
            [1.0, 0.0],
            "with nothing around it, it is what was loaded"
        );
    }
    let some = ControlRequest::SelectVariables {
        label: "heavy".into(),
        variables: vec!["j1".into()],
    };
    let selected = place.client().control(&some, PATIENCE).unwrap();
    assert!(matches!(selected, ControlReply::Robot(_)), "{selected:?}");
    assert_eq!(made(&place), [1.0, 0.0], "of the same solids");

    // Solids of objects are made while their scene is loaded, for every robot.
    let mesh = place.folder.path().join("ball.stl");
    let object = |id: &str, y: f64| {
        format!(
            r#"{{"id": "{id}", "pose": {{"position": [0, {y}, 0]}}, "meshes": [{{"file": {mesh:?}}}], "mesh_poses": [{{}}]}}"#
        )
    };
    for label in ["ball", "again"] {
        let scene = format!(r#"{{"objects": [{}]}}"#, object("ball", 5.0));
        let loaded = place.taut(&["load-scene", label, &place.file("ball.json", &scene)]);
        assert_eq!(loaded.exit, 0, "{}", loaded.err);
    }
    for (scene, models) in [("ball", 1.0), ("ball", 1.0), ("again", 1.0)] {
        let made = check(&["--robot", "heavy", "--scene", scene]);
        assert_eq!(made, [1.0, models], "put together once for each content");
    }
    let listed = place.taut(&["list"]).out;
    let of = |name: &str| {
        let line = listed
            .lines()
            .find(|line| line.starts_with(name));
        line.unwrap_or_else(|| panic!("no {name} in {listed}"))
    };
    assert!(
        of("robot heavy ").contains("   warm   21 240 triangles   "),
        "{listed}"
    );
    assert!(
        of("scene ball ").contains("   warm   7 080 triangles   "),
        "{listed}"
    );

    // What a change brings is made when the first request comes.
    fs::write(&mesh, ball(61)).unwrap();
    let diff = format!(
        r#"{{"is_diff": true, "objects": [{}]}}"#,
        object("more", 9.0).replacen('{', r#"{"operation": "ADD", "#, 1)
    );
    let applied = place.taut(&["scene", "apply", "ball", &place.file("diff.json", &diff)]);
    assert_eq!(applied.exit, 0, "{}", applied.err);
    let early = [
        "check",
        &path,
        "--robot",
        "heavy",
        "--scene",
        "ball",
        "--deadline",
        "1ms",
    ];
    let early = place.taut(&early);
    assert_eq!(early.exit, 4, "{} {}", early.out, early.err);
    let why = "robot heavy in scene ball is still being made: pairs of links and 2 objects";
    assert!(
        early.err.contains("LOADING")
            && early.err.contains(why)
            && early.err.contains("send again in"),
        "{}",
        early.err
    );
    assert_eq!(check(&["--robot", "heavy", "--scene", "ball"]), [1.0, 2.0]);
}

#[test]
fn a_daemon_that_is_started_again_makes_no_robot_again() {
    let place = Place::new();
    let daemon = serve(&place);
    let (robot, path) = heavy(&place);
    let loaded = place.taut(&["load-robot", "heavy", "--urdf", &robot]);
    assert_eq!(loaded.exit, 0, "{}", loaded.err);
    let some = ControlRequest::SelectVariables {
        label: "heavy".into(),
        variables: vec!["j1".into()],
    };
    let selected = place.client().control(&some, PATIENCE).unwrap();
    assert!(matches!(selected, ControlReply::Robot(_)), "{selected:?}");
    drop(daemon);
    let _daemon = serve(&place);
    for _ in 0..2 {
        let run = place.taut(&["check", &path, "--robot", "heavy", "--deadline", "60s"]);
        assert_eq!(run.exit, 0, "{} {}", run.out, run.err);
    }
    assert_eq!(
        made(&place),
        [0.0, 0.0],
        "its solids were kept, and are shared"
    );
}

#[test]
fn a_robot_whose_files_are_being_read_is_loading_and_not_unknown() {
    let place = Place::new();
    let _daemon = serve(&place);
    let (robot, path) = heavy(&place);
    let pipe = place.folder.path().join("pipe.urdf");
    assert!(
        std::process::Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    let mut load = place
        .command(&["load-robot", "slow", "--urdf", pipe.to_str().unwrap()])
        .spawn()
        .unwrap();
    until("the robot is being read", || {
        let run = place.taut(&["check", &path, "--robot", "slow"]);
        assert_ne!(run.exit, 0, "nobody has written its file");
        run.exit == 4 && run.err.contains("LOADING") && run.err.contains("its files are being read")
    });
    fs::write(&pipe, fs::read(&robot).unwrap()).unwrap();
    assert!(load.wait().unwrap().success());
    assert_eq!(
        place
            .taut(&["check", &path, "--robot", "slow"])
            .exit,
        0
    );
}

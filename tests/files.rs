//! Files that other programs write and read: trajectories, planning scenes, problems, recordings.
#![cfg(feature = "daemon")]

mod common;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::{Place, Run, config};
use serde_json::{Value, json};

fn taut(arguments: &[&str]) -> Run {
    Run::of(
        Command::new(env!("CARGO_BIN_EXE_taut"))
            .args(arguments)
            .output()
            .unwrap(),
    )
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn at(&self, name: &str) -> String {
        self.0
            .path()
            .join(name)
            .to_str()
            .unwrap()
            .to_owned()
    }

    fn write(&self, name: &str, text: &str) -> String {
        fs::write(self.0.path().join(name), text).unwrap();
        self.at(name)
    }
}

fn read_json(file: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap()
}

/// An answer with its corridor, in a file.
fn answer(folder: &Folder, problem: &str) -> String {
    let out = folder.at("answer.json");
    let run = taut(&[
        "shorten",
        &config(problem),
        "--local",
        "--corridor",
        "--budget",
        "100000",
        "-o",
        &out,
    ]);
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    out
}

#[test]
fn a_path_goes_through_csv_yaml_and_json_to_the_last_bit() {
    let folder = Folder::new();
    for problem in ["problems/arm_shelf.json", "problems/ell_window.json"] {
        let result = answer(&folder, problem);
        let path = read_json(&result)["path"].clone();
        for name in ["path.csv", "path.yaml", "path.json"] {
            let out = folder.at(name);
            let run = taut(&["export", &result, "-o", &out]);
            assert_eq!((run.exit, run.err.as_str()), (0, ""));
            let run = taut(&[
                "check",
                &out,
                "--local",
                "--problem",
                &config(problem),
                "--format",
                "json",
            ]);
            assert_eq!(run.exit, 0, "{}", run.err);
            assert_eq!(run.json()["path"], path, "{name}");
        }
        let direct = folder.at("direct.yaml");
        let arguments = [
            "shorten",
            &config(problem),
            "--local",
            "--corridor",
            "--budget",
            "100000",
            "-o",
            &direct,
        ];
        assert_eq!(taut(&arguments).exit, 0);
        assert_eq!(
            fs::read_to_string(direct).unwrap(),
            fs::read_to_string(folder.at("path.yaml")).unwrap()
        );
    }
}

#[test]
fn numbers_of_any_size_keep_their_bits() {
    let folder = Folder::new();
    let mut values = vec![
        0.0,
        -0.0,
        5e-324,
        1e-300,
        -1e300,
        f64::MAX,
        0.1 + 0.2,
        1e16,
        123_456_789.125,
        1e-7,
    ];
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    while values.len() < 500 {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        values.extend(Some(f64::from_bits(state)).filter(|value| value.is_finite()));
    }
    let rows: Vec<Vec<f64>> = values.chunks(2).map(<[f64]>::to_vec).collect();
    let mut result = read_json(&answer(&folder, "problems/corner.json"));
    result["variables"] = json!(["a b", "c: #"]);
    result["path"] = json!(rows);
    result["path_before"] = json!(rows);
    let path = taut::path::Path::from_rows(2, rows.concat()).unwrap();
    result["certificate"]["path_hash"] = json!(format!("{:016x}", path.hash()));
    result
        .as_object_mut()
        .unwrap()
        .remove("corridor");
    let result = folder.write("result.json", &result.to_string());
    let unbounded = |name: &str| taut::robot::Variable::within(name, f64::MIN, f64::MAX);
    for name in ["n.csv", "n.yaml", "n.json"] {
        let out = folder.at(name);
        assert_eq!(taut(&["export", &result, "-o", &out]).exit, 0);
        let table = taut::files::PathTable::read(Path::new(&out)).unwrap();
        let (path, _) = table
            .into_path(&[unbounded("a b"), unbounded("c: #")])
            .unwrap();
        let bits = |values: &[f64]| {
            values
                .iter()
                .map(|value| value.to_bits())
                .collect::<Vec<_>>()
        };
        assert_eq!(bits(path.as_flat()), bits(&values), "{name}");
    }
}

#[test]
fn only_a_proved_path_is_written_in_forms_that_do_not_say_so() {
    let folder = Folder::new();
    let line = r#"{ "variables": ["x", "y"], "path": [[-4, 0], [4, 0]] }"#;
    let line = folder.write("line.json", line);
    let robot = config("robots/disc.urdf");
    let wall = r#"{ "objects": [ { "id": "wall", "primitives": [ { "type": "box", "dimensions": [0.1, 2, 1] } ],
        "primitive_poses": [ {} ] } ] }"#;
    let wall = folder.write("wall.json", wall);
    let out = folder.at("out.yaml");
    let run = taut(&[
        "shorten", &line, "--local", "--robot", &robot, "--scene", &wall, "-o", &out,
    ]);
    assert!(
        run.exit == 1 && run.out.contains("COLLISION"),
        "{}",
        run.out
    );
    assert!(
        run.err
            .contains("out.yaml is not written: only .json says that its path is not proved"),
        "{}",
        run.err
    );
    assert!(!Path::new(&out).exists());
    let run = taut(&[
        "shorten",
        &line,
        "--local",
        "--robot",
        &robot,
        "-o",
        &folder.at("out.xml"),
    ]);
    assert_eq!(run.exit, 64);
    assert!(
        run.err
            .contains("its ending says no form; valid: .json, .csv, .yaml, .mcap"),
        "{}",
        run.err
    );
}

#[test]
fn trajectories_are_read_in_every_dress() {
    let folder = Folder::new();
    let robot = config("robots/disc.urdf");
    let points = "points:\n- positions: [0.5, 1]\n  time_from_start: {secs: 0, nsecs: 0}\n\
                  - positions: [1.0e-1, -2]\n  velocities: []\n  effort: [1, 2]\n  time_from_start: 1.5\n";
    let bare = format!("joint_names: [y, x]\n{points}");
    let indented = |by: &str| {
        format!(
            "{by}{}",
            bare.trim_end()
                .replace('\n', &format!("\n{by}"))
        )
    };
    let dresses = [
        ("bare.yaml", bare.clone()),
        (
            "echo.yml",
            format!("header:\n  stamp: {{sec: 1, nanosec: 2}}\n  frame_id: ''\n{bare}---\n"),
        ),
        (
            "robot.yaml",
            format!(
                "joint_trajectory:\n{}\nmulti_dof_joint_trajectory:\n  joint_names: []\n  points: []\n",
                indented("  ")
            ),
        ),
        (
            "display.yaml",
            format!("trajectory:\n- joint_trajectory:\n{}\n", indented("    ")),
        ),
        (
            "message.json",
            json!({ "joint_names": ["y", "x"], "points": [
            { "positions": [0.5, 1], "time_from_start": { "sec": 0, "nanosec": 0 } },
            { "positions": [0.1, -2], "time_from_start": { "sec": 1, "nanosec": 500_000_000 } },
        ] })
            .to_string(),
        ),
    ];
    for (name, text) in dresses {
        let file = folder.write(name, &text);
        let run = taut(&[
            "check", &file, "--local", "--robot", &robot, "--format", "json",
        ]);
        assert_eq!(run.exit, 0, "{name}: {}", run.err);
        assert_eq!(
            run.json()["path"],
            json!([[0.5, 1.0], [0.1, -2.0]]),
            "{name}"
        );
        let run = taut(&[
            "check", &file, "--timed", "--robot", &robot, "--format", "json",
        ]);
        assert_eq!(
            (run.exit, run.json()["duration_s"].as_f64()),
            (0, Some(1.5)),
            "{name}: {}",
            run.err
        );
    }
    for (text, expected) in [
        (
            "joint_names: [x, y]\npoints:\n- positions: [1, a]\n",
            "line 3 column 18: ",
        ),
        (
            "joint_names: [x, y]\npoints:\n- positions: [1, 2, '...']\n",
            "`ros2 topic echo` cut its lists: use --full-length",
        ),
        (
            "joint_names: [x, y]\npoints:\n- positions: [1]\n",
            "point 0 has 1 positions, joint_names names 2 joints",
        ),
        (
            "joint_names: [x]\npoints:\n- positions: [.nan]\n",
            "point 0 has NaN in its positions",
        ),
        (
            "joint_names: [x]\npoints:\n- positions: [1]\n---\njoint_names: [x]\npoints: []\n",
            "it holds 2 trajectories; keep one",
        ),
        (
            "world:\n  collision_objects: []\n",
            "it is a planning scene, not a path; give it as --scene",
        ),
        (
            "a: 1\n",
            "no trajectory: a trajectory has joint_names and points",
        ),
        (
            "multi_dof_joint_trajectory:\n  joint_names: [base]\n  points:\n  - transforms: []\n",
            "multi_dof_joint_trajectory moves base, which is not read here",
        ),
    ] {
        let file = folder.write("wrong.yaml", text);
        let run = taut(&["check", &file, "--local", "--robot", &robot]);
        assert!(
            run.err.contains(expected) && run.err.lines().count() == 1,
            "{expected}: {}",
            run.err
        );
        assert!(
            run.exit == 65 && run.err.contains("wrong.yaml"),
            "{}",
            run.err
        );
    }
}

/// A scene in the shape of MotionBenchMaker's files, one post of each kind.
const PLANNING_SCENE: &str = "
robot_model_name: disc
robot_state:
  joint_state: {position: [0, 0], name: [x, y]}
allowed_collision_matrix:
  entry_names: [disc, low]
  entry_values:
    - [false, true]
    - [true, false]
fixed_frame_transforms:
  - transform: {translation: [0, 0, 0], rotation: [0, 0, 0, 1]}
    child_frame_id: world
world:
  collision_objects:
    - id: low
      primitives: [{type: sphere, dimensions: [0.1]}]
      primitive_poses: [{position: [-2, -2, 0], orientation: [0, 0, 0, 1]}]
    - id: can
      primitives:
        - type: cylinder
          dimensions: [1, 0.2]
      primitive_poses:
        - position: [0, 0.9, 0]
          orientation: [0, 0, 0, 1]
    - id: wedge
      meshes:
        - vertices: [[0, 0, 0], [0.5, 0, 0], [0, 0.5, 0], [0, 0, 0.5]]
          triangles: [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
      mesh_poses: [{position: {x: 1, y: -1.5, z: 0}, orientation: {x: 0, y: 0, z: 0, w: 1}}]
";

#[test]
fn planning_scenes_and_requests_as_motion_bench_maker_writes_them() {
    let folder = Folder::new();
    let robot = config("robots/disc.urdf");
    let scene = folder.write("scene0001.yaml", PLANNING_SCENE);
    let request = |goal: f64| {
        folder.write("request0001.yaml", &format!(
            "start_state:\n  joint_state:\n    name: [y, x, other]\n    position: [0, -2, 7]\n\
             goal_constraints:\n  - joint_constraints:\n      - {{joint_name: x, position: 2}}\n      - {{joint_name: y, position: {goal}}}\n"
        ))
    };
    let check = |file: &str| {
        taut(&[
            "check", file, "--local", "--robot", &robot, "--scene", &scene, "--format", "json",
        ])
    };
    let free = check(&request(0.0));
    assert_eq!(free.exit, 0, "{}{}", free.out, free.err);
    assert_eq!(free.json()["path"], json!([[-2.0, 0.0], [2.0, 0.0]]));
    let smallest = &free.json()["smallest_clearance"];
    assert!(smallest.is_null(), "the can is 0.4 away: {smallest}");
    let met = check(&request(1.8));
    assert_eq!(
        (met.exit, met.json()["names"].clone()),
        (1, json!(["disc", "can"])),
        "{}",
        met.out
    );
    let allowed = folder.write("at_low.csv", "x,y\n-2,-2\n-2,-1.9\n");
    assert_eq!(check(&allowed).exit, 0, "disc and low are allowed to touch");
    let mesh = check(&folder.write("at_wedge.csv", "x,y\n1,-2.5\n1,-1.2\n"));
    assert_eq!(
        (mesh.exit, mesh.json()["names"].clone()),
        (1, json!(["disc", "wedge"])),
        "{}",
        mesh.out
    );
    let wrong = folder.write(
        "wrong.yaml",
        &PLANNING_SCENE.replace("[true, false]", "[true]"),
    );
    let run = taut(&[
        "check", &allowed, "--local", "--robot", &robot, "--scene", &wrong,
    ]);
    assert!(
        run.exit == 65
            && run
                .err
                .contains("has 1 entries in the row of low, 2 names"),
        "{}",
        run.err
    );
}

#[test]
fn one_of_vamps_problems_is_scene_and_straight_path() {
    let folder = Folder::new();
    let solid = |extra: Value| {
        let mut solid = json!({ "name": "post", "position": [0, 1, 0], "orientation_euler_xyz": [0, 0, 0],
            "orientation_quat_xyzw": [0, 0, 0, 1] });
        solid
            .as_object_mut()
            .unwrap()
            .extend(extra.as_object().unwrap().clone());
        solid
    };
    let problem = |index: u64, goal: [f64; 2]| {
        json!({ "index": index, "valid": true, "start": [-2, 0], "goals": [goal],
            "sphere": [solid(json!({ "radius": 0.2 }))], "cylinder": [],
            "box": [solid(json!({ "half_extents": [0.1, 0.1, 0.4] }))] })
    };
    let file = json!({ "robot": "disc", "joints": ["x", "y"],
        "problems": { "posts": [problem(1, [2.0, 0.0]), problem(2, [2.0, 2.0])] } });
    let file = folder.write("problems.json", &file.to_string());
    let robot = config("robots/disc.urdf");
    let select = |selection: &str| {
        taut(&[
            "check", &file, "--local", "--robot", &robot, "--select", selection, "--format", "json",
        ])
    };
    let free = select("posts:1");
    assert_eq!(
        (free.exit, free.json()["path"].clone()),
        (0, json!([[-2.0, 0.0], [2.0, 0.0]])),
        "{}",
        free.err
    );
    assert_eq!(select("posts:2").exit, 1);
    let own = folder.write("own.csv", "x,y\n0,0\n0,2\n");
    let arguments = [
        "check", &own, "--local", "--robot", &robot, "--scene", &file, "--select", "posts:1",
    ];
    let run = taut(&arguments);
    assert!(
        run.exit == 1 && run.out.contains("disc × post"),
        "{}{}",
        run.out,
        run.err
    );
    for selection in ["posts:3", "posts", "rooms:1"] {
        let run = select(selection);
        let expected = format!("it has no problem {selection:?}; valid: posts:1 to posts:2");
        assert!(run.exit == 65 && run.err.contains(&expected), "{}", run.err);
    }
    let run = taut(&["check", &file, "--local", "--robot", &robot]);
    assert!(
        run.exit == 65
            && run
                .err
                .contains("choose one by --select SET:INDEX: posts:1 to posts:2"),
        "{}",
        run.err
    );
}

/// A trajectory of the disc between two points on the x axis that swings out by a quarter of
/// `speed`.
fn swing(folder: &Folder, name: &str, speed: f64, with_velocities: bool) -> String {
    let velocities = |speed: f64| {
        if with_velocities {
            format!("  velocities: [1, {speed}]\n")
        } else {
            String::new()
        }
    };
    folder.write(
        name,
        &format!(
            "joint_names: [x, y]\npoints:\n- positions: [0, 0]\n{}  time_from_start: {{sec: 0, nanosec: 500000000}}\n\
         - positions: [1, 0]\n{}  time_from_start: {{sec: 1, nanosec: 500000000}}\n",
            velocities(speed),
            velocities(-speed)
        ),
    )
}

#[test]
fn a_wall_of_a_millimetre_beside_two_points_is_met_by_the_curve_between_them() {
    let folder = Folder::new();
    let robot = config("robots/disc.urdf");
    // The disc's radius is 0.3 m: y = 0.25 is met at 0.55.
    let wall = |y: f64| {
        folder.write(
            "wall.json",
            &json!({ "objects": [ { "id": "wall",
            "primitives": [ { "type": "box", "dimensions": [4, 0.001, 1] } ],
            "primitive_poses": [ { "position": [0.5, y, 0] } ] } ] })
            .to_string(),
        )
    };
    let check = |file: &str, more: &[&str]| {
        let scene = folder.at("wall.json");
        let arguments = [
            "check", file, "--timed", "--robot", &robot, "--scene", &scene,
        ];
        taut(&[&arguments[..], more].concat())
    };
    let cubic = swing(&folder, "cubic.yaml", 1.0, true);
    let linear = swing(&folder, "linear.yaml", 1.0, false);
    wall(0.549);
    let met = check(&cubic, &["--format", "json"]);
    let found = met.json();
    assert_eq!(
        (met.exit, &found["reason"], &found["names"]),
        (1, &json!("COLLISION"), &json!(["disc", "wall"]))
    );
    let at = found["at_s"].as_f64().unwrap();
    assert!(
        (0.75..=1.0).contains(&at) && found["point"] == json!(0),
        "{found}"
    );
    let line = check(&cubic, &[]).out;
    assert!(
        line.starts_with("COLLISION at 0.") && line.contains("after point 1 of 2: disc × wall"),
        "{line}"
    );
    assert_eq!(
        check(&linear, &["--strict"]).exit,
        0,
        "the straight line keeps away"
    );
    wall(0.5529);
    let free = check(&cubic, &["--strict", "--format", "json"]);
    assert_eq!(
        (free.exit, &free.json()["proved"]),
        (0, &json!(true)),
        "{}{}",
        free.out,
        free.err
    );
    assert!(free.err.is_empty());
    assert!(
        free.json()["clearance_m"].as_f64().unwrap() <= 2.4e-3 + 1e-9,
        "{}",
        free.out
    );
    assert!(
        check(&cubic, &[])
            .err
            .contains("the first point is at 0.5 s")
    );
    wall(0.5509);
    let close = check(&cubic, &["--strict", "--format", "json"]);
    assert_eq!(
        (close.exit, &close.json()["reason"]),
        (2, &json!("TOO_CLOSE"))
    );
    let lowered = check(&cubic, &["--format", "json"]);
    let mut floors = lowered.json()["floors_lowered"].take();
    // 0.9 of what is kept.
    let floor = floors[0]["floor"].take().as_f64().unwrap();
    assert!((floor - 0.36e-3).abs() < 1e-9, "{floor}");
    assert_eq!(
        (lowered.exit, floors),
        (
            0,
            json!([{"kind": "clearance", "unit": "m", "names": ["disc", "wall"], "floor": null}])
        )
    );

    wall(60.0);
    let outside = check(
        &swing(&folder, "wide.yaml", 24.0, true),
        &["--format", "json"],
    );
    assert_eq!(
        (
            outside.exit,
            &outside.json()["reason"],
            &outside.json()["variable"]
        ),
        (2, &json!("LIMIT"), &json!("y"))
    );
    assert!(
        (outside.json()["value"].as_f64().unwrap() - 6.0).abs() < 1e-9,
        "{}",
        outside.out
    );
}

#[test]
fn a_trajectory_without_times_or_with_times_that_stand_still_is_refused() {
    let folder = Folder::new();
    let robot = config("robots/disc.urdf");
    let text = "joint_names: [x, y]\npoints:\n- positions: [0, 0]\n  time_from_start: 0\n- positions: [1, 0]\n";
    for (file, expected) in [
        (
            folder.write("none.yaml", text),
            "a point has no time_from_start; without times it is a path",
        ),
        (
            folder.write("still.yaml", &format!("{text}  time_from_start: 0\n")),
            "point 1: its time is 0 s, that of the point before 0 s",
        ),
        (
            folder.write(
                "lone.yaml",
                &format!("{text}  accelerations: [1, 1]\n  time_from_start: 1\n"),
            ),
            "point 1: it has accelerations but no velocities",
        ),
    ] {
        let run = taut(&["check", &file, "--timed", "--robot", &robot]);
        assert!(run.exit == 65 && run.err.contains(expected), "{}", run.err);
    }
}

/// What others may do with an answer's path: be at its waypoints at these times, straight between
/// them.
fn timed(folder: &Folder, answer: &Value, aside: f64) -> String {
    let rows = answer["path"].as_array().unwrap();
    let points = rows.iter().enumerate().map(|(index, row)| {
        let mut row = row.clone();
        if index == 1 {
            row[0] = json!(row[0].as_f64().unwrap() + aside);
        }
        json!({ "positions": row, "time_from_start": index as f64 })
    });
    let trajectory =
        json!({ "joint_names": answer["variables"], "points": points.collect::<Vec<_>>() });
    folder.write("timed.json", &trajectory.to_string())
}

#[test]
fn a_trajectory_is_inside_the_corridor_of_its_answer_or_not() {
    let folder = Folder::new();
    let file = answer(&folder, "problems/arm_shelf.json");
    let result = read_json(&file);
    let corridor = &result["corridor"];
    let slack = |segment: usize| corridor["slack_m"][segment].as_f64().unwrap();
    let reach = corridor["coordinates"][0]["reach_m"]
        .as_f64()
        .unwrap();
    let narrow = slack(0).min(slack(1)) / reach;
    assert!(narrow > 0.0, "{corridor}");
    let against = |file: &str, answer: &str| {
        taut(&[
            "check",
            file,
            "--timed",
            "--against",
            answer,
            "--format",
            "json",
        ])
    };
    for (aside, exit) in [
        (0.0, 0),
        (0.9 * narrow, 0),
        (1.1 * slack(0).max(slack(1)) / reach + 0.05, 2),
    ] {
        let run = against(&timed(&folder, &result, aside), &file);
        assert_eq!(
            (run.exit, run.json()["inside"].as_bool()),
            (exit, Some(exit == 0)),
            "{aside}: {}{}",
            run.out,
            run.err
        );
    }
    // What is inside is free by the robot and the scene too.
    let inside = timed(&folder, &result, 0.9 * narrow);
    let run = taut(&[
        "check",
        &inside,
        "--timed",
        "--problem",
        &config("problems/arm_shelf.json"),
        "--clearance",
        "0.5mm",
    ]);
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);

    let mut wider = result.clone();
    wider["corridor"]["slack_m"][0] = json!(0.09);
    let wider = folder.write("wider.json", &wider.to_string());
    let run = against(&timed(&folder, &result, 0.0), &wider);
    assert!(
        run.exit == 65
            && run
                .err
                .contains("its certificate does not bear out its corridor"),
        "{}",
        run.err
    );
    let mut without = result.clone();
    without
        .as_object_mut()
        .unwrap()
        .remove("corridor");
    let without = folder.write("without.json", &without.to_string());
    let run = against(&timed(&folder, &result, 0.0), &without);
    assert!(
        run.exit == 65
            && run
                .err
                .contains("the answer has no corridor; ask for it"),
        "{}",
        run.err
    );
}

#[test]
fn the_corridor_is_borne_out_by_the_certificate_and_is_the_same_through_the_daemon() {
    let place = Place::new();
    let _daemon = place.serve("");
    let folder = Folder::new();
    for name in ["arm_shelf", "corner", "exchange_arms"] {
        let problem = config(&format!("problems/{name}.json"));
        let arguments = ["check", problem.as_str(), "--corridor", "--format", "json"];
        let daemon = place.taut(&arguments);
        let local = taut(&[&arguments[..], &["--local"]].concat());
        assert_eq!(
            daemon.json()["corridor"],
            local.json()["corridor"],
            "{name}"
        );
        assert_eq!(
            daemon.json()["certificate"],
            local.json()["certificate"],
            "{name}"
        );
        assert!(
            local.json()["corridor"]["slack_m"]
                .as_array()
                .is_some_and(|slack| !slack.is_empty())
        );
        let narrow =
            taut(&[&["check", problem.as_str(), "--format", "json", "--local"][..]].concat());
        assert!(narrow.json()["corridor"].is_null());
        let clearance = |run: &Run| {
            run.json()["certificate"]["segments"]
                .as_array()
                .unwrap()
                .iter()
                .map(|segment| segment["clearance_m"].as_f64().unwrap())
                .sum::<f64>()
        };
        assert!(
            clearance(&local) > 1.5 * clearance(&narrow),
            "{name}: {} {}",
            clearance(&local),
            clearance(&narrow)
        );
        let proof = folder.write("proof.json", &local.out);
        let verified = taut(&["check", &problem, "--certificate", &proof]);
        assert_eq!(verified.exit, 0, "{name}: {}{}", verified.out, verified.err);
    }
}

#[test]
fn parts_of_an_answer_are_written_alone() {
    let folder = Folder::new();
    let file = answer(&folder, "problems/corner.json");
    let result = read_json(&file);
    let proof = folder.at("proof.json");
    let table = folder.at("corridor.csv");
    assert_eq!(
        taut(&["export", &file, "--what", "certificate", "-o", &proof]).exit,
        0
    );
    assert_eq!(read_json(&proof), result["certificate"]);
    assert_eq!(
        taut(&["export", &file, "--what", "corridor", "-o", &table]).exit,
        0
    );
    let text = fs::read_to_string(&table).unwrap();
    let first: Vec<&str> = text
        .lines()
        .nth(2)
        .unwrap()
        .split(',')
        .collect();
    assert_eq!(
        first.len(),
        2 + result["corridor"]["coordinates"]
            .as_array()
            .unwrap()
            .len()
    );
    assert_eq!(
        first[1].parse::<f64>().unwrap(),
        result["corridor"]["slack_m"][0]
            .as_f64()
            .unwrap()
    );
    assert_eq!(
        taut(&[
            "export",
            &file,
            "--what",
            "corridor",
            "-o",
            &folder.at("c.yaml")
        ])
        .exit,
        64
    );
}

#[test]
fn a_recording_holds_joints_links_obstacles_and_the_corridor() {
    let folder = Folder::new();
    let file = answer(&folder, "problems/arm_shelf.json");
    let result = read_json(&file);
    let bare = folder.at("bare.mcap");
    let whole = folder.at("whole.mcap");
    let mut alone = result.clone();
    alone["subject"]["robot"]["files"] = Value::Null;
    assert_eq!(
        taut(&[
            "export",
            &folder.write("alone.json", &alone.to_string()),
            "-o",
            &bare
        ])
        .exit,
        0
    );
    let run = taut(&[
        "export",
        &file,
        "-o",
        &whole,
        "--problem",
        &config("problems/arm_shelf.json"),
    ]);
    assert_eq!((run.exit, run.err.as_str()), (0, ""));
    let of_topic = |file: &str, topic: &str| -> Vec<Value> {
        let bytes = fs::read(file).unwrap();
        let messages = mcap::MessageStream::new(&bytes)
            .unwrap()
            .map(Result::unwrap);
        let wanted = messages.filter(|message| message.channel.topic == topic);
        wanted
            .map(|message| serde_json::from_slice(&message.data).unwrap())
            .collect()
    };
    for file in [&bare, &whole] {
        let joints = of_topic(file, "/joints");
        let rows: Vec<Value> = joints
            .iter()
            .map(|joint| joint["position"].clone())
            .collect();
        assert_eq!(json!(rows), result["path"]);
        let slack: Vec<Value> = of_topic(file, "/corridor")
            .iter()
            .map(|message| message["slack_m"].clone())
            .collect();
        assert_eq!(json!(slack), result["corridor"]["slack_m"]);
    }
    assert!(of_topic(&bare, "/transforms").is_empty());
    let transforms = of_topic(&whole, "/transforms");
    let scene = of_topic(&whole, "/scene");
    assert_eq!((transforms.len(), scene.len()), (301, 1));
    let ids: Vec<&str> = scene[0]["entities"]
        .as_array()
        .unwrap()
        .iter()
        .map(|entity| entity["id"].as_str().unwrap())
        .collect();
    assert!(
        ids.contains(&"shelf_middle") && ids.contains(&"link6"),
        "{ids:?}"
    );
    let first = |message: &Value| message["transforms"].as_array().unwrap().len();
    assert!(
        transforms
            .iter()
            .all(|message| first(message) == first(&transforms[0]))
    );
    assert_ne!(transforms[0]["transforms"], transforms[300]["transforms"]);
    read_by_python(&folder, &whole);
}

/// The format's own reader in another language; skipped where its package is out of reach.
fn read_by_python(folder: &Folder, file: &str) {
    let script = folder.write(
        "read.py",
        "
import json, sys
from mcap.reader import make_reader
topics = {}
with open(sys.argv[1], 'rb') as file:
    for schema, channel, message in make_reader(file).iter_messages():
        assert schema.encoding == 'jsonschema' and channel.message_encoding == 'json'
        assert json.loads(schema.data)['type'] == 'object'
        json.loads(message.data)
        topics[channel.topic + ' ' + schema.name] = topics.get(channel.topic + ' ' + schema.name, 0) + 1
print(json.dumps(topics, sort_keys=True))
",
    );
    let Some(python) = common::python::python(&["mcap==1.6.0"]) else {
        return;
    };
    let run = Run::of(
        Command::new(python)
            .arg(script)
            .arg(file)
            .output()
            .unwrap(),
    );
    assert_eq!(run.exit, 0, "{}", run.err);
    let topics = run.json();
    assert_eq!(topics["/transforms foxglove.FrameTransforms"], json!(301));
    assert_eq!(topics["/scene foxglove.SceneUpdate"], json!(1));
    assert!(
        topics["/joints taut.JointState"].as_u64() >= Some(2),
        "{topics}"
    );
}

//! Robot files and paths that others read without complaint, in `tests/cases`, with their right
//! answers: through the command line alone and through the daemon.
#![cfg(feature = "daemon")]

mod common;

use common::*;

/// A file of a case.
fn case(name: &str) -> String {
    format!("{}/tests/cases/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// The answer of `--local` and of the daemon, which must be the same but for times.
struct Both {
    place: Place,
    _daemon: Daemon,
}

impl Both {
    fn new() -> Self {
        let place = Place::new();
        let daemon = place.serve("");
        Self {
            place,
            _daemon: daemon,
        }
    }

    fn run(&self, arguments: &[&str], judge: impl Fn(&Run, &str)) {
        for more in [&["--local"][..], &[]] {
            let run = self.place.taut(&[arguments, more].concat());
            judge(
                &run,
                &format!(
                    "{arguments:?} {more:?}: exit {}\n{}{}",
                    run.exit, run.out, run.err
                ),
            );
        }
    }

    fn check(&self, path: &str, robot: &str, more: &[&str], judge: impl Fn(&Run, &str)) {
        let path = case(path);
        let robot = case(robot);
        self.run(
            &[&["check", &path, "--robot", &robot], more].concat(),
            judge,
        );
    }
}

/// Whether something stands in a warning of the run.
fn warned(run: &Run, part: &str) -> bool {
    run.err
        .lines()
        .any(|line| line.starts_with("warning: ") && line.contains(part))
}

#[test]
fn a_quaternion_near_the_vertical_is_read_to_the_last_bit() {
    let both = Both::new();
    let scene = case("quat-near-vertical/post.json");
    let deepest = both.place.file("deepest.csv", "j\n0\n");
    for robot in [
        "quat-near-vertical/quat.urdf",
        "quat-near-vertical/rpy.urdf",
    ] {
        both.check(
            "quat-near-vertical/path.csv",
            robot,
            &["--scene", &scene],
            |run, said| {
                assert!(run.exit == 1 && run.out.contains("arm × post"), "{said}");
            },
        );
        both.run(
            &[
                "check",
                &deepest,
                "--robot",
                &case(robot),
                "--scene",
                &scene,
                "--format",
                "json",
            ],
            |run, said| {
                assert_eq!(run.exit, 1, "{said}");
                let depth = -run.json()["amount"].as_f64().unwrap();
                assert!((depth - 3.80e-3).abs() < 5e-6, "{said}");
            },
        );
    }
}

#[test]
fn what_is_shown_is_turned_as_what_is_checked() {
    let place = Place::new();
    let [result, page] = ["result.json", "page.html"].map(|name| place.folder.path().join(name));
    let [result, page] = [result.to_str().unwrap(), page.to_str().unwrap()];
    let path = case("visual-quat/p.csv");
    let robot = case("visual-quat/robot.urdf");
    let made = place.taut(&["shorten", &path, "--robot", &robot, "--local", "-o", result]);
    assert_eq!(made.exit, 0, "{}", made.err);
    let drawn = place.taut(&["view", result, "-o", page]);
    assert_eq!(drawn.exit, 0, "{}", drawn.err);
    let text = std::fs::read_to_string(page).unwrap();
    for shape in ["visual", "collision"] {
        let (_, after) = text
            .split_once(&format!(
                "\\u003c{shape}>\\u003corigin xyz=\\\"0 0 0\\\" rpy=\\\"0 0 "
            ))
            .unwrap();
        let turn: f64 = after
            .split_once('\\')
            .unwrap()
            .0
            .parse()
            .unwrap();
        assert!(
            (turn - std::f64::consts::FRAC_PI_2).abs() < 1e-14,
            "{shape}: {turn}"
        );
    }
}

#[test]
fn xml_that_others_read_is_read() {
    for (robot, columns, warning) in [
        ("same_without_prefix", "j", None),
        ("undeclared_prefix", "j", Some("\"drake\"")),
        ("blank_line_before_declaration", "j", None),
        ("prefix", "j1,j2", Some("\"controller\"")),
        ("latin", "j1,j2", None),
        ("doctype", "j1,j2", None),
    ] {
        // A daemon has trifles of the file that brought the content first, and some of these are
        // alike.
        let both = Both::new();
        let path = both.place.file(
            "path.csv",
            &format!(
                "{columns}\n{}\n",
                columns
                    .replace(['1', '2'], "")
                    .replace('j', "0.1")
            ),
        );
        let robot = case(&format!("xml/{robot}.urdf"));
        both.run(&["check", &path, "--robot", &robot], |run, said| {
            assert_eq!(run.exit, 0, "{said}");
            assert!(warning.is_none_or(|part| warned(run, part)), "{said}");
        });
    }
    Both::new().check("xml/path.csv", "xml/xacro_undecl.urdf", &[], |run, said| {
        assert!(
            run.exit == 65
                && run.err.contains("<xacro:if>")
                && run.err.contains("xacro FILE.xacro"),
            "{said}"
        );
    });
}

#[test]
fn an_srdf_with_errors_in_groups_and_states_refuses_no_robot() {
    let both = Both::new();
    for (folder, part) in [
        ("srdf-group-errors", "\"missing\""),
        ("srdf-state-errors", "group"),
    ] {
        both.check(
            &format!("{folder}/path.csv"),
            &format!("{folder}/r.urdf"),
            &[],
            |run, said| {
                assert!(run.exit == 0 && warned(run, part), "{said}");
            },
        );
    }
}

#[test]
fn an_srdf_without_pairs_gets_the_hint_and_the_line_helps() {
    let both = Both::new();
    let line = r#"<disable_collisions link1="base" link2="upper" reason="Adjacent"/>"#;
    both.check(
        "srdf-without-pairs/path.csv",
        "srdf-without-pairs/r.urdf",
        &[],
        |run, said| {
            assert_eq!(run.exit, 1, "{said}");
            assert!(
                warned(run, "the SRDF disables no pair") && warned(run, line),
                "{said}"
            );
        },
    );
    let srdf = both
        .place
        .file("pasted.srdf", &format!("<robot name='arm'>{line}</robot>"));
    both.check(
        "srdf-without-pairs/path.csv",
        "srdf-without-pairs/r.urdf",
        &["--srdf", &srdf],
        |run, said| {
            assert_eq!((run.exit, run.err.as_str()), (0, ""), "{said}");
        },
    );
}

#[test]
fn a_pair_that_separates_is_never_offered_for_switching_off() {
    let both = Both::new();
    for (path, exit) in [("hits", 1), ("free", 0)] {
        let path = format!("rest-contacts-advice/{path}.csv");
        both.check(&path, "rest-contacts-advice/r.urdf", &[], |run, said| {
            assert_eq!(run.exit, exit, "{said}");
            assert!(!run.err.contains("disable_collisions"), "{said}");
            assert!(
                warned(
                    run,
                    "base × forearm collide with every joint at 0 and are apart"
                ),
                "{said}"
            );
        });
    }
}

#[test]
fn markers_without_a_size_are_left_out() {
    let both = Both::new();
    for (robot, path, shape) in [
        ("zero", "j1\n0\n0.5\n", "<sphere>"),
        ("zerobox", "j1\n0\n0.5\n", "<box>"),
        ("zero_sphere", "j\n0\n0.5\n", "<sphere>"),
    ] {
        let path = both.place.file("path.csv", path);
        let robot = case(&format!("zero-size-shapes/{robot}.urdf"));
        both.run(&["check", &path, "--robot", &robot], |run, said| {
            assert!(
                run.exit == 0 && warned(run, &format!("{shape} has no size; it is left out")),
                "{said}"
            );
        });
    }
}

#[test]
fn columns_are_what_they_are_called() {
    let both = Both::new();
    for (path, robot) in [
        ("joint-named-8/path.csv", "joint-named-8/joint_named_8.urdf"),
        (
            "joint-named-8/path.json",
            "joint-named-8/joint_named_8.urdf",
        ),
    ] {
        both.check(path, robot, &[], |run, said| {
            assert_eq!(run.exit, 0, "{said}")
        });
    }
    both.check(
        "recorded-csv/recorded.csv",
        "recorded-csv/r.urdf",
        &["--format", "json"],
        |run, said| {
            assert!(run.exit == 0 && run.json()["variables"][0] == "j", "{said}");
        },
    );
    both.check(
        "recorded-csv/recorded.csv",
        "recorded-csv/r.urdf",
        &[],
        |run, said| {
            assert!(run.exit == 0 && warned(run, "time"), "{said}");
        },
    );
    let fixed = both
        .place
        .file("fixed.csv", "t,j1,jp\n0,0,0\n1,0.5,0\n");
    let robot = case("zero-size-shapes/zero.urdf");
    both.run(&["check", &fixed, "--robot", &robot], |run, said| {
        assert!(run.exit == 0 && warned(run, "t, jp"), "{said}");
    });
    let wrong = both.place.file("wrong.csv", "elbow\n0\n");
    both.run(&["check", &wrong, "--robot", &robot], |run, said| {
        let named = run.err.contains("wrong.csv")
            && !run.err.contains(".urdf")
            && run.err.contains("valid: j1");
        assert!(run.exit == 65 && named, "{said}");
    });
    // The daemon's robots are known by label: the columns are told apart there as well.
    let recorded = case("recorded-csv/recorded.csv");
    let load = both.place.taut(&[
        "load-robot",
        "two_links",
        "--urdf",
        &case("recorded-csv/r.urdf"),
    ]);
    assert_eq!(load.exit, 0, "{}", load.err);
    let run = both
        .place
        .taut(&["check", &recorded, "--robot", "two_links"]);
    assert!(
        run.exit == 0 && warned(&run, "time"),
        "{}{}",
        run.out,
        run.err
    );
    let load = both
        .place
        .taut(&["load-robot", "marked", "--urdf", &robot]);
    assert_eq!(load.exit, 0, "{}", load.err);
    let run = both
        .place
        .taut(&["check", &fixed, "--robot", "marked"]);
    assert!(
        run.exit == 0 && warned(&run, "t, jp"),
        "{}{}",
        run.out,
        run.err
    );
}

/// Lowest and highest value of each column.
fn ranges(rows: &serde_json::Value) -> Vec<(f64, f64)> {
    let rows: Vec<Vec<f64>> = serde_json::from_value(rows.clone()).unwrap();
    let of = |column: usize| {
        let values = || rows.iter().map(|row| row[column]);
        (
            values().fold(f64::INFINITY, f64::min),
            values().fold(f64::NEG_INFINITY, f64::max),
        )
    };
    (0..rows[0].len()).map(of).collect()
}

/// The joints of the case that have soft limits.
const SOFT: [(usize, (f64, f64)); 2] = [(6, (2.2387, 2.8341)), (7, (-0.4519, 1.0978))];

const MODES: [&str; 5] = [
    "hybrid",
    "contact",
    "gradient",
    "random-shortcut",
    "partial-shortcut",
];

#[test]
fn no_optimizer_leaves_soft_limits() {
    let both = Both::new();
    let path = case("soft-limits/path.csv");
    let robot = case("soft-limits/robot.urdf");
    let scene = case("soft-limits/scene.json");
    for mode in MODES {
        let answer = both.place.folder.path().join("answer.json");
        let arguments = [
            "shorten",
            &path,
            "--robot",
            &robot,
            "--scene",
            &scene,
            "--mode",
            mode,
            "-o",
            answer.to_str().unwrap(),
        ];
        both.run(&arguments, |run, said| {
            assert!(
                run.exit == 0 && !warned(run, "soft limits"),
                "{mode}: {said}"
            );
            let answer: serde_json::Value =
                serde_json::from_slice(&std::fs::read(&answer).unwrap()).unwrap();
            let ranges = ranges(&answer["path"]);
            for (joint, soft) in SOFT {
                let range = ranges[joint - 1];
                assert!(
                    soft.0 <= range.0 && range.1 <= soft.1,
                    "{mode}: joint {joint} is in {range:?}, not {soft:?}"
                );
            }
        });
    }
    // Described are the bounds that count.
    let run = both
        .place
        .taut(&["load-robot", "soft", "--urdf", &robot]);
    assert_eq!(run.exit, 0, "{}", run.err);
    let run = both.place.taut(&["describe", "soft"]);
    for (_, (lower, upper)) in SOFT {
        assert!(
            run.out
                .contains(&format!("{lower:.4} to {upper:.4}")),
            "{}",
            run.out
        );
    }
}

#[test]
fn a_path_outside_soft_limits_is_warned_about_and_never_moves_further_out() {
    let both = Both::new();
    let scene = case("soft-limits/scene.json");
    let path = case("soft-limits/path.csv");
    // Much tighter than the path: it begins and ends outside, by up to two radians.
    let text = std::fs::read_to_string(case("soft-limits/robot.urdf")).unwrap();
    let soft =
        r#"<safety_controller k_velocity="1" soft_lower_limit="-0.5" soft_upper_limit="0.5"/>"#;
    let lines = text
        .lines()
        .filter(|line| !line.contains("<safety_controller"));
    let tight: String = lines
        .map(|line| line.replace("<limit", &format!("{soft}<limit")) + "\n")
        .collect();
    let robot = both.place.file("tight.urdf", &tight);
    std::fs::copy(
        case("soft-limits/robot.srdf"),
        both.place.folder.path().join("tight.srdf"),
    )
    .unwrap();
    let rows = std::fs::read_to_string(&path).unwrap();
    let rows: Vec<Vec<f64>> = rows
        .lines()
        .skip(1)
        .map(|l| {
            l.split(',')
                .map(|x| x.parse().unwrap())
                .collect()
        })
        .collect();
    let before = ranges(&serde_json::to_value(rows).unwrap());
    assert!(before.iter().any(|range| range.1 > 0.5) && before.iter().any(|range| range.0 < -0.5));
    for mode in MODES {
        let answer = both.place.folder.path().join("answer.json");
        let arguments = [
            "shorten",
            &path,
            "--robot",
            &robot,
            "--scene",
            &scene,
            "--mode",
            mode,
            "-o",
            answer.to_str().unwrap(),
        ];
        both.run(&arguments, |run, said| {
            assert!(
                run.exit == 0 && warned(run, "soft limits") && warned(run, "joint6 by 2.324"),
                "{mode}: {said}"
            );
            let answer: serde_json::Value =
                serde_json::from_slice(&std::fs::read(&answer).unwrap()).unwrap();
            for (joint, (after, before)) in ranges(&answer["path"])
                .iter()
                .zip(&before)
                .enumerate()
            {
                let inside = before.0.min(-0.5) <= after.0 && after.1 <= before.1.max(0.5);
                assert!(
                    inside,
                    "{mode}: joint {joint} is in {after:?}, was in {before:?}"
                );
            }
        });
    }
}

#[test]
fn hard_limits_refuse_whatever_soft_ones_are() {
    let both = Both::new();
    let robot = case("soft-limits/robot.urdf");
    for (value, exit, part) in [
        ("3.7", 0, Some("joint6 by 0.866 of [2.2387, 2.8341]")),
        ("3.75255", 0, Some("outside its limits")),
        ("3.7527", 65, None),
    ] {
        let path = both
            .place
            .file("path.csv", &format!("joint4,joint6\n-2,{value}\n-2,3.6\n"));
        both.run(&["check", &path, "--robot", &robot], |run, said| {
            assert!(
                run.exit == exit && part.is_none_or(|part| warned(run, part)),
                "{value}: {said}"
            );
        });
    }
    // Joints that are held, too: at 0 where that is between soft and hard limits.
    let held = both
        .place
        .file("held.csv", "joint1,joint4\n0,-2\n0.1,-2\n");
    both.run(&["check", &held, "--robot", &robot], |run, said| {
        assert!(
            run.exit == 0 && warned(run, "joint6 is held at 0, outside its soft limits"),
            "{said}"
        );
    });
}

#[test]
fn a_message_that_has_the_robot_elsewhere_is_not_proved_for_another_one() {
    let both = Both::new();
    let robot = case("rest-contacts-advice/r.urdf");
    let text = "trajectory_start:\n  joint_state:\n    name: [shoulder, elbow, gone]\n    position: [0.3, -0.5, 1]\n\
        trajectory:\n- joint_trajectory:\n    joint_names: [shoulder]\n    points:\n    - positions: [0.3]\n    - positions: [0.1]\n---\n";
    let path = both.place.file("path.yaml", text);
    both.run(&["check", &path, "--robot", &robot], |run, said| {
        assert!(
            run.exit == 65
                && run.err.contains("path.yaml")
                && run.err.contains("--hold elbow=-0.5"),
            "{said}"
        );
    });
    both.run(
        &["check", &path, "--robot", &robot, "--hold", "elbow=-0.5"],
        |run, said| {
            assert_eq!(run.exit, 0, "{said}");
        },
    );
}

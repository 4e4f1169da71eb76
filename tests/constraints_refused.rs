//! What is refused of constraints, and what only looks as if: a code, one line with the bad value and
//! the valid ones or the next step; the same of a daemon, in this process and on the command line.
#![cfg(feature = "daemon")]

mod common;

use std::f64::consts::PI;

use common::waiter::{ROBOT, UPRIGHT, asked, planners, request};
use common::{PATIENCE, Place};
use serde_json::{Value, json};
use taut_ipc::planner::Planner;
use taut_ipc::wire::Code;

/// What is asked of [`UPRIGHT`], or of another path, the code, and parts of the line.
struct Case {
    asked: String,
    path: Vec<[f64; 3]>,
    code: Code,
    says: Vec<&'static str>,
}

fn case(asked: impl ToString, code: Code, says: &[&'static str]) -> Case {
    Case {
        asked: asked.to_string(),
        path: UPRIGHT.to_vec(),
        code,
        says: says.to_vec(),
    }
}

fn bad(asked: impl ToString, says: &[&'static str]) -> Case {
    case(asked, Code::InvalidConstraint, says)
}

fn good(asked: impl ToString) -> Case {
    case(asked, Code::Success, &[])
}

fn on<const N: usize>(path: [[f64; 3]; N], case: Case) -> Case {
    Case {
        path: path.to_vec(),
        ..case
    }
}

fn tilt(fields: &Value) -> Value {
    let mut tilt = json!({ "link_name": "hand", "axis": [0, 0, 1], "reference": [0, 0, 1], "tolerance_rad": 0.1 });
    merge(&mut tilt, fields);
    json!({ "orientation_constraints": [tilt] })
}

fn euler(fields: &Value) -> Value {
    let mut euler = json!({ "link_name": "hand", "orientation": { "x": 0, "y": 0, "z": 0, "w": 1 },
        "absolute_x_axis_tolerance": 0.1, "absolute_y_axis_tolerance": 0.1, "absolute_z_axis_tolerance": 3.2 });
    merge(&mut euler, fields);
    json!({ "orientation_constraints": [euler] })
}

/// The cup, half a metre above the hand, is in these regions.
fn cup(primitives: &Value, poses: &Value) -> Value {
    json!({ "name": "cup", "position_constraints": [{ "link_name": "hand", "target_point_offset": [0, 0, 0.5],
        "constraint_region": { "primitives": primitives, "primitive_poses": poses } }] })
}

fn joint(fields: &Value) -> Value {
    let mut joint = json!({ "joint_name": "nod", "position": 0, "tolerance_above": 0.6, "tolerance_below": 0.6 });
    merge(&mut joint, fields);
    json!({ "joint_constraints": [joint] })
}

fn merge(value: &mut Value, fields: &Value) {
    for (key, field) in fields.as_object().unwrap() {
        match field {
            Value::Null => drop(value.as_object_mut().unwrap().remove(key)),
            field => value[key] = field.clone(),
        }
    }
}

/// Asks everybody, who must say the same.
fn judge(cases: Vec<Case>) {
    let place = Place::new();
    let _daemon = place.serve("");
    let planners = planners(&place);
    for case in cases {
        for planner in &planners {
            case.judge_by(planner);
        }
        case.judge_on_the_command_line(&place);
    }
}

impl Case {
    fn judge_by(&self, planner: &Planner) {
        match asked(planner, &self.asked, &self.path) {
            Ok(best) => assert!(
                self.code == Code::Success && best.view().unwrap().is_proved(),
                "proved: {}",
                self.asked
            ),
            Err(error) => {
                assert_eq!(error.code(), self.code, "{}: {error}", self.asked);
                self.read(&error.to_string());
            }
        }
    }

    /// As the file's own words, so that no shell and no flag comes between.
    fn judge_on_the_command_line(&self, place: &Place) {
        let urdf = place.file("waiter.urdf", ROBOT);
        let words: Value =
            serde_json::from_str(&self.asked).unwrap_or_else(|_| Value::String(self.asked.clone()));
        let text = json!({ "variables": ["lean", "turn", "nod"], "path": self.path, "path_constraints": words });
        let file = place.file("path.json", &text.to_string());
        let run = place.taut(&["check", &file, "--robot", &urdf, "--local"]);
        let verdict = match self.code {
            Code::Success => 0,
            Code::InvalidConstraint => 65,
            Code::Uncertified => 2,
            _ => 1,
        };
        assert_eq!(run.exit, verdict, "{}: {}{}", self.asked, run.out, run.err);
        match verdict {
            0 => {}
            65 => self.read(run.err.trim()),
            _ => self.read(run.out.trim()),
        }
    }

    fn read(&self, line: &str) {
        assert!(!line.contains('\n'), "{line}");
        for part in &self.says {
            assert!(
                line.contains(part),
                "{part:?} not in: {line}\n{}",
                self.asked
            );
        }
    }
}

#[test]
fn paths_that_are_outside() {
    let start = Code::StartStateViolatesPathConstraints;
    let leaning = [0.3, 0.0, 0.0];
    let apart = json!([{ "position": [0, 0, 0.5] }, { "position": [0, 0, -0.5] }]);
    let both = json!([{ "position": [0, 0, 0.5] }, { "position": [0.3, 0, 0.3] }]);
    let balls = |radius: f64| json!([{ "type": "sphere", "dimensions": [radius] }, { "type": "sphere", "dimensions": [radius] }]);
    let over = [[0.0, 0.0, 0.0], [0.0, 0.0, PI / 4.0]];
    let round = [[0.0, 0.0, 0.0], [0.0, 0.0, 2.9]];
    judge(vec![
        // The start outside, the goal outside.
        on(
            [leaning, UPRIGHT[1]],
            case(
                "upright hand:z=0.1",
                start,
                &["upright: hand", "0.30000 rad, allowed 0.1"],
            ),
        ),
        on(
            [UPRIGHT[1], leaning],
            case(
                "upright hand:z=0.1",
                Code::GoalViolatesPathConstraints,
                &["upright: hand", "0.30000 rad, allowed 0.1"],
            ),
        ),
        // Contradictory ones: no start keeps both.
        case(
            json!([cup(&json!([{ "type": "sphere", "dimensions": [0.1] }]), &json!([{ "position": [0, 0, 0.5] }])),
                { "name": "far", "position_constraints": [{ "link_name": "hand", "target_point_offset": [0, 0, 0.5],
                    "constraint_region": { "primitives": [{ "type": "sphere", "dimensions": [0.1] }],
                        "primitive_poses": [{ "position": [0, 0, 5] }] } }] }]),
            start,
            &["hand", "4.5", "allowed 0.1"],
        ),
        case(
            json!(["upright hand:z=0.1", "upright hand:-z=0.1"]),
            start,
            &["upright: hand", "3.14"],
        ),
        // A union: where its parts overlap one may go from one to the other, over a gap not.
        on(over, good(cup(&balls(0.3), &both))),
        on(
            round,
            case(
                cup(&balls(0.3), &apart),
                Code::InvalidMotionPlan,
                &["cup: hand", "outside by"],
            ),
        ),
        // What does not move is always within or never.
        good("upright base:z=0.1"),
        case(
            "upright base:x=0.1",
            start,
            &["upright: base", "1.57080 rad"],
        ),
    ]);
}

#[test]
fn tolerances_that_cannot_be_proved() {
    judge(vec![
        bad("upright hand:z=0", &["tolerance_rad is 0", "such as 0.001"]),
        bad(
            "upright hand:z=1e-13",
            &["tolerance_rad is 0.0000000000001", "such as 0.001"],
        ),
        good(tilt(&json!({ "tolerance_rad": 1e-6 }))),
        // Both leans would cancel, but the bound of how fast directions turn does not know it.
        case(
            tilt(&json!({ "tolerance_rad": 1e-9 })),
            Code::Uncertified,
            &["hand", "left", "allowed 0.000000001"],
        ),
        good("upright hand:z=90deg"),
        bad(
            "upright hand:z=1.6",
            &["tolerance_rad is 1.6", "π/2", "not convex"],
        ),
        bad(
            tilt(&json!({ "tolerance_rad": -0.1 })),
            &["tolerance_rad is -0.1"],
        ),
        bad(
            euler(&json!({ "absolute_x_axis_tolerance": 0 })),
            &["absolute_x_axis_tolerance is 0", "0.001"],
        ),
        // Where Euler angles are singular: about y a tolerance of π/2 and more asks for nothing.
        good(euler(&json!({ "absolute_y_axis_tolerance": 1.6 }))),
        good(euler(
            &json!({ "absolute_y_axis_tolerance": 3.2, "absolute_x_axis_tolerance": 4, "absolute_z_axis_tolerance": 7 }),
        )),
        bad(
            euler(&json!({ "absolute_x_axis_tolerance": 1.6 })),
            &["absolute_x_axis_tolerance is 1.6", "below π/2", "from π on"],
        ),
        bad(
            euler(&json!({ "absolute_z_axis_tolerance": 3.13 })),
            &["absolute_z_axis_tolerance is 3.13", "from π on"],
        ),
        bad(
            joint(&json!({ "tolerance_above": 0, "tolerance_below": 0 })),
            &["is 0", "0.001"],
        ),
        bad(
            joint(&json!({ "tolerance_below": -1 })),
            &["tolerance_below is -1", "negative"],
        ),
        bad(
            "keep hand in ball 0 at 0,0,0",
            &["radius is 0", "greater than 0"],
        ),
        bad(
            "keep hand in box 1,1,1e-12 at 0,0,0",
            &["half width is 0.0000000000005", "0.001"],
        ),
    ]);
}

#[test]
fn what_moveit_has_and_is_not_kept() {
    let sphere = json!([{ "type": "sphere", "dimensions": [1] }]);
    let mut mesh = cup(&json!([]), &json!([]));
    mesh["position_constraints"][0]["constraint_region"]["meshes"] =
        json!([{ "vertices": [[0, 0, 0]], "triangles": [] }]);
    judge(vec![
        bad(
            mesh,
            &[
                "cup: hand",
                "a mesh as a region",
                "boxes, spheres or cylinders",
            ],
        ),
        bad(
            cup(
                &json!([{ "type": "cone", "dimensions": [1, 1] }]),
                &json!([{}]),
            ),
            &["cone", "a region is a box"],
        ),
        bad(
            cup(&json!([{ "type": 9, "dimensions": [1] }]), &json!([{}])),
            &["9"],
        ),
        bad(
            cup(&json!([{ "type": "box", "dimensions": [1] }]), &json!([{}])),
            &["box [x, y, z]"],
        ),
        bad(
            cup(&sphere, &json!([])),
            &["primitive_poses is 0", "a pose for each"],
        ),
        bad(
            cup(&json!([]), &json!([])),
            &["primitive_poses is 0", "one primitive at least"],
        ),
        bad(
            json!({ "visibility_constraints": [{ "cone_sides": 4 }] }),
            &["visibility_constraints", "leave them out"],
        ),
        bad(
            euler(&json!({ "parameterization": 1 })),
            &["parameterization 1", "XYZ_EULER_ANGLES (0)"],
        ),
        bad(
            euler(&json!({ "parameterization": "ROTATION_VECTOR" })),
            &["ROTATION_VECTOR", "XYZ_EULER_ANGLES (0)"],
        ),
        bad(
            euler(&json!({ "parameterization": -1 })),
            &["parameterization", "XYZ_EULER_ANGLES"],
        ),
        good(euler(
            &json!({ "parameterization": "XYZ_EULER_ANGLES", "weight": 0.5 }),
        )),
        good(
            json!({ "name": "", "joint_constraints": [], "position_constraints": [], "orientation_constraints": [],
            "visibility_constraints": [] }),
        ),
        good("[]"),
        good("{}"),
    ]);
}

#[test]
fn names_and_fields_that_are_none() {
    judge(vec![
        bad(
            "upright panda_hand:z=0.1",
            &[
                "\"panda_hand\"",
                "links: base, shoulder, elbow, hand",
                "attached: none",
            ],
        ),
        bad(
            tilt(&json!({ "header": { "frame_id": "table" } })),
            &["\"table\"", "no frame of the scene", "links: base"],
        ),
        bad(
            tilt(&json!({ "link_name": "" })),
            &["\"\" is no link", "links: base, shoulder, elbow, hand"],
        ),
        bad(
            tilt(&json!({ "link_name": null })),
            &["missing field `link_name`"],
        ),
        bad(
            joint(&json!({ "joint_name": "panda_joint1" })),
            &["\"panda_joint1\"", "valid: lean, turn, nod"],
        ),
        bad(
            json!({ "orientation_constraint": [] }),
            &[
                "orientation_constraint",
                "expected one of",
                "orientation_constraints",
            ],
        ),
        bad(
            euler(&json!({ "absolute_x_axis": 1 })),
            &["absolute_x_axis", "absolute_x_axis_tolerance"],
        ),
        bad(
            tilt(&json!({ "header": { "frame": "base" } })),
            &["`frame`", "frame_id"],
        ),
        bad(
            tilt(&json!({ "within": 1 })),
            &["`within`", "tolerance_rad"],
        ),
        bad(tilt(&json!({ "reference": "end" })), &["\"start\""]),
        bad(
            joint(&json!({ "tolerance": 1 })),
            &["`tolerance`", "tolerance_above"],
        ),
        bad(
            json!({ "name": "two\nlines", "joint_constraints": [] }),
            &["two\\nlines", "one line"],
        ),
        bad(
            "upright hand:up=0.1",
            &["hand:up=0.1", "valid: ", "-x, -y, -z"],
        ),
        bad(json!(["upright hand:z=0.1", 3]), &["3", "few words"]),
    ]);
}

#[test]
fn numbers_that_no_path_has() {
    let far = |at: Value| {
        cup(
            &json!([{ "type": "box", "dimensions": [1, 1, 1] }]),
            &json!([{ "position": at }]),
        )
    };
    let mut offset = far(json!([0, 0, 0]));
    offset["position_constraints"][0]["target_point_offset"] = json!([1.7e308, 1.7e308, 1.7e308]);
    judge(vec![
        bad(offset, &["target_point_offset", "1e6 at most"]),
        bad(far(json!([0, 0, 2e6])), &["2000000", "1e6 at most"]),
        bad(far(json!([1.7e308, 1.7e308, -1.7e308])), &["1e6 at most"]),
        bad(
            joint(&json!({ "position": 1e300 })),
            &["position is 1", "1e6 at most"],
        ),
        bad(
            tilt(&json!({ "axis": [0, 0, 0] })),
            &["axis is [0.0, 0.0, 0.0]", "must not be zero"],
        ),
        // A direction may be of any length, a quaternion nearly of length 1; of zeros it is none, as in MoveIt.
        good(tilt(
            &json!({ "axis": [0, 0, 1e-300], "reference": [0, 0, 1e300] }),
        )),
        good(euler(&json!({ "orientation": [0, 0, 0, 1.0005] }))),
        good(euler(&json!({ "orientation": [0, 0, 0, 0] }))),
        bad(
            euler(&json!({ "orientation": [0, 0, 0, 2] })),
            &["orientation is x 0, y 0, z 0, w 2", "unit quaternion"],
        ),
        // A side may be as long as numbers go: it asks for nothing.
        good("keep hand in box 1e300,1,1 at 0,0,0"),
    ]);
}

/// A frame may be a link that moves: what it sees must hold, not what the world does.
#[test]
fn a_frame_may_move() {
    let by_elbow = tilt(&json!({ "header": { "frame_id": "elbow" } }));
    let swaying = [[0.0, 0.0, 0.0], [0.9, 1.0, 0.05], [-0.9, 2.0, 0.0]];
    judge(vec![
        on(swaying, good(by_elbow.clone())),
        on(
            [[0.0, 0.0, 0.0], [0.0, 1.0, 0.4], [0.0, 2.0, 0.0]],
            case(by_elbow, Code::InvalidMotionPlan, &["hand", "allowed 0.1"]),
        ),
    ]);
}

/// Lists and few words are read wherever a message is: none of them is taken for its first field.
#[test]
fn lists_in_files_are_kept() {
    let straight = [UPRIGHT[0], UPRIGHT[3]];
    let tilted = |asked: Value| {
        on(
            straight,
            case(asked, Code::InvalidMotionPlan, &["hand", "allowed 0.1"]),
        )
    };
    judge(vec![
        on(straight, good("{}")),
        tilted(json!(["upright hand:z=0.1"])),
        tilted(json!([["upright hand:z=0.1"]])),
        tilted(json!(["keep hand in ball 1 at 0,0,0", { "name": "a" }, "upright hand:z=0.1"])),
        on(
            straight,
            case(
                "upright hand:z=0.1",
                Code::InvalidMotionPlan,
                &["upright: hand"],
            ),
        ),
    ]);
}

/// A waypoint that stays as it is must keep what is asked.
#[test]
fn fixed_waypoints_outside() {
    let place = Place::new();
    let _daemon = place.serve("");
    let path = [[0.0, 0.0, 0.0], [0.15, 0.5, 0.0], [0.0, 1.0, 0.0]];
    for planner in planners(&place) {
        let mut request = request("upright hand:z=0.1");
        request.fixed_waypoints = vec![1];
        let answers = planner
            .ask(&request, path.as_flattened())
            .unwrap();
        let error = answers.result(PATIENCE).unwrap_err();
        assert_eq!(error.code(), Code::InvalidMotionPlan, "{error}");
        let place = error.place().unwrap();
        assert_eq!((place.segment, place.t), (0, 1.0), "{error}");
        assert!((place.amount - (0.1 - 0.15)).abs() < 1e-9, "{error}");
    }
}

/// A bound that the start is exactly on is kept, also by who is strict, and raises nothing.
#[test]
fn a_joint_may_start_at_its_bound() {
    let place = Place::new();
    let urdf = place.file("waiter.urdf", ROBOT);
    let at = joint(&json!({ "position": -0.5, "tolerance_below": 0, "tolerance_above": 1.1 }));
    let text =
        json!({ "variables": ["lean", "turn", "nod"], "path": UPRIGHT, "path_constraints": at });
    let file = place.file("path.json", &text.to_string());
    for flags in [&[][..], &["--strict"]] {
        let given = [
            "shorten", &file, "--robot", &urdf, "--local", "--budget", "5000", "--format", "json",
        ];
        let run = place.taut(&[&given, flags].concat());
        assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
        let answer = run.json();
        assert_eq!(answer["floors_lowered"], json!([]));
        let rows = answer["path"].as_array().unwrap();
        assert!(
            rows.iter()
                .all(|row| row[2].as_f64().unwrap() >= -0.5)
        );
    }
}

//! A robot that carries a cup, and how it is asked to.

use std::f64::consts::PI;

use serde_json::{Value, json};
use taut::local::LocalService;
use taut_ipc::control::RobotSource;
use taut_ipc::planner::{Best, Planner, PlannerError, Request};

use super::{PATIENCE, Place, Run};

/// A hand that carries a cup on three joints: about y, z and y.
pub const ROBOT: &str = r#"<robot name="waiter">
<link name="base"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<link name="shoulder"/><link name="elbow"/>
<link name="hand"><collision><origin xyz="0.5 0 0.5"/><geometry><sphere radius="0.05"/></geometry></collision></link>
<joint name="lean" type="revolute"><parent link="base"/><child link="shoulder"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="turn" type="revolute"><parent link="shoulder"/><child link="elbow"/><axis xyz="0 0 1"/>
<limit lower="-4" upper="4" effort="1" velocity="1"/></joint>
<joint name="nod" type="revolute"><parent link="elbow"/><child link="hand"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
</robot>"#;

/// The cup is upright on all of it: both leans cancel each other.
pub const UPRIGHT: [[f64; 3]; 4] = [
    [0.5, 0.0, -0.5],
    [0.0, 0.0, 0.0],
    [0.0, PI, 0.0],
    [0.5, PI, 0.5],
];

pub const WORDS: &str = "upright hand:z=0.1";

/// The angle of the hand's z axis against the vertical.
pub fn tilt([lean, turn, nod]: [f64; 3]) -> f64 {
    (lean.cos() * nod.cos() - lean.sin() * nod.sin() * turn.cos())
        .clamp(-1.0, 1.0)
        .acos()
}

/// The largest tilt on straight segments between rows, by samples.
pub fn most_tilted(rows: &[f64]) -> f64 {
    let rows: Vec<&[f64]> = rows.chunks_exact(3).collect();
    let mut most: f64 = 0.0;
    for pair in rows.windows(2) {
        for step in 0..=2000 {
            let t = f64::from(step) / 2000.0;
            let at = std::array::from_fn(|q| pair[0][q] + t * (pair[1][q] - pair[0][q]));
            most = most.max(tilt(at));
        }
    }
    most
}

pub fn load(place: &Place, planner: &Planner) {
    let source = RobotSource {
        urdf: place.file("waiter.urdf", ROBOT).into(),
        ..RobotSource::default()
    };
    planner
        .load_robot("waiter", &source, true)
        .unwrap();
}

pub fn request(constraints: &str) -> Request {
    Request {
        work_budget: 50_000,
        constraints: constraints.to_owned(),
        ..Request::new("waiter", None)
    }
}

pub fn asked(
    planner: &Planner,
    constraints: &str,
    rows: &[[f64; 3]],
) -> Result<Best, PlannerError> {
    let answers = planner.ask(&request(constraints), rows.as_flattened())?;
    answers.result(PATIENCE)
}

/// The daemon and this process, with the robot.
pub fn planners(place: &Place) -> [Planner; 2] {
    let planners = [
        Planner::connect(&place.instance).unwrap(),
        Planner::in_process(LocalService::default()),
    ];
    for planner in &planners {
        load(place, planner);
    }
    planners
}

pub fn path_file(rows: &[[f64; 3]], constraints: &Value) -> String {
    json!({ "variables": ["lean", "turn", "nod"], "path": rows, "path_constraints": constraints })
        .to_string()
}

/// Runs a command about the robot's path in a file.
pub fn asks(place: &Place, command: &str, file: &str, more: &[&str]) -> Run {
    let urdf = place.file("waiter.urdf", ROBOT);
    let given = [command, file, "--robot", &urdf];
    place.taut(&[&given, more].concat())
}

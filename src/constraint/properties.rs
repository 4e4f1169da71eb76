//! MoveIt's orientation constraint, written down from its sources, beside what is built of its message.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use fastrand::Rng;
use serde_json::json;

use super::*;
use crate::math::{Quat, quat_exp};
use crate::robot::{
    JointKind, Kinematics, LinkDescription, RobotDescription, RobotModel, VirtualJoint,
};
use crate::scene::Scene;
use crate::testing;
use crate::validation::soundness::cases;

/// `calcEulerAngles` of moveit_core's kinematic_constraint.cpp (2.12): intrinsic XYZ, where the second is
/// no right angle.
fn euler_angles(turned: Quat) -> [f64; 3] {
    let columns = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| (turned * axis).to_array());
    let r = |row: usize, column: usize| columns[column][row];
    let squares = r(0, 0).powi(2) + r(0, 1).powi(2) + r(1, 2).powi(2) + r(2, 2).powi(2);
    let sum = (squares / 2.0).sqrt();
    [
        (-r(1, 2)).atan2(r(2, 2)),
        r(0, 2).atan2(sum),
        (-r(0, 1)).atan2(r(0, 0)),
    ]
}

/// `normalizeAbsoluteAngle` there.
fn absolute(angle: f64) -> f64 {
    let angle = (angle.abs()) % TAU;
    angle.min(TAU - angle)
}

/// How much each angle leaves, as `OrientationConstraint::decide` compares them.
fn left_by_moveit(reference: Quat, link: Quat, tolerances: [f64; 3]) -> [f64; 3] {
    let angles = euler_angles(reference.inverse() * link).map(absolute);
    std::array::from_fn(|axis| tolerances[axis] - angles[axis])
}

/// A body that floats.
fn body() -> RobotModel {
    RobotModel::new(RobotDescription {
        name: "body".into(),
        links: vec![LinkDescription {
            name: "body".into(),
            collision: Vec::new(),
        }],
        virtual_joint: Some(VirtualJoint {
            name: "root".into(),
            kind: JointKind::Floating,
            position_bounds: Vec::new(),
            parent_frame: String::new(),
        }),
        ..RobotDescription::default()
    })
    .unwrap()
}

fn rotation(rng: &mut Rng) -> Quat {
    loop {
        let [x, y, z, w] = std::array::from_fn(|_| testing::uniform(rng, -1.0, 1.0));
        let quaternion = Quat::from_xyzw(x, y, z, w);
        if (0.1..1.0).contains(&quaternion.length()) {
            return quaternion.normalize();
        }
    }
}

/// Tolerances that can be proved: below π/2, or none.
fn tolerances(rng: &mut Rng) -> [f64; 3] {
    let free = [PI, FRAC_PI_2, PI];
    std::array::from_fn(|axis| match rng.usize(0..4) {
        0 => free[axis] + rng.f64(),
        1 => 10f64.powf(testing::uniform(rng, -9.0, -1.0)),
        _ => testing::uniform(rng, 0.01, 1.55),
    })
}

fn built(robot: &RobotModel, reference: Quat, tolerances: [f64; 3]) -> Vec<Constraint> {
    let message = json!({ "orientation_constraints": [{ "link_name": "body", "header": { "frame_id": "world" },
        "orientation": { "x": reference.x, "y": reference.y, "z": reference.z, "w": reference.w },
        "absolute_x_axis_tolerance": tolerances[0], "absolute_y_axis_tolerance": tolerances[1],
        "absolute_z_axis_tolerance": tolerances[2] }] });
    let file: ConstraintsFile = serde_json::from_value(message).unwrap();
    let scene = Scene::new("none", Vec::new(), Vec::new(), Vec::new()).unwrap();
    constraints(&file, robot, &scene).unwrap()
}

/// The depth of the shallowest constraint, at a configuration.
fn depth(robot: &RobotModel, all: &[Constraint], configuration: &[f64]) -> f64 {
    let mut kinematics = Kinematics::default();
    kinematics.update(robot, configuration, &[]);
    let stand = Stand {
        kinematics: &kinematics,
        configuration,
        velocity: &[0.0; 6],
    };
    let depths = all.iter().map(|constraint| {
        constraint
            .held
            .depth(constraint.held.watched.at(&stand))
    });
    depths.fold(f64::INFINITY, f64::min)
}

/// A link is within the half-spaces exactly where MoveIt says that its constraint is satisfied.
#[test]
fn half_spaces_are_moveits_constraint() {
    let (count, mut rng) = cases(10_000);
    let robot = body();
    let [mut inside, mut outside] = [0; 2];
    for _ in 0..count {
        let reference = rotation(&mut rng);
        let tolerances = tolerances(&mut rng);
        // About as far from the reference as is allowed, or anyhow.
        let size = tolerances
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        let link = match rng.usize(0..4) {
            0 => rotation(&mut rng),
            _ => reference * quat_exp(testing::vector(&mut rng, 1.5 * size)),
        };
        let left = left_by_moveit(reference, link, tolerances);
        let least = left.into_iter().fold(f64::INFINITY, f64::min);
        // Where rounding decides neither says anything.
        if least.abs() < 1e-12 {
            continue;
        }
        let all = built(&robot, reference, tolerances);
        let configuration = [0.3, -0.2, 0.1, link.x, link.y, link.z, link.w];
        let depth = depth(&robot, &all, &configuration);
        assert_eq!(
            depth > 0.0,
            least > 0.0,
            "{depth}, MoveIt {left:?} of {tolerances:?} at {link:?} from {reference:?}"
        );
        inside += usize::from(least > 0.0);
        outside += usize::from(least < 0.0);
    }
    println!("{inside} inside, {outside} outside");
    assert!(inside > count / 10 && outside > count / 10);
}

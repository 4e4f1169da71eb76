//! Random pieces of all kinds, among obstacles and under constraints, against samples that share none of
//! the proof's code.

use fastrand::Rng;
use nalgebra::{Point3, Vector3};

use super::tests::{points, sampled};
use super::*;
use crate::collision::CollisionModel;
use crate::constraint::{Constraint, ConstraintsFile, constraints};
use crate::robot::{Component, JointKind, RobotModel};
use crate::testing::{self, Oracle};
use crate::validation::Scratch;
use crate::validation::certificate::Interpolation;
use crate::validation::soundness::cases;

const FLOOR_M: f64 = 1e-3;
/// How far the oracle's distances may be off (m).
const ORACLE_M: f64 = 2e-5;
/// Looks along a piece.
const LOOKS: u32 = 24;

/// A link's origin that stays in a ball about where it is at first.
struct Kept {
    link: usize,
    centre: Point3<f64>,
    radius: f64,
}

impl Kept {
    fn new(rng: &mut Rng, robot: &RobotModel, first: &[f64]) -> Self {
        let link = rng.usize(0..robot.links().len());
        let at = testing::link_poses(robot, first)[link]
            .translation
            .vector;
        Self {
            link,
            centre: (at + Vector3::new(0.0, 0.0, 5e-3)).into(),
            radius: testing::uniform(rng, 0.01, 0.6),
        }
    }

    fn constraints(&self, model: &CollisionModel) -> Vec<Constraint> {
        let robot = model.robot();
        let link = &robot.links()[self.link].name;
        let Point3 { coords: at } = self.centre;
        let words = format!(
            "keep {link} in ball {} at {},{},{}",
            self.radius, at.x, at.y, at.z
        );
        let asked = ConstraintsFile::parse(&words).unwrap();
        constraints(&asked, robot, model.scene()).unwrap()
    }

    /// How far out of the ball it is (m).
    fn strays(&self, robot: &RobotModel, q: &[f64]) -> f64 {
        let at = testing::link_poses(robot, q)[self.link]
            .translation
            .vector;
        (at - self.centre.coords).norm() - self.radius
    }
}

/// What a run met.
#[derive(Debug, Default)]
struct Met {
    proved: usize,
    kinds: [usize; 3],
    /// Pieces with a slide that a turning joint carries and that goes farther than both ends.
    swinging: usize,
    constrained: usize,
    /// Looks that find a pair within ten times its clearance, ...
    near: usize,
    /// ... or a link in the outer tenth of its ball.
    outer: usize,
}

/// Whether a slide that a turning joint carries goes beyond both its ends by more than a millimetre.
fn swings_out(robot: &RobotModel, ends: [&Point; 2], samples: &[Vec<f64>]) -> bool {
    let joints = robot.joints();
    joints.iter().any(|joint| {
        let above = std::iter::successors(joint.parent, |link| joints[*link].parent);
        let is_carried = above
            .map(|link| joints[link].kind)
            .any(|kind| matches!(kind, JointKind::Revolute | JointKind::Continuous));
        let slides = joint.kind == JointKind::Prismatic && is_carried;
        let beyond = |q: usize| {
            let [low, high] =
                [f64::min, f64::max].map(|pick| pick(ends[0].positions[q], ends[1].positions[q]));
            samples
                .iter()
                .any(|at| at[q] < low - 1e-3 || at[q] > high + 1e-3)
        };
        slides && column(robot, joint).is_some_and(beyond)
    })
}

/// The column of a joint of one value, or of the one that it follows.
fn column(robot: &RobotModel, joint: &crate::robot::Joint) -> Option<usize> {
    let (coordinate, _) = crate::robot::kinematics::rate(robot.joints(), joint)?;
    robot
        .space()
        .components()
        .iter()
        .find_map(|component| match *component {
            Component::Line { q, v } | Component::Circle { q, v } if v == coordinate => Some(q),
            _ => None,
        })
}

fn kind(ends: [&Point; 2]) -> usize {
    match curve::interpolation(ends[0], ends[1]) {
        Interpolation::Linear => 0,
        Interpolation::Cubic => 1,
        Interpolation::Quintic => 2,
    }
}

/// A piece that is proved keeps its clearance and its constraint wherever it is looked at.
fn look(rng: &mut Rng, met: &mut Met) {
    let model = testing::model(rng);
    let robot = model.robot();
    let all = points(rng, robot);
    let ends = [&all[0], &all[1]];
    let curve = Curve::new(robot, &all[..2]).unwrap();
    let kept = Some(Kept::new(rng, robot, &all[0].positions)).filter(|_| rng.f64() < 0.4);
    let constraints = kept
        .as_ref()
        .map(|kept| kept.constraints(&model));
    let constraints = constraints.unwrap_or_default();
    let held: Vec<f64> = robot
        .held()
        .iter()
        .map(|held| held.default)
        .collect();
    let space = robot.space().unwrapped();
    let mut scratch = Scratch::default();
    let validator = Validator::new(&model, &space, &held, FLOOR_M, &mut scratch);
    let mut validator = validator.with_constraints(&constraints);
    if rng.bool() {
        validator = validator.closely();
    }
    let verdict = prove(&mut validator, &curve, rng.bool(), &mut || false);
    let TimedVerdict::Proved(proof) = verdict else {
        return;
    };
    let samples: Vec<Vec<f64>> = (0..=LOOKS)
        .map(|look| sampled(ends[0], ends[1], f64::from(look) / f64::from(LOOKS)))
        .collect();
    met.proved += 1;
    met.kinds[kind(ends)] += 1;
    met.swinging += usize::from(swings_out(robot, ends, &samples));
    check_clearances(&model, &proof, &samples, met);
    if let Some(kept) = &kept {
        met.constrained += 1;
        let raised = proof
            .lowered
            .iter()
            .find(|(lowered, _)| matches!(lowered, Requirement::Constraint(_)));
        let allowed = raised.map_or(0.0, |(_, floor)| -floor);
        for q in &samples {
            let strays = kept.strays(robot, q);
            assert!(strays <= allowed + 1e-9, "{strays} m out of a ball");
            met.outer += usize::from(strays > -0.1 * kept.radius);
        }
    }
}

fn check_clearances(
    model: &CollisionModel,
    proof: &TimedProof,
    samples: &[Vec<f64>],
    met: &mut Met,
) {
    let oracle = Oracle::new(model);
    for pair in 0..model.pairs().len() {
        let lowered = proof
            .lowered
            .iter()
            .find(|(lowered, _)| *lowered == Requirement::Clearance(pair));
        let floor = lowered.map_or(FLOOR_M, |(_, floor)| *floor);
        let claimed = proof.clearance_m().max(floor);
        for q in samples {
            let distance = oracle.pair_distance(model, pair, q);
            assert!(
                distance >= claimed - ORACLE_M,
                "{distance} m, {claimed} m claimed"
            );
            met.near += usize::from(distance < 10.0 * claimed);
        }
    }
}

#[test]
fn random_pieces_of_a_curve_keep_what_is_proved_of_them() {
    let (count, mut rng) = cases(10_000);
    let mut met = Met::default();
    for _ in 0..count {
        look(&mut rng, &mut met);
    }
    println!("{count} pieces, {met:?}");
    assert!(met.proved * 5 > count, "{met:?}");
    assert!(met.kinds.iter().all(|kind| *kind > count / 50), "{met:?}");
    assert!(met.swinging > count / 200, "{met:?}");
    assert!(met.constrained > count / 20 && met.outer > 0, "{met:?}");
    assert!(met.near > count / 100, "{met:?}");
}

//! What sampled checks miss: a wall thinner than any step, and an obstacle that only the end of a
//! long lever sweeps. Each of a thousand placements must be refused, and proved once moved clear by
//! two clearances.

use std::sync::Arc;

use fastrand::Rng;
use taut::collision::CollisionModel;
use taut::math::{Pose, Quat, Vec3, quat_exp};
use taut::optimize::{Mode, Settings, Workspace, run};
use taut::path::Path;
use taut::robot::{JointDescription, JointKind, LinkDescription, RobotDescription, RobotModel};
use taut::scene::{Obstacle, Scene};
use taut::shape::{Mesh, PlacedShape, Shape};

const PLACEMENTS: usize = 1000;
const CLEARANCE_M: f64 = 1e-3;

fn joint(index: usize, kind: JointKind, axis: Vec3, limits: (f64, f64)) -> JointDescription {
    JointDescription {
        name: format!("joint{index}"),
        kind,
        parent: format!("link{index}"),
        child: format!("link{}", index + 1),
        origin: Pose::identity(),
        axis,
        limits: Some(limits),
        soft_limits: None,
        mimic: None,
    }
}

/// A chain of joints that carries one shape at its end.
fn robot(joints: Vec<JointDescription>, shape: PlacedShape) -> Arc<RobotModel> {
    let last = joints.len();
    let link = |i: usize| LinkDescription {
        name: format!("link{i}"),
        collision: if i == last {
            vec![shape.clone()]
        } else {
            Vec::new()
        },
    };
    let links = (0..=last).map(link).collect();
    Arc::new(
        RobotModel::new(RobotDescription {
            name: "chain".into(),
            links,
            joints,
            ..Default::default()
        })
        .unwrap(),
    )
}

fn proved(robot: &Arc<RobotModel>, obstacle: PlacedShape, from: &[f64], to: &[f64]) -> bool {
    let obstacle = Obstacle::new("obstacle", vec![obstacle]);
    let scene = Scene::new("one", vec![obstacle], Vec::new(), Vec::new()).unwrap();
    let model = CollisionModel::new(robot.clone(), Arc::new(scene)).unwrap();
    let path = Path::from_rows(from.len(), [from, to].concat()).unwrap();
    let settings = Settings {
        mode: Mode::Check,
        strict: true,
        clearance_m: CLEARANCE_M,
        ..Settings::default()
    };
    let outcome = run(
        &model,
        &path,
        &settings,
        &mut Workspace::default(),
        &mut || false,
        &mut |_| {},
    )
    .unwrap();
    assert_eq!(outcome.proved, outcome.refusal.is_none());
    outcome.proved
}

fn uniform(rng: &mut Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.f64()
}

#[test]
fn a_wall_of_a_millimetre_between_two_free_waypoints() {
    let mut rng = Rng::with_seed(1);
    let radius = 0.02;
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let joints = (0..3)
        .map(|i| joint(i, JointKind::Prismatic, axes[i], (-2.0, 2.0)))
        .collect();
    let ball = PlacedShape {
        pose: Pose::identity(),
        shape: Shape::sphere(radius).unwrap(),
    };
    let robot = robot(joints, ball);
    let wall = Shape::cuboid(Vec3::new(1.0, 1.0, 1e-3)).unwrap();
    let mut clear = 0;
    for _ in 0..PLACEMENTS {
        let mut component = || uniform(&mut rng, -1.0, 1.0);
        let from = Vec3::new(component(), component(), component());
        let along = Vec3::new(component(), component(), component()).normalize() * 0.9;
        let to = from + along;
        // A wall tilted by up to half a radian, crossed somewhere in the middle half of the way.
        let tilt = quat_exp(Vec3::new(component(), component(), component()) * 0.3);
        let turn = tilt * Quat::from_rotation_arc(Vec3::Z, along.normalize());
        let place = from + along * uniform(&mut rng, 0.25, 0.75);
        let crossing = PlacedShape {
            pose: Pose::from_parts(place, turn),
            shape: wall.clone(),
        };
        let from = from.to_array();
        let to = to.to_array();
        assert!(
            !proved(&robot, crossing, &from, &to),
            "through a wall at {place}"
        );
        // The same wall beyond the goal, its near face two clearances from the ball there.
        let beyond = Vec3::from_array(to) + turn * Vec3::Z * (radius + 2.0 * CLEARANCE_M + 0.5e-3);
        let moved = PlacedShape {
            pose: Pose::from_parts(beyond, turn),
            shape: wall.clone(),
        };
        clear += usize::from(proved(&robot, moved, &from, &to));
    }
    println!("refused {PLACEMENTS} of {PLACEMENTS}, moved clear: proved {clear}");
    assert!(
        clear * 100 >= PLACEMENTS * 99,
        "only {clear} of {PLACEMENTS} proved once clear"
    );
}

#[test]
fn an_obstacle_that_only_the_end_of_a_lever_of_a_metre_sweeps() {
    let mut rng = Rng::with_seed(2);
    let length = 1.0;
    let thickness = 0.01;
    let shift = Pose::from_parts(
        Vec3::X * (length / 2.0),
        Quat::from_rotation_y(std::f64::consts::FRAC_PI_2),
    );
    let tool = PlacedShape {
        pose: shift,
        shape: Shape::capsule(length, thickness).unwrap(),
    };
    let robot = robot(
        vec![joint(0, JointKind::Revolute, Vec3::Z, (-3.1, 3.1))],
        tool,
    );
    let mut clear = 0;
    for _ in 0..PLACEMENTS {
        let radius = uniform(&mut rng, 0.001, 0.006);
        let ball = Shape::sphere(radius).unwrap();
        let from = uniform(&mut rng, -3.0, 1.0);
        let to = from + uniform(&mut rng, 0.3, 2.0);
        // Somewhere on the outer part of the sweep, clear of both ends.
        let reach = uniform(&mut rng, 0.6, length);
        let angle = uniform(&mut rng, from + 0.1, to - 0.1);
        let place = Vec3::new(angle.cos(), angle.sin(), 0.0) * reach;
        let swept = PlacedShape {
            pose: Pose::from_translation(place),
            shape: ball.clone(),
        };
        assert!(
            !proved(&robot, swept, &[from], &[to]),
            "through a ball of {radius} m at {place}"
        );
        // Lifted out of the plane of the sweep by two clearances.
        let lifted = place + Vec3::Z * (thickness + radius + 2.0 * CLEARANCE_M);
        let moved = PlacedShape {
            pose: Pose::from_translation(lifted),
            shape: ball,
        };
        clear += usize::from(proved(&robot, moved, &[from], &[to]));
    }
    println!("refused {PLACEMENTS} of {PLACEMENTS}, moved clear: proved {clear}");
    assert!(
        clear * 100 >= PLACEMENTS * 99,
        "only {clear} of {PLACEMENTS} proved once clear"
    );
}

/// A closed mesh is a solid: a ball wholly inside touches no triangle, and collides all the same.
#[test]
fn a_ball_that_moves_wholly_inside_a_mesh() {
    let ball = PlacedShape {
        pose: Pose::identity(),
        shape: Shape::sphere(0.02).unwrap(),
    };
    let robot = robot(
        vec![joint(0, JointKind::Prismatic, Vec3::X, (-2.0, 2.0))],
        ball,
    );
    let corner = |i: u32| {
        Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) - Vec3::splat(0.5)
    };
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    for inwards in [false, true] {
        let halves = faces
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        let turned = halves.map(|[a, b, c]| if inwards { [a, c, b] } else { [a, b, c] });
        let mesh = Mesh::new("cube", (0..8).map(corner).collect(), turned.collect()).unwrap();
        let cube = PlacedShape {
            pose: Pose::identity(),
            shape: Shape::Mesh(Arc::new(mesh)),
        };
        assert!(
            !proved(&robot, cube.clone(), &[-0.1], &[0.1]),
            "inside, faces inwards: {inwards}"
        );
        assert!(
            proved(&robot, cube, &[0.6], &[0.9]),
            "outside, faces inwards: {inwards}"
        );
    }
}

/// A path that grazes an obstacle along all of its way: nothing may stall. What is left of the room
/// after a floor of a micrometre is proved or said not to be, within the nodes that a lowered floor
/// may take.
#[test]
fn what_grazes_ends_and_says_so() {
    let slide = joint(0, JointKind::Prismatic, Vec3::X, (-1.0, 1.0));
    let turn = JointDescription {
        origin: Pose::identity(),
        ..joint(1, JointKind::Continuous, Vec3::Z, (0.0, 0.0))
    };
    let turn = JointDescription {
        limits: None,
        ..turn
    };
    let shapes = [
        Shape::sphere(0.05).unwrap(),
        Shape::cylinder(0.1, 0.05).unwrap(),
        Shape::cuboid(Vec3::splat(0.1)).unwrap(),
    ];
    for (index, shape) in shapes.into_iter().enumerate() {
        let pose = if index == 1 {
            Pose::identity()
        } else {
            Pose::from_parts(Vec3::ZERO, quat_exp(Vec3::Z * 0.3))
        };
        let robot = robot(
            vec![slide.clone(), turn.clone()],
            PlacedShape { pose, shape },
        );
        for (gap, proved) in [
            (1e-6, false),
            (1.4e-6, false),
            (2e-6, true),
            (1e-4, true),
            (1.6e-3, true),
        ] {
            let top = Shape::cuboid(Vec3::new(3.0, 3.0, 0.2)).unwrap();
            let table = PlacedShape {
                pose: Pose::from_translation(Vec3::new(0.0, 0.0, -0.15 - gap)),
                shape: top,
            };
            let scene = Scene::new(
                "table",
                vec![Obstacle::new("table", vec![table])],
                Vec::new(),
                Vec::new(),
            )
            .unwrap();
            let model = CollisionModel::new(robot.clone(), Arc::new(scene)).unwrap();
            let path = Path::from_rows(2, vec![-0.5, 0.0, 0.5, 1.0]).unwrap();
            let settings = Settings {
                mode: Mode::Check,
                clearance_m: CLEARANCE_M,
                ..Settings::default()
            };
            let outcome = run(
                &model,
                &path,
                &settings,
                &mut Workspace::default(),
                &mut || false,
                &mut |_| {},
            )
            .unwrap();
            let said = outcome.refusal.as_ref();
            assert_eq!(outcome.proved, proved, "{gap} m: {said:?}");
            assert!(outcome.work < 1_000_000, "{gap} m: {} tests", outcome.work);
            match outcome.certificate {
                Some(certificate) => {
                    let intervals: u32 = certificate
                        .segments
                        .iter()
                        .map(|claim| claim.intervals)
                        .sum();
                    assert!(intervals < 100_000, "{gap} m: {intervals} intervals");
                    assert!(certificate.clearance_m().unwrap() <= gap + 1e-9);
                }
                None => assert!(
                    said.is_some_and(|refusal| refusal.amount < 1.6e-6),
                    "{gap} m: {said:?}"
                ),
            }
        }
    }
}

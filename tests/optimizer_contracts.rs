//! Joints that are no plain angle between two limits, with the optimizers that use true contacts:
//! the way round that the path takes is the way that is proved, and no further motion than that.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use taut::collision::CollisionModel;
use taut::math::{Pose, Quat, Vec3};
use taut::optimize::{Improvement, Mode, Outcome, Settings, Workspace, run};
use taut::path::Path;
use taut::robot::configuration::LONGEST_STEP_RAD;
use taut::robot::{
    JointDescription, JointKind, LinkDescription, RobotDescription, RobotModel, VirtualJoint,
};
use taut::scene::{Obstacle, Scene};
use taut::shape::{PlacedShape, Shape};

const MODES: [Mode; 2] = [Mode::Contact, Mode::Hybrid];
const DEGREE: f64 = PI / 180.0;

fn ball(radius: f64, at: Vec3) -> PlacedShape {
    PlacedShape {
        pose: Pose::from_translation(at),
        shape: Shape::sphere(radius).unwrap(),
    }
}

fn cuboid(size: Vec3, at: Vec3) -> PlacedShape {
    PlacedShape {
        pose: Pose::from_translation(at),
        shape: Shape::cuboid(size).unwrap(),
    }
}

fn model(robot: RobotDescription, obstacles: Vec<PlacedShape>) -> CollisionModel {
    let named = |(i, shape)| Obstacle::new(format!("obstacle{i}"), vec![shape]);
    let obstacles = obstacles
        .into_iter()
        .enumerate()
        .map(named)
        .collect();
    let scene = Scene::new("scene", obstacles, Vec::new(), Vec::new()).unwrap();
    CollisionModel::new(Arc::new(RobotModel::new(robot).unwrap()), Arc::new(scene)).unwrap()
}

/// An arm of a metre that turns in the plane without an end, with a ball at its tip, on a rail
/// along z.
fn windmill(obstacles: Vec<PlacedShape>) -> CollisionModel {
    let joint = |name: &str, kind, parent: &str, child: &str| JointDescription {
        name: name.into(),
        kind,
        parent: parent.into(),
        child: child.into(),
        origin: Pose::identity(),
        axis: Vec3::Z,
        limits: Some((-1.0, 1.0)),
        soft_limits: None,
        mimic: None,
    };
    let link = |name: &str, collision| LinkDescription {
        name: name.into(),
        collision,
    };
    let robot = RobotDescription {
        name: "windmill".into(),
        links: vec![
            link("rail", vec![]),
            link("carriage", vec![]),
            link("arm", vec![ball(0.05, Vec3::X)]),
        ],
        joints: vec![
            joint("lift", JointKind::Prismatic, "rail", "carriage"),
            joint("turn", JointKind::Continuous, "carriage", "arm"),
        ],
        ..RobotDescription::default()
    };
    model(robot, obstacles)
}

/// A robot of one link that a virtual joint carries.
fn free_body(kind: JointKind, shape: PlacedShape, obstacles: Vec<PlacedShape>) -> CollisionModel {
    let robot = RobotDescription {
        name: "body".into(),
        links: vec![LinkDescription {
            name: "body".into(),
            collision: vec![shape],
        }],
        virtual_joint: Some(VirtualJoint {
            name: "root".into(),
            kind,
            position_bounds: Vec::new(),
            parent_frame: String::new(),
        }),
        ..RobotDescription::default()
    };
    model(robot, obstacles)
}

fn path(nq: usize, rows: &[&[f64]]) -> Path {
    Path::from_rows(nq, rows.concat()).unwrap()
}

/// Shortens, and checks what is true of every answer.
fn shorten(model: &CollisionModel, path: &Path, settings: &Settings) -> Outcome {
    let mut shortest = f64::INFINITY;
    let mut publish = |improvement: taut::optimize::Improvement| {
        assert!(improvement.length < shortest);
        shortest = improvement.length;
    };
    let outcome = run(
        model,
        path,
        settings,
        &mut Workspace::default(),
        &mut || false,
        &mut publish,
    )
    .unwrap();
    assert!(
        outcome.proved && outcome.length_after <= outcome.length_before,
        "{:?}",
        outcome.refusal
    );
    assert_eq!(outcome.path.waypoint(0), path.waypoint(0));
    let mut goal = path.waypoint(path.len() - 1).to_vec();
    for turned in &outcome.turned {
        let column = model
            .robot()
            .variables()
            .iter()
            .position(|variable| variable.name == turned.variable);
        goal[column.unwrap()] += turned.turns as f64 * TAU;
    }
    assert_eq!(outcome.path.waypoint(outcome.path.len() - 1), goal);
    // By its numbers, whoever takes them as angles or not.
    let check = Settings {
        mode: Mode::Check,
        strict: true,
        unwrapped: true,
        ..settings.clone()
    };
    let check = Settings {
        fixed_waypoints: None,
        ..check
    };
    let again = run(
        model,
        &outcome.path,
        &check,
        &mut Workspace::default(),
        &mut || false,
        &mut |_| {},
    )
    .unwrap();
    assert!(again.proved, "{:?}", again.refusal);
    outcome
}

fn ones(model: &CollisionModel, mode: Mode) -> Settings {
    Settings {
        mode,
        weights: Some(vec![1.0; model.robot().space().nv()]),
        ..Settings::default()
    }
}

#[test]
fn from_179_degrees_to_minus_179_it_is_two_degrees() {
    let model = windmill(Vec::new());
    let start = 179.0 * DEGREE;
    let goal = -179.0 * DEGREE;
    let wandering = path(
        2,
        &[
            &[0.0, start],
            &[0.3, 120.0 * DEGREE],
            &[-0.2, 170.0 * DEGREE],
            &[0.0, goal],
        ],
    );
    for mode in MODES {
        let outcome = shorten(&model, &wandering, &ones(&model, mode));
        assert!(
            (outcome.length_after - 2.0 * DEGREE).abs() < 1e-6,
            "{mode:?}: {}",
            outcome.length_after
        );
        assert!((outcome.lower_bound - 2.0 * DEGREE).abs() < 1e-9);
    }
}

/// The way round that the planner took is the only free one: the short one is barred.
#[test]
fn the_long_way_round_stays_where_the_short_one_is_barred() {
    let model = windmill(vec![cuboid(
        Vec3::new(0.3, 0.02, 3.0),
        Vec3::new(-1.0, 0.0, 0.0),
    )]);
    let start = 170.0 * DEGREE;
    let goal = -170.0 * DEGREE;
    let steps: Vec<f64> = (0..=17)
        .map(|i| start - 20.0 * DEGREE * f64::from(i))
        .collect();
    let rows: Vec<[f64; 2]> = steps
        .iter()
        .enumerate()
        .map(|(i, &turn)| [0.2 * (i % 2) as f64, turn])
        .collect();
    let mut rows: Vec<&[f64]> = rows.iter().map(|row| row.as_slice()).collect();
    let last = [0.0, goal];
    *rows.last_mut().unwrap() = &last;
    for mode in MODES {
        let outcome = shorten(&model, &path(2, &rows), &ones(&model, mode));
        let least = 340.0 * DEGREE;
        assert!(
            outcome.length_after >= least - 1e-9,
            "{mode:?}: {} is another way round",
            outcome.length_after
        );
        assert!(
            outcome.length_after < 1.01 * least,
            "{mode:?}: {} of {least}",
            outcome.length_after
        );
    }
}

/// A path that is given unwrapped winds three times, and so does its answer.
#[test]
fn three_turns_given_unwrapped_stay_three_turns() {
    let model = windmill(Vec::new());
    let rows: Vec<[f64; 2]> = (0..=12)
        .map(|i| [0.1 * f64::from(i % 3), TAU / 4.0 * f64::from(i)])
        .collect();
    let rows: Vec<&[f64]> = rows.iter().map(|row| row.as_slice()).collect();
    let given = path(2, &rows);
    for mode in MODES {
        let unwrapped = Settings {
            unwrapped: true,
            ..ones(&model, mode)
        };
        let outcome = shorten(&model, &given, &unwrapped);
        assert!(
            (outcome.length_after - 3.0 * TAU).abs() < 1e-6,
            "{mode:?}: {}",
            outcome.length_after
        );
    }
    // On the circle the same ends are one place; a pull alone does not unwind it, a shortcut does.
    let wrapped = shorten(&model, &given, &ones(&model, Mode::Hybrid));
    assert!(wrapped.length_after < 1e-6, "{}", wrapped.length_after);
}

/// What winds is unwound, and the goal's number with it; `keep_goal` keeps both, with no step that
/// could mean another way.
#[test]
fn a_path_that_winds_ends_turns_away_unless_the_goal_keeps_its_numbers() {
    let model = windmill(Vec::new());
    let rows: Vec<[f64; 2]> = (0..=6)
        .map(|i| [0.1 * f64::from(i % 2), f64::from(i)])
        .collect();
    let rows: Vec<&[f64]> = rows.iter().map(|row| row.as_slice()).collect();
    let given = path(2, &rows);
    for mode in MODES {
        let mut fixed = vec![false; 7];
        fixed[5] = true;
        for settings in [
            ones(&model, mode),
            Settings {
                fixed_waypoints: Some(fixed),
                ..ones(&model, mode)
            },
            Settings {
                keep_goal: true,
                ..ones(&model, mode)
            },
        ] {
            let mut told = Vec::new();
            let mut publish = |improvement: Improvement| told.push(improvement.path.clone());
            let workspace = &mut Workspace::default();
            let outcome = run(
                &model,
                &given,
                &settings,
                workspace,
                &mut || false,
                &mut publish,
            )
            .unwrap();
            let goal = outcome.path.waypoint(outcome.path.len() - 1);
            let turns = ((goal[1] - 6.0) / TAU).round();
            assert_eq!(goal, [0.0, 6.0 + turns * TAU], "{mode:?}");
            assert_eq!(
                outcome
                    .turned
                    .iter()
                    .map(|column| column.turns as f64)
                    .sum::<f64>(),
                turns,
                "{mode:?}"
            );
            assert!(!settings.keep_goal || turns == 0.0, "{mode:?}");
            assert!(
                mode != Mode::Hybrid || settings.keep_goal || turns == -1.0,
                "a shortcut unwinds it"
            );
            if settings.fixed_waypoints.is_some() {
                let kept = outcome
                    .path
                    .waypoints()
                    .filter(|row| ((row[1] - 5.0) / TAU).fract() == 0.0 && row[0] == 0.1);
                assert_eq!(kept.count(), 1, "{mode:?}: {:?}", outcome.path);
            }
            for path in told.iter().chain([&outcome.path]) {
                assert!(
                    path.segments()
                        .all(|[from, to]| (to[1] - from[1]).abs() <= LONGEST_STEP_RAD),
                    "{mode:?}"
                );
            }
        }
    }
}

/// A rotation by half a turn names no way.
#[test]
fn half_a_turn_of_a_quaternion_is_refused_with_its_place() {
    let model = free_body(
        JointKind::Floating,
        cuboid(Vec3::new(0.8, 0.05, 0.05), Vec3::ZERO),
        Vec::new(),
    );
    let row = |q: [f64; 4]| [&[0.0, 0.0, 0.0][..], &q].concat();
    let sixty = [0.0, 0.0, 0.5, 0.75_f64.sqrt()];
    let on = [0.0, 0.0, 0.75_f64.sqrt(), -0.5];
    let turned = path(7, &[&row([0.0, 0.0, 0.0, 1.0]), &row(sixty), &row(on)]);
    let error = run(
        &model,
        &turned,
        &ones(&model, Mode::Hybrid),
        &mut Workspace::default(),
        &mut || false,
        &mut |_| {},
    );
    let text = error.expect_err("half a turn").to_string();
    assert!(
        text.contains("waypoint 2") && text.contains("half a turn"),
        "{text}"
    );
}

/// A bar that has to turn on end to pass below a beam, and comes back level.
#[test]
fn a_floating_body_goes_round_what_is_in_its_way() {
    let bar = cuboid(Vec3::new(0.8, 0.05, 0.05), Vec3::ZERO);
    let beam = cuboid(Vec3::new(0.1, 4.0, 0.6), Vec3::ZERO);
    let model = free_body(JointKind::Floating, bar, vec![beam]);
    let level = [0.0, 0.0, 0.0, 1.0];
    let turned = Quat::from_rotation_z(1.2).to_array();
    let row = |x: f64, y: f64, z: f64, q: [f64; 4]| [&[x, y, z][..], &q].concat();
    let rows = [
        row(-1.0, 0.0, 0.2, level),
        row(-0.7, 0.3, -0.5, turned),
        row(0.2, -0.3, -0.6, level),
        row(0.8, 0.2, -0.4, turned),
        row(1.0, 0.0, 0.2, level),
    ];
    let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
    let given = path(7, &rows);
    for mode in MODES {
        let settings = ones(&model, mode);
        let outcome = shorten(&model, &given, &settings);
        assert!(
            outcome.length_after < 0.6 * outcome.length_before,
            "{mode:?}: {}",
            outcome.length_after
        );
        assert!(
            outcome.length_after > outcome.lower_bound + 0.05,
            "{mode:?}: through the beam?"
        );
        let nearest = outcome.nearest.unwrap();
        assert!(
            !nearest.holds.is_empty(),
            "{mode:?}: nothing holds it, {:?}",
            nearest.smallest
        );
        assert!(
            nearest
                .holds
                .iter()
                .all(|hold| hold.requirement.names == ["body", "obstacle0"])
        );
        for waypoint in outcome.path.waypoints() {
            let norm = waypoint[3..]
                .iter()
                .map(|x| x * x)
                .sum::<f64>()
                .sqrt();
            assert!((norm - 1.0).abs() < 1e-12, "a quaternion of norm {norm}");
        }
    }
}

/// A planar base that must keep its detour, because only its angle may change, and a waypoint of it
/// that is fixed.
#[test]
fn a_planar_base_keeps_what_may_not_move_and_what_is_fixed() {
    let cart = cuboid(Vec3::new(0.6, 0.3, 0.2), Vec3::ZERO);
    let post = cuboid(Vec3::new(0.2, 0.2, 1.0), Vec3::ZERO);
    let model = free_body(JointKind::Planar, cart, vec![post]);
    let rows: [&[f64]; 5] = [
        &[-1.5, 0.0, 3.1],
        &[-0.8, 0.9, -2.9],
        &[0.0, 1.0, 2.2],
        &[0.9, 0.8, -2.5],
        &[1.5, 0.0, -3.1],
    ];
    let given = path(3, &rows);
    for mode in MODES {
        let free = shorten(&model, &given, &ones(&model, mode));
        assert!(
            free.length_after < 0.85 * free.length_before,
            "{mode:?}: {}",
            free.length_after
        );

        let fixed = Settings {
            fixed_waypoints: Some(vec![false, false, true, false, false]),
            ..ones(&model, mode)
        };
        let outcome = shorten(&model, &given, &fixed);
        assert!(
            outcome
                .path
                .waypoints()
                .any(|row| row == given.waypoint(2)),
            "{mode:?}: the fixed waypoint is gone"
        );

        let only_angle = Settings {
            moving: Some(vec![false, false, true]),
            ..ones(&model, mode)
        };
        let outcome = shorten(&model, &given, &only_angle);
        let travel = |path: &Path| -> f64 {
            path.segments()
                .map(|[a, b]| (b[0] - a[0]).hypot(b[1] - a[1]))
                .sum()
        };
        assert!(
            (travel(&outcome.path) - travel(&given)).abs() < 1e-9,
            "{mode:?}"
        );
        assert!(
            outcome.length_after < outcome.length_before,
            "{mode:?}: the angle need not turn to and fro"
        );
        // The corners of the still motion are all there.
        for corner in given.waypoints() {
            let is_there = |row: &[f64]| (row[0] - corner[0]).hypot(row[1] - corner[1]) < 1e-9;
            assert!(
                outcome.path.waypoints().any(is_there),
                "{mode:?}: {corner:?} is gone"
            );
        }
    }
}

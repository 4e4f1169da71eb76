//! Paths that must keep more than clearance: each shape of robot and constraint once, kept and
//! shortened, and once broken and refused with its number. What is kept is worked out here, by hand.

use std::sync::Arc;

use serde_json::{Value, json};
use taut::collision::CollisionModel;
use taut::constraint::ConstraintsFile;
use taut::math::{Pose, Vec3};
use taut::optimize::{
    KeptConstraint, Mode, Outcome, RefusalPlace, RequestError, Settings, Workspace, run,
};
use taut::path::Path;
use taut::robot::{
    JointDescription, JointKind, LinkDescription, RobotDescription, RobotModel, VirtualJoint,
};
use taut::scene::{Obstacle, Scene};
use taut::shape::{PlacedShape, Shape};
use taut::validation::reference::{self, Objection};
use taut::validation::{HitReason, RequirementKind, Unit};

/// Looks at each segment of an answer.
const LOOKS: usize = 1000;

fn joint(name: &str, kind: JointKind, parent: &str, axis: Vec3, at: [f64; 3]) -> JointDescription {
    JointDescription {
        name: format!("to_{name}"),
        kind,
        parent: parent.into(),
        child: name.into(),
        origin: Pose::from_parts(Vec3::from_array(at), taut::math::Quat::IDENTITY),
        axis,
        limits: Some((-4.0, 4.0)),
        soft_limits: None,
        mimic: None,
    }
}

fn ball(radius: f64) -> Vec<PlacedShape> {
    vec![PlacedShape {
        pose: Pose::identity(),
        shape: Shape::sphere(radius).unwrap(),
    }]
}

/// A tree of joints of which the last link is a small ball, far from the only obstacle.
fn model(joints: Vec<JointDescription>, virtual_joint: Option<VirtualJoint>) -> CollisionModel {
    let mut names = vec!["base".to_owned()];
    names.extend(joints.iter().map(|joint| joint.child.clone()));
    let last = names.len() - 1;
    let links = names.iter().enumerate();
    let links = links
        .map(|(i, name)| LinkDescription {
            name: name.clone(),
            collision: if i == last { ball(0.01) } else { Vec::new() },
        })
        .collect();
    let robot = RobotModel::new(RobotDescription {
        name: "tree".into(),
        links,
        joints,
        virtual_joint,
        ..Default::default()
    });
    let mut far = Obstacle::new("far", ball(0.1));
    far.pose = Pose::from_parts(Vec3::new(0.0, 0.0, 9.0), taut::math::Quat::IDENTITY);
    let scene = Scene::new("far", vec![far], Vec::new(), Vec::new()).unwrap();
    CollisionModel::new(Arc::new(robot.unwrap()), Arc::new(scene)).unwrap()
}

fn settings(constraints: &Value) -> Settings {
    Settings {
        constraints: serde_json::from_value::<ConstraintsFile>(constraints.clone()).unwrap(),
        ..Settings::default()
    }
}

fn path<const N: usize>(rows: &[[f64; N]]) -> Path {
    Path::from_rows(N, rows.concat()).unwrap()
}

fn answer(model: &CollisionModel, path: &Path, settings: &Settings) -> Outcome {
    answer_in(&mut Workspace::default(), model, path, settings)
}

fn answer_in(
    workspace: &mut Workspace,
    model: &CollisionModel,
    path: &Path,
    settings: &Settings,
) -> Outcome {
    // Of every joint as much: what is no body's weighs nothing by reach.
    let settings = Settings {
        weights: Some(vec![1.0; model.robot().space().nv()]),
        ..settings.clone()
    };
    run(
        model,
        path,
        &settings,
        workspace,
        &mut || false,
        &mut |_| {},
    )
    .unwrap()
}

/// The most of a number along a path whose columns are all numbers.
fn most(path: &Path, number: impl Fn(&[f64]) -> f64) -> f64 {
    let mut most = f64::NEG_INFINITY;
    for [from, to] in path.segments() {
        for look in 0..=LOOKS {
            let t = look as f64 / LOOKS as f64;
            let between = from
                .iter()
                .zip(to)
                .map(|(a, b)| a + t * (b - a));
            most = most.max(number(&between.collect::<Vec<f64>>()));
        }
    }
    most
}

/// A kind of constraint: what is asked, what reads it, and one path that keeps it and one that does not.
struct Case {
    model: CollisionModel,
    constraints: Value,
    allowed: f64,
    reads: fn(&[f64]) -> f64,
    keeps: Path,
    breaks: Path,
    kind: RequirementKind,
    unit: Unit,
}

/// The answer names what is left, where least is, and what holds it; by samples that is so.
fn judge_keeps(case: &Case, kept: &Outcome, reading: f64) {
    let named = |keeps: &&KeptConstraint| keeps.tightest.requirement.kind == case.kind;
    let keeps = kept.keeps.iter().find(named).unwrap();
    let tightest = &keeps.tightest;
    assert_eq!(tightest.requirement.unit, case.unit);
    let least = case.allowed - reading;
    assert!(
        keeps.left.is_sign_positive() && keeps.left <= least + 1e-12,
        "{keeps:?}"
    );
    assert!(tightest.amount >= keeps.left && tightest.amount < least + 1e-4 * case.allowed);
    assert!(
        keeps.left > least - 0.06 * least.max(0.05 * case.allowed),
        "{keeps:?}, {least}"
    );
    let ends = [0, 1].map(|end| kept.path.waypoint(tightest.segment + end));
    let at = ends[0].iter().zip(ends[1]);
    let at: Vec<f64> = at
        .map(|(a, b)| a + tightest.t * (b - a))
        .collect();
    let there = case.allowed - (case.reads)(&at);
    assert!((there - tightest.amount).abs() < 1e-9, "{there}, {keeps:?}");
    if let Some(asked) = keeps.asked {
        assert_eq!(asked, case.allowed);
    }
    let claimed = &kept.certificate.as_ref().unwrap().constraints;
    let index = kept
        .keeps
        .iter()
        .position(|known| known == keeps);
    assert_eq!(claimed.as_ref().unwrap().least(index.unwrap()), keeps.left);
    let holds = &kept.nearest.as_ref().unwrap().holds;
    let is_held = holds
        .iter()
        .any(|hold| hold.requirement == tightest.requirement);
    assert_eq!(is_held, tightest.amount < 0.03 * case.allowed, "{keeps:?}");
}

/// The input that keeps it is shortened and keeps it still, by samples and by the reference checker;
/// the one that breaks it is refused where it does, by as much as it does.
fn judge(case: &Case) {
    let settings = settings(&case.constraints);
    let kept = answer(&case.model, &case.keeps, &settings);
    assert!(kept.proved, "{:?}", kept.refusal);
    assert!(
        kept.length_after < 0.999 * kept.length_before,
        "{}",
        kept.length_after
    );
    assert!(kept.floors_lowered.is_empty());
    let reading = most(&kept.path, case.reads);
    assert!(reading <= case.allowed, "{reading} of {}", case.allowed);
    judge_keeps(case, &kept, reading);
    let certificate = kept.certificate.unwrap();
    let verify = |certificate| {
        reference::verify(
            &case.model,
            &kept.path,
            certificate,
            &mut || false,
            &mut |_| {},
        )
    };
    verify(&certificate).unwrap();
    let mut edited = certificate.clone();
    for left in &mut edited.constraints.as_mut().unwrap().left {
        left.iter_mut()
            .for_each(|left| *left += 0.5 * case.allowed);
    }
    assert!(matches!(verify(&edited), Err(Objection::Edited { .. })));
    assert!(matches!(
        verify(&edited.clone().sealed()),
        Err(Objection::Less(_))
    ));

    let broken = answer(&case.model, &case.breaks, &settings);
    assert!(!broken.proved && broken.certificate.is_none() && broken.keeps.is_empty());
    let refusal = broken.refusal.unwrap();
    assert_eq!(refusal.reason, HitReason::Outside);
    assert_eq!(refusal.requirement.kind, case.kind);
    assert_eq!(refusal.requirement.unit, case.unit);
    let ends = [0, 1].map(|end| case.breaks.waypoint(refusal.segment + end));
    let at = ends[0].iter().zip(ends[1]);
    let at: Vec<f64> = at
        .map(|(a, b)| a + refusal.t * (b - a))
        .collect();
    let outside = (case.reads)(&at) - case.allowed;
    assert!(
        (refusal.amount + outside).abs() < 1e-9,
        "{refusal:?}, {outside}"
    );
    assert!(outside > 0.0);
}

/// Leans by its first joint, turns by its second, nods by its third.
fn cup() -> CollisionModel {
    model(
        vec![
            joint("leaning", JointKind::Revolute, "base", Vec3::Y, [0.0; 3]),
            joint(
                "turning",
                JointKind::Revolute,
                "leaning",
                Vec3::Z,
                [0.3, 0.0, 0.2],
            ),
            joint(
                "cup",
                JointKind::Revolute,
                "turning",
                Vec3::Y,
                [0.3, 0.0, 0.2],
            ),
        ],
        None,
    )
}

fn tilt(q: &[f64]) -> f64 {
    let [lean, turn, nod] = [q[0], q[1], q[2]];
    let upright = lean.cos() * nod.cos() - lean.sin() * turn.cos() * nod.sin();
    let across = [
        lean.cos() * turn.cos() * nod.sin() + lean.sin() * nod.cos(),
        turn.sin() * nod.sin(),
    ];
    across[0].hypot(across[1]).atan2(upright)
}

fn upright(within: f64) -> Value {
    json!({"name": "upright", "orientation_constraints": [{"link_name": "cup",
        "axis": [0, 0, 1], "reference": [0, 0, 1], "tolerance_rad": within}]})
}

/// Round the corner that being upright makes, and a little beyond.
fn round_the_corner() -> Path {
    path(&[
        [0.8, 0.0, -0.8],
        [1.0, 0.0, -0.96],
        [0.0, 0.0, 0.0],
        [0.03, 1.6, 0.03],
        [0.0, 3.1, 0.0],
        [0.8, 3.1, 0.8],
    ])
}

#[test]
fn a_cup_stays_upright() {
    judge(&Case {
        model: cup(),
        constraints: upright(0.1),
        allowed: 0.1,
        reads: tilt,
        keeps: round_the_corner(),
        breaks: path(&[[0.8, 0.0, -0.8], [0.8, 3.1, 0.8]]),
        kind: RequirementKind::Orientation,
        unit: Unit::Radian,
    });
}

#[test]
fn every_mode_keeps_it() {
    for &mode in &Mode::ALL {
        let settings = Settings {
            mode,
            ..settings(&upright(0.1))
        };
        let outcome = answer(&cup(), &round_the_corner(), &settings);
        assert!(outcome.proved, "{mode:?}");
        assert!(most(&outcome.path, tilt) <= 0.1, "{mode:?}");
    }
}

/// Two hands, each on a slide and a wrist, hold a tray.
#[test]
fn a_tray_stays_between_two_hands() {
    let joints = vec![
        joint("left_arm", JointKind::Prismatic, "base", Vec3::X, [0.0; 3]),
        joint("left", JointKind::Revolute, "left_arm", Vec3::Y, [0.0; 3]),
        joint(
            "right_arm",
            JointKind::Prismatic,
            "base",
            Vec3::X,
            [0.0, 0.5, 0.0],
        ),
        joint("right", JointKind::Revolute, "right_arm", Vec3::Y, [0.0; 3]),
    ];
    let constraints = json!({"name": "tray",
        "position_constraints": [{"link_name": "right", "header": {"frame_id": "left"},
            "constraint_region": {"primitives": [{"type": "sphere", "dimensions": [0.005]}],
                "primitive_poses": [{"position": [0, 0.5, 0]}]}}],
        "orientation_constraints": [{"link_name": "right", "header": {"frame_id": "left"},
            "axis": [0, 0, 1], "reference": [0, 0, 1], "tolerance_rad": 0.02}]});
    judge(&Case {
        model: model(joints, None),
        constraints,
        allowed: 0.005,
        reads: |q| {
            assert!((q[0] - q[2]).abs() > 0.011 || (q[1] - q[3]).abs() <= 0.02 + 1e-12);
            (q[0] - q[2]).abs()
        },
        keeps: path(&[
            [0.0, 0.0, 0.0, 0.0],
            [0.4, 0.6, 0.4025, 0.61],
            [0.7, -0.3, 0.6975, -0.31],
            [1.0, 0.2, 1.0, 0.2],
        ]),
        breaks: path(&[
            [0.0, 0.0, 0.0, 0.0],
            [0.4, 0.6, 0.416, 0.6],
            [1.0, 0.2, 1.0, 0.2],
        ]),
        kind: RequirementKind::Position,
        unit: Unit::Metre,
    });
}

/// A line of a tenth of a metre in a box of half a millimetre, by a slide on an arm.
#[test]
fn a_tool_stays_on_a_line() {
    let joints = vec![
        joint("along", JointKind::Prismatic, "base", Vec3::X, [0.0; 3]),
        joint("across", JointKind::Prismatic, "along", Vec3::Y, [0.0; 3]),
        joint("tool", JointKind::Revolute, "across", Vec3::X, [0.0; 3]),
    ];
    let constraints = json!({"position_constraints": [{"link_name": "tool",
        "constraint_region": {"primitives": [{"type": "box", "dimensions": [0.12, 0.0005, 0.0005]}],
            "primitive_poses": [{"position": [0.05, 0, 0]}]}}]});
    judge(&Case {
        model: model(joints, None),
        constraints,
        allowed: 0.00025,
        reads: |q| q[1].abs(),
        keeps: path(&[
            [0.0, 0.0, 0.0],
            [0.03, 0.000125, 0.4],
            [0.06, -0.000125, -0.3],
            [0.1, 0.0, 0.1],
        ]),
        breaks: path(&[[0.0, 0.0, 0.0], [0.05, 0.001, 0.0], [0.1, 0.0, 0.0]]),
        kind: RequirementKind::Position,
        unit: Unit::Metre,
    });
}

/// A base that turns and goes, within a corridor.
#[test]
fn a_base_stays_in_its_corridor() {
    let base = VirtualJoint {
        name: "root".into(),
        kind: JointKind::Planar,
        position_bounds: Vec::new(),
        parent_frame: String::new(),
    };
    let joints = vec![joint(
        "nose",
        JointKind::Prismatic,
        "base",
        Vec3::X,
        [0.0; 3],
    )];
    let constraints = json!({"name": "corridor", "position_constraints": [{"link_name": "base",
        "constraint_region": {"primitives": [{"type": "box", "dimensions": [8, 0.6, 1]}],
            "primitive_poses": [{"position": [2, 0, 0]}]}}]});
    judge(&Case {
        model: model(joints, Some(base)),
        constraints,
        allowed: 0.3,
        reads: |q| q[1].abs(),
        keeps: path(&[
            [0.0, 0.0, 0.0, 0.0],
            [1.0, 0.15, 0.5, 0.1],
            [2.0, -0.15, -0.5, 0.2],
            [4.0, 0.0, 0.0, 0.0],
        ]),
        breaks: path(&[
            [0.0, 0.0, 0.0, 0.0],
            [2.0, 0.9, 0.0, 0.0],
            [4.0, 0.0, 0.0, 0.0],
        ]),
        kind: RequirementKind::Position,
        unit: Unit::Metre,
    });
}

/// Waypoints are upright, the way between them strays a little: the tolerance is raised to what is
/// kept, and named; who is strict gets a refusal.
#[test]
fn a_tube_is_named_where_the_input_strays() {
    let straying = path(&[[0.3, 0.0, -0.3], [0.15, 1.5, -0.02], [0.0, 3.0, 0.02]]);
    let within = 0.99 * most(&straying, tilt);
    let ends = straying
        .waypoints()
        .map(tilt)
        .fold(0.0, f64::max);
    assert!(ends < within, "{ends} {within}");
    let named = answer(&cup(), &straying, &settings(&upright(within)));
    assert!(named.proved);
    let [raised] = named.floors_lowered.as_slice() else {
        panic!("{:?}", named.floors_lowered);
    };
    assert_eq!(raised.requirement.names, ["upright: cup"]);
    assert!(
        raised.floor < 0.0 && raised.floor > -0.05 * within,
        "{raised:?}"
    );
    assert!(most(&named.path, tilt) <= within - raised.floor);
    assert!(named.floor_m > 0.0, "floors of clearances are others");
    let certificate = named.certificate.unwrap();
    reference::verify(
        &cup(),
        &named.path,
        &certificate,
        &mut || false,
        &mut |_| {},
    )
    .unwrap();
    let strict = Settings {
        strict: true,
        ..settings(&upright(within))
    };
    let refused = answer(&cup(), &straying, &strict);
    assert_eq!(refused.refusal.unwrap().reason, HitReason::Outside);
}

#[test]
fn waypoints_that_stay_must_keep_it() {
    let middle = path(&[[0.0, 0.0, 0.0], [0.15, 0.5, 0.0], [0.0, 1.0, 0.0]]);
    let fixed = Settings {
        fixed_waypoints: Some(vec![false, true, false]),
        ..settings(&upright(0.1))
    };
    let start = path(&[[0.15, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let goal = path(&[[0.0, 0.0, 0.0], [0.15, 1.0, 0.0]]);
    let plain = settings(&upright(0.1));
    for (path, settings, place) in [
        (&middle, &fixed, RefusalPlace::Between),
        (&start, &plain, RefusalPlace::Start),
        (&goal, &plain, RefusalPlace::Goal),
    ] {
        let refusal = answer(&cup(), path, settings).refusal.unwrap();
        assert_eq!((refusal.reason, refusal.place), (HitReason::Outside, place));
        assert!((refusal.amount + 0.05).abs() < 1e-9, "{refusal:?}");
        assert_eq!(refusal.hint, "0.15000 rad, allowed 0.1");
    }
}

#[test]
fn a_corridor_of_a_path_with_constraints_is_refused_by_name() {
    let settings = Settings {
        corridor: true,
        ..settings(&upright(0.1))
    };
    let mut workspace = Workspace::default();
    let path = round_the_corner();
    let outcome = run(
        &cup(),
        &path,
        &settings,
        &mut workspace,
        &mut || false,
        &mut |_| {},
    );
    assert!(matches!(outcome, Err(RequestError::WithConstraints { .. })));
}

/// A worker that has proved a segment for somebody who asked for nothing has not proved it for who asks
/// for a constraint, nor in another scene: what is at hand where constraints refuse is no proof.
#[test]
fn what_another_request_left_at_hand_proves_nothing() {
    let straight = path(&[[0.8, 0.0, -0.8], [0.8, 3.1, 0.8]]);
    let mut workspace = Workspace::default();
    for asks in [Value::Null, upright(1.5), Value::Null] {
        let free = Settings {
            constraints: serde_json::from_value(asks).unwrap(),
            ..Settings::default()
        };
        assert!(answer_in(&mut workspace, &cup(), &straight, &free).proved);
        for is_strict in [false, true] {
            let kept = Settings {
                strict: is_strict,
                ..settings(&upright(0.1))
            };
            let outcome = answer_in(&mut workspace, &cup(), &straight, &kept);
            assert!(!outcome.proved);
            assert_eq!(outcome.refusal.unwrap().reason, HitReason::Outside);
        }
    }
}

#[test]
fn a_weight_other_than_one_is_told_to_change_nothing() {
    let weighed = |weight: f64| {
        let mut asked = upright(0.1);
        asked["orientation_constraints"][0]["weight"] = json!(weight);
        answer(&cup(), &round_the_corner(), &settings(&asked))
    };
    let of_weights = |outcome: &Outcome| -> Vec<String> {
        let warnings = outcome.warnings.iter();
        warnings
            .filter(|warning| warning.contains("weight"))
            .map(ToString::to_string)
            .collect()
    };
    let [one, half] = [1.0, 0.5].map(weighed);
    assert!(of_weights(&one).is_empty());
    let told = of_weights(&half);
    let expected =
        "constraint \"upright: cup\": its weight 0.5 changes nothing, all of it must hold";
    assert_eq!(told, [expected]);
    assert_eq!(one.path, half.path);
}

/// A path that nothing pulls at: what is told of it is about the caller's segments, whichever waypoints
/// are there twice.
#[test]
fn what_is_kept_of_a_path_that_is_only_checked_is_told_of_its_own_segments() {
    let twice = path(&[
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.05, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ]);
    let check = Settings {
        mode: Mode::Check,
        ..settings(&upright(0.05 / 0.99))
    };
    let outcome = answer(&cup(), &twice, &check);
    assert!(outcome.proved);
    let [kept] = outcome.keeps.as_slice() else {
        panic!("{:?}", outcome.keeps);
    };
    let place = (kept.tightest.segment, kept.tightest.t);
    assert!(place == (2, 1.0) || place == (3, 0.0), "{kept:?}");
    let holds = outcome.nearest.unwrap().holds;
    let [hold] = holds.as_slice() else {
        panic!("one waypoint holds it: {holds:?}");
    };
    assert_eq!(hold, &kept.tightest);
}

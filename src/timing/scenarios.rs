//! What may be asked of a trajectory besides limits: fixed waypoints, a start velocity, a controller.

use super::tests::{AROUND, BESIDE, FLOOR_M, alike, check, least_distance, settings, timed};
use super::*;
use crate::collision::CollisionModel;
use crate::math::Vec3;
use crate::testing;
use std::sync::Arc;

const CONTROLLERS: [Controller; 4] = [
    Controller::Cubic,
    Controller::Quintic,
    Controller::Linear { rate_hz: 250.0 },
    Controller::Linear { rate_hz: 30.0 },
];

/// A bend, a corner, and a way back.
const BENDS: [[f64; 2]; 6] = [
    [0.0, 0.0],
    [0.4, 0.05],
    [0.8, 0.0],
    [0.8, 0.5],
    [0.6, 0.5],
    [1.0, 0.5],
];

fn asked(fixed: Fixed, controller: Controller) -> Settings {
    Settings {
        fixed_waypoints: fixed,
        controller,
        ..settings(alike(2, 1.0, 2.0))
    }
}

fn is_passed(timed: &Timed, row: &[f64; 2]) -> bool {
    let bits = |row: &[f64]| {
        row.iter()
            .map(|value| value.to_bits())
            .collect::<Vec<_>>()
    };
    let mut points = timed.points.iter();
    points.any(|point| bits(&point.positions) == bits(row))
}

#[test]
fn every_controller_gets_a_trajectory_that_is_proved_as_it_goes_along_it() {
    let model = testing::slider(&[BESIDE]);
    for controller in CONTROLLERS {
        let settings = asked(Fixed::Ends, controller);
        let (best, published) = timed(&model, &AROUND, &settings).unwrap();
        let cubic = timed(&model, &AROUND, &asked(Fixed::Ends, Controller::Cubic))
            .unwrap()
            .0;
        let slower = best.duration_s() / cubic.duration_s();
        assert!(
            published.len() > 1 && slower < 1.05,
            "{controller}: {slower}"
        );
        for timed in &published {
            check(timed, &AROUND, &settings.limits);
            assert!(timed.proof.as_ref().unwrap().clearance_m() >= FLOOR_M);
            assert!(least_distance(timed, &[BESIDE]) >= FLOOR_M, "{controller}");
        }
    }
}

#[test]
fn points_say_what_their_controller_goes_by() {
    let model = testing::slider(&[]);
    let of = |controller| {
        timed(&model, &AROUND, &asked(Fixed::Ends, controller))
            .unwrap()
            .0
    };
    let cubic = of(Controller::Cubic);
    assert!(
        cubic
            .points
            .iter()
            .all(|point| point.velocities.len() == 2 && point.accelerations.is_empty())
    );
    // A quintic begins and ends without an acceleration, and is a little slower.
    let quintic = of(Controller::Quintic);
    let [first, last] = [0, quintic.points.len() - 1].map(|end| &quintic.points[end]);
    for end in [first, last] {
        assert_eq!(
            (end.velocities.as_slice(), end.accelerations.as_slice()),
            (&[0.0; 2][..], &[0.0; 2][..])
        );
    }
    let slower = quintic.duration_s() - cubic.duration_s();
    assert!((0.0..0.02).contains(&slower), "{slower}");
    let linear = of(Controller::Linear { rate_hz: 250.0 });
    for (sample, point) in (0..).zip(&linear.points) {
        assert_eq!(point.time_ns, sample * 4_000_000);
        assert!(point.velocities.is_empty() && point.accelerations.is_empty());
    }
    let rate = |from: &TimedPoint, to: &TimedPoint, column: usize| {
        (to.positions[column] - from.positions[column]) * 250.0
    };
    for points in linear.points.windows(3) {
        for column in 0..2 {
            let [before, after] = [0, 1].map(|at| rate(&points[at], &points[at + 1], column));
            assert!(after.abs() <= 1.0 + 1e-6 && ((after - before) * 250.0).abs() <= 2.0 + 1e-6);
        }
    }
}

#[test]
fn controllers_are_named() {
    for controller in CONTROLLERS {
        assert_eq!(controller.to_string().parse(), Ok(controller));
    }
    for text in [
        "",
        "spline",
        "linear",
        "linear@",
        "linear@0",
        "linear@-1",
        "linear@NaN",
        "linear@1e9",
    ] {
        let error = text
            .parse::<Controller>()
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("is no controller; give cubic, quintic, or linear@250"),
            "{error}"
        );
    }
    let model = testing::slider(&[]);
    let refused = timed(
        &model,
        &AROUND,
        &asked(Fixed::Ends, Controller::Linear { rate_hz: 0.0 }),
    );
    assert!(
        refused
            .unwrap_err()
            .to_string()
            .starts_with("\"linear@0\" is no controller")
    );
}

#[test]
fn fixed_waypoints_are_passed_to_the_last_bit() {
    let model = testing::slider(&[]);
    for controller in CONTROLLERS {
        for fixed in [Fixed::All, Fixed::These(vec![1, 3, 0, 5])] {
            let settings = asked(fixed.clone(), controller);
            let (best, published) = timed(&model, &BENDS, &settings).unwrap();
            for timed in &published {
                check(timed, &BENDS, &settings.limits);
                for (waypoint, row) in BENDS.iter().enumerate() {
                    let is_asked = fixed.contains(waypoint);
                    assert!(
                        !is_asked || is_passed(timed, row),
                        "{controller}: {waypoint}"
                    );
                }
            }
            // Straight at a rate each is rested at, and between them there is nothing to gain.
            let may_gain = controller.manner().passes_moving || fixed != Fixed::All;
            assert_eq!(best.duration_s() < published[0].duration_s(), may_gain);
        }
    }
    // Nothing is passed that need not be.
    let (free, _) = timed(&model, &BENDS, &asked(Fixed::Ends, Controller::Cubic)).unwrap();
    assert!(
        BENDS[1..5]
            .iter()
            .all(|row| !is_passed(&free, row))
    );
}

#[test]
fn a_fixed_waypoint_is_passed_without_a_stop_where_that_is_possible() {
    let model = testing::slider(&[]);
    let rows = [[0.0, 0.0], [0.4, 0.05], [0.8, 0.0]];
    let least = |rows: &[[f64; 2]], controller| {
        let settings = asked(Fixed::All, controller);
        timed(&model, rows, &settings).unwrap().0
    };
    for controller in [Controller::Cubic, Controller::Quintic] {
        let best = least(&rows, controller);
        let passed = best
            .points
            .iter()
            .find(|point| point.positions == rows[1])
            .unwrap();
        assert!(passed.velocities[0] > 0.5, "{passed:?}");
        // With a stop each half takes √0.8 s, without one the whole 1.3 s.
        assert!(
            best.duration_s() < 1.34,
            "{controller}: {}",
            best.duration_s()
        );
    }
    // Where it turns back it rests.
    let best = least(&[[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]], Controller::Cubic);
    assert!(
        (best.duration_s() - 3.0).abs() < 2e-3,
        "{}",
        best.duration_s()
    );
}

#[test]
fn a_fixed_waypoint_next_to_another_is_passed_all_the_same() {
    let model = testing::slider(&[]);
    for controller in CONTROLLERS {
        for near in [1e-10, 1e-6, 0.0] {
            let rows = [
                [0.0, 0.0],
                [0.5, 0.0],
                [0.5 + near, 0.0],
                [0.5 + near, 0.0],
                [1.0, 0.2],
            ];
            let settings = asked(Fixed::These(vec![2]), controller);
            let (best, _) = timed(&model, &rows, &settings).unwrap();
            check(&best, &rows, &settings.limits);
            assert!(is_passed(&best, &rows[2]), "{controller} {near}");
        }
    }
    let refused = timed(
        &model,
        &AROUND,
        &asked(Fixed::These(vec![1, 3]), Controller::Cubic),
    );
    assert_eq!(
        refused.unwrap_err().to_string(),
        "waypoint 3 is to be fixed; the path has waypoints 0 to 2"
    );
}

fn moving(velocity: [f64; 2], controller: Controller) -> Settings {
    Settings {
        start_velocity: Some(velocity.to_vec()),
        ..asked(Fixed::Ends, controller)
    }
}

#[test]
fn a_start_velocity_is_gone_on_from() {
    let model = testing::slider(&[BESIDE]);
    let walls = [BESIDE];
    let rest = timed(&model, &AROUND, &settings(alike(2, 1.0, 2.0)))
        .unwrap()
        .0;
    // Along the path, across it, back.
    for velocity in [[0.9, 0.18], [0.0, -1.0], [-0.7, 0.3]] {
        for controller in CONTROLLERS {
            let settings = moving(velocity, controller);
            let (best, published) = timed(&model, &AROUND, &settings).unwrap();
            for timed in &published {
                check(timed, &AROUND, &settings.limits);
                assert!(least_distance(timed, &walls) >= FLOOR_M);
                let first = &timed.points[0];
                match controller {
                    // The first difference is the velocity but for what changes in half of it.
                    Controller::Linear { rate_hz } => {
                        for (column, start) in velocity.iter().enumerate() {
                            let change =
                                timed.points[1].positions[column] - first.positions[column];
                            let difference = change * rate_hz - start;
                            assert!(difference.abs() <= 1.0 / rate_hz + 1e-6, "{difference}");
                        }
                    }
                    _ => assert_eq!(first.velocities, velocity),
                }
            }
            assert!(best.duration_s() < rest.duration_s() + 1.0);
        }
    }
    let along = timed(&model, &AROUND, &moving([0.9, 0.18], Controller::Cubic))
        .unwrap()
        .0;
    assert!(along.duration_s() < rest.duration_s() - 0.1);
    // The first column needs 1.2 m from 0.9 m/s on, the second 1.2 m from 0.18 m/s on: that is slower.
    assert_eq!(along.bound.column, 1);
    assert!(
        (along.bound.time_s - (1.2 + 0.82 * 0.82 / 4.0 + 0.25)).abs() < 1e-9,
        "{:?}",
        along.bound
    );
}

#[test]
fn a_velocity_at_the_goal_is_stopped_and_turned_back_from() {
    let model = testing::slider(&[]);
    for controller in CONTROLLERS {
        let rows = [[0.3, 0.1]; 2];
        let settings = moving([0.5, 0.0], controller);
        let (best, _) = timed(&model, &rows, &settings).unwrap();
        check(&best, &rows, &settings.limits);
        // 0.25 s to a stop, 0.0625 m back in 2 √(0.0625 / 2) s.
        let least_s = 0.25 + 2.0 * 0.03125_f64.sqrt();
        assert!((best.bound.time_s - least_s).abs() < 1e-9);
        assert!(best.gap() < 0.15, "{controller}: {}", best.gap());
    }
}

#[test]
fn a_start_velocity_that_cannot_be_stopped_is_refused_with_what_was_tried() {
    let wall = (Vec3::new(0.3, 0.0, 0.0), Vec3::new(0.1, 0.3, 1.0));
    let model = testing::slider(&[wall]);
    let rows = [[0.0, 0.0], [0.0, 0.9]];
    // It needs 0.25 m, and there are 0.15 m.
    let error = timed(&model, &rows, &moving([1.0, 0.0], Controller::Cubic)).unwrap_err();
    let text = error.to_string();
    assert!(
        text.ends_with(
            "ways were tried; straight on it rests after 0.5000 s, joint0 +0.2500 from the start"
        ),
        "{text}"
    );
    let hit = error.hit().unwrap();
    assert!((0.15..0.5).contains(&hit.time_s), "{hit:?}");
    // Half as fast there is room.
    let (best, _) = timed(&model, &rows, &moving([0.5, 0.0], Controller::Cubic)).unwrap();
    check(&best, &rows, &alike(2, 1.0, 2.0));
    assert!(least_distance(&best, &[wall]) >= FLOOR_M);
}

#[test]
fn a_start_velocity_out_of_limits_is_refused_by_name() {
    let model = testing::slider(&[]);
    let refusal = |velocity: &[f64], rows: &[[f64; 2]]| {
        let settings = Settings {
            start_velocity: Some(velocity.to_vec()),
            ..settings(alike(2, 1.0, 2.0))
        };
        timed(&model, rows, &settings)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        refusal(&[0.0, -1.5], &AROUND),
        "the start velocity of joint1 is -1.5; its limits are [-1, 1]"
    );
    assert!(refusal(&[f64::NAN, 0.0], &AROUND).starts_with("the start velocity of joint0 is NaN"));
    assert_eq!(
        refusal(&[0.0; 3], &AROUND),
        "start velocities of 3 columns given; the robot has 2"
    );
    // There is no room to stop within the joint's limits.
    let text = refusal(&[1.0, 0.0], &[[1.9, 0.0], [1.0, 0.5]]);
    assert!(
        text.contains("outside of the limits of joint0 by 0.1500 at"),
        "{text}"
    );
}

#[test]
fn what_is_used_of_the_limits_is_told_of_each_column() {
    let model = testing::slider(&[]);
    let rows = [[0.0, 0.0], [1.0, 0.1]];
    for controller in CONTROLLERS {
        let settings = asked(Fixed::Ends, controller);
        let (best, _) = timed(&model, &rows, &settings).unwrap();
        let [fast, slow] = best.usage.as_slice() else {
            panic!("{:?}", best.usage)
        };
        assert_eq!(
            (
                fast.velocity.column,
                slow.velocity.column,
                best.bound.column
            ),
            (0, 1, 0)
        );
        assert!(
            (fast.velocity.part - 1.0).abs() < 1e-3,
            "{controller}: {fast:?}"
        );
        assert!((0.49..1.01).contains(&fast.velocity.time_s), "{fast:?}");
        assert!(
            (fast.acceleration.part - 1.0).abs() < 1e-2,
            "{controller}: {fast:?}"
        );
        assert!(
            slow.velocity.part < 0.6 && slow.velocity.part >= 0.099,
            "{slow:?}"
        );
        assert_eq!(best.most_used().velocity, fast.velocity);
    }
}

#[test]
fn the_nearest_place_is_told_in_time() {
    let model = testing::slider(&[BESIDE]);
    let (best, _) = timed(&model, &AROUND, &settings(alike(2, 1.0, 2.0))).unwrap();
    let curve = best.curve(model.robot()).unwrap();
    let space = model.robot().space().unwrapped();
    let mut scratch = crate::validation::Scratch::default();
    let mut validator = Validator::new(&model, &space, &[], FLOOR_M, &mut scratch);
    let nearest = proof::nearest(&mut validator, &curve, &mut || false).unwrap();
    let near = nearest.smallest.unwrap();
    let least = least_distance(&best, &[BESIDE]);
    assert!(
        (near.measure.amount - least).abs() < 0.25 * FLOOR_M,
        "{near:?} {least}"
    );
    let time_s = curve.time_of(near.segment, near.t);
    let at = curve.at(near.segment, near.t * curve.duration(near.segment));
    let distance = (at[0] - 0.9)
        .hypot(at[1] - 0.3)
        .min(at[0] - 0.9)
        .max(0.0)
        - 0.05;
    assert!(
        (0.0..best.duration_s()).contains(&time_s) && distance < 0.1,
        "{at:?}"
    );
}

/// A turning joint, and a body that floats.
const ODD: &str = r#"<robot name="odd"><link name="base"/><link name="wheel"/><link name="body"/>
<joint name="turn" type="continuous"><parent link="base"/><child link="wheel"/><axis xyz="0 0 1"/></joint>
<joint name="float" type="floating"><parent link="base"/><child link="body"/></joint></robot>"#;

/// What comes of a path of the odd robot with the limits 1 and 2 of whatever moves.
fn odd(rows: &[[f64; 8]], settings: impl Fn(Settings) -> Settings) -> Result<Timed, TimingError> {
    let mut none = |_: &str, _| unreachable!("there is no mesh");
    let robot = RobotModel::new(crate::robot::urdf::parse(ODD, &mut none).unwrap()).unwrap();
    let scene = crate::scene::Scene::default();
    let model = CollisionModel::new(Arc::new(robot), Arc::new(scene)).unwrap();
    let space = model.robot().space().unwrapped();
    let mut scratch = crate::validation::Scratch::default();
    let mut validator = Validator::new(&model, &space, &[], FLOOR_M, &mut scratch).closely();
    let path = Path::from_rows(8, rows.concat()).unwrap();
    let settings = settings(settings_of_odd());
    let mut stop = || false;
    match run(
        model.robot(),
        &mut validator,
        &path,
        &settings,
        &mut stop,
        &mut |_| {},
    )? {
        Outcome::Timed(timed) => Ok(timed),
        Outcome::Stopped => unreachable!("nothing stops it"),
    }
}

fn settings_of_odd() -> Settings {
    settings(alike(8, 1.0, 2.0))
}

fn placed(turn: f64, x: f64, quaternion: [f64; 4]) -> [f64; 8] {
    let [a, b, c, d] = quaternion;
    [turn, x, 0.0, 0.0, a, b, c, d]
}

const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

#[test]
fn a_step_of_a_turning_joint_means_its_numbers() {
    let rows = [placed(0.0, 0.0, UPRIGHT), placed(7.0, 0.5, UPRIGHT)];
    for controller in CONTROLLERS {
        let timed = odd(&rows, |settings| Settings {
            controller,
            ..settings
        })
        .unwrap();
        // 7 rad, not what is left of them after a turn.
        assert!(
            (timed.bound.time_s - 7.5).abs() < 1e-9 && timed.gap() < 0.01,
            "{timed:?}"
        );
        let last = &timed.points[timed.points.len() - 1];
        assert_eq!(last.positions, rows[1]);
    }
}

#[test]
fn what_floats_may_go_but_not_turn() {
    let rows = [placed(0.0, 0.0, UPRIGHT), placed(0.0, 1.0, UPRIGHT)];
    let timed = odd(&rows, |settings| settings).unwrap();
    assert!((timed.duration_s() - 1.5).abs() < 1e-3);
    let turned = [rows[0], placed(0.0, 1.0, [0.0, 0.0, 0.6, 0.8])];
    let refused = odd(&turned, |settings| settings)
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("turns; only joints of one value can be timed"),
        "{refused}"
    );
    // Nor does it begin so.
    let mut velocity = vec![0.0; 8];
    velocity[6] = 0.1;
    let start = |settings| Settings {
        start_velocity: Some(velocity.clone()),
        ..settings
    };
    let refused = odd(&rows, start).unwrap_err().to_string();
    assert!(
        refused.contains("turns; only joints of one value can be timed"),
        "{refused}"
    );
}

#[test]
fn what_stands_still_is_one_point_where_nothing_is_hit() {
    let model = testing::slider(&[BESIDE]);
    for controller in CONTROLLERS {
        // Nothing on the way there and back need be passed.
        let loop_ = [[0.0, 0.0], [0.2, 0.0], [0.0, 0.0]];
        let (best, _) = timed(&model, &loop_, &asked(Fixed::Ends, controller)).unwrap();
        assert_eq!(
            (best.points.len(), best.duration_ns(), best.gap()),
            (1, 0, 0.0)
        );
        let (best, _) = timed(&model, &loop_, &asked(Fixed::All, controller)).unwrap();
        check(&best, &loop_, &alike(2, 1.0, 2.0));
        assert!(is_passed(&best, &loop_[1]));
    }
    let inside = [[0.4, 0.8]; 2];
    let refused = timed(&model, &inside, &asked(Fixed::Ends, Controller::Cubic));
    assert!(
        matches!(refused, Err(TimingError::Refused(_))),
        "{refused:?}"
    );
}

//! Whole trajectories: proved as they are written, within limits, faster at each stage.

use fastrand::Rng;

use super::along::fastest;
use super::blend::Stretch;
use super::ramp::{Motors, Phasing};
use super::testing as oracle;
use super::*;
use crate::collision::CollisionModel;
use crate::math::Vec3;
use crate::testing;
use crate::validation::Scratch;
use crate::validation::soundness::cases;
use crate::validation::timed::Curve;

pub(super) const FLOOR_M: f64 = 1e-3;

/// Limits that differ by direction.
fn two_sided(rng: &mut Rng) -> ColumnLimits {
    let mut range = |least: f64, most: f64| Range {
        least: -testing::uniform(rng, least, most),
        most: testing::uniform(rng, least, most),
    };
    ColumnLimits {
        velocity: range(0.3, 2.0),
        acceleration: range(0.5, 4.0),
    }
}

pub(super) fn alike(columns: usize, velocity: f64, acceleration: f64) -> Limits {
    let limits = ColumnLimits {
        velocity: Range::symmetric(velocity),
        acceleration: Range::symmetric(acceleration),
    };
    Limits::new(vec![limits; columns])
}

pub(super) fn settings(limits: Limits) -> Settings {
    Settings {
        strict: true,
        seed: 1,
        ..Settings::new(limits)
    }
}

/// What comes of a path, and of each stage.
pub(super) fn timed(
    model: &CollisionModel,
    rows: &[[f64; 2]],
    settings: &Settings,
) -> Result<(Timed, Vec<Timed>), TimingError> {
    let path = Path::from_rows(2, rows.concat()).unwrap();
    let space = model.robot().space().unwrapped();
    let mut scratch = Scratch::default();
    let mut validator = Validator::new(model, &space, &[], FLOOR_M, &mut scratch).closely();
    let mut published = Vec::new();
    let outcome = run(
        model.robot(),
        &mut validator,
        &path,
        settings,
        &mut || false,
        &mut |timed| published.push(timed.clone()),
    )?;
    match outcome {
        Outcome::Timed(timed) => Ok((timed, published)),
        Outcome::Stopped => unreachable!("nothing stops it"),
    }
}

/// What a controller makes of two points, by the basis of Hermite's form and not by coefficients: position,
/// velocity and acceleration of a column at a ratio of the time between them.
fn executed(ends: &[TimedPoint], column: usize, u: f64) -> [f64; 3] {
    let [a, b] = [&ends[0], &ends[1]];
    let h = (b.time_ns - a.time_ns) as f64 * 1e-9;
    let [p, q] = [a.positions[column], b.positions[column]];
    let given = |list: &[f64], by: f64| list.get(column).map(|value| value * by);
    let rates = [a, b].map(|point| given(&point.velocities, h));
    let [Some(v), Some(w)] = rates else {
        return [p + u * (q - p), (q - p) / h, 0.0];
    };
    let bends = [a, b].map(|point| given(&point.accelerations, h * h));
    let (list, bases): (Vec<f64>, Vec<[f64; 3]>) = match bends {
        [Some(k), Some(l)] => (vec![p, v, k, q, w, l], quintic_bases(u).to_vec()),
        _ => (vec![p, v, q, w], cubic_bases(u).to_vec()),
    };
    let sum = |order: usize| -> f64 {
        let terms = list.iter().zip(&bases);
        terms
            .map(|(value, basis)| value * basis[order])
            .sum()
    };
    [sum(0), sum(1) / h, sum(2) / (h * h)]
}

/// Of position and velocity at both ends: value, derivative, second derivative.
fn cubic_bases(u: f64) -> [[f64; 3]; 4] {
    [
        [
            1.0 + u * u * (2.0 * u - 3.0),
            6.0 * u * (u - 1.0),
            12.0 * u - 6.0,
        ],
        [
            u * (1.0 + u * (u - 2.0)),
            1.0 + u * (3.0 * u - 4.0),
            6.0 * u - 4.0,
        ],
        [u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u), 6.0 - 12.0 * u],
        [u * u * (u - 1.0), u * (3.0 * u - 2.0), 6.0 * u - 2.0],
    ]
}

/// Of position, velocity and acceleration at both ends.
fn quintic_bases(u: f64) -> [[f64; 3]; 6] {
    let basis = |c: [f64; 6]| {
        let power = |order: i32| if order < 0 { 0.0 } else { u.powi(order) };
        let mut sums = [0.0; 3];
        for (order, c) in (0_i32..).zip(c) {
            let n = f64::from(order);
            sums[0] += c * power(order);
            sums[1] += c * n * power(order - 1);
            sums[2] += c * n * (n - 1.0) * power(order - 2);
        }
        sums
    };
    [
        basis([1.0, 0.0, 0.0, -10.0, 15.0, -6.0]),
        basis([0.0, 1.0, 0.0, -6.0, 8.0, -3.0]),
        basis([0.0, 0.0, 0.5, -1.5, 1.5, -0.5]),
        basis([0.0, 0.0, 0.0, 10.0, -15.0, 6.0]),
        basis([0.0, 0.0, 0.0, -4.0, 7.0, -3.0]),
        basis([0.0, 0.0, 0.0, 0.5, -1.0, 0.5]),
    ]
}

/// That points begin and end where a path does and at rest where nothing else is asked for, that time grows,
/// and that limits hold where one looks.
pub(super) fn check(timed: &Timed, rows: &[[f64; 2]], limits: &Limits) {
    let points = &timed.points;
    let last = &points[points.len() - 1];
    assert_eq!(points[0].positions, rows[0]);
    assert_eq!(last.positions, rows[rows.len() - 1]);
    assert!(
        last.velocities
            .iter()
            .all(|velocity| *velocity == 0.0)
    );
    assert_eq!(points[0].time_ns, 0);
    for ends in points.windows(2) {
        assert!(ends[1].time_ns > ends[0].time_ns);
        for (column, own) in limits.columns().iter().enumerate() {
            for look in 0..=20 {
                let [_, velocity, acceleration] = executed(ends, column, f64::from(look) / 20.0);
                let parts = [
                    own.velocity.part(velocity),
                    own.acceleration.part(acceleration),
                ];
                assert!(
                    parts.iter().all(|part| *part <= 1.0 + 1e-6),
                    "{velocity}, {acceleration} at {} ns",
                    ends[0].time_ns
                );
            }
        }
    }
    assert!(timed.duration_s() >= timed.bound.time_s - 1e-9);
}

/// The least distance of the ball from boxes wherever one looks (m).
pub(super) fn least_distance(timed: &Timed, walls: &[(Vec3, Vec3)]) -> f64 {
    let mut least = f64::INFINITY;
    for ends in timed.points.windows(2) {
        for look in 0..=50 {
            let u = f64::from(look) / 50.0;
            let [x, y] = [0, 1].map(|column| executed(ends, column, u)[0]);
            for (at, half) in walls {
                let outside = [(x - at.x).abs() - half.x, (y - at.y).abs() - half.y];
                let [dx, dy] = outside.map(|side| side.max(0.0));
                let inside = outside[0].max(outside[1]).min(0.0);
                least = least.min(dx.hypot(dy) + inside - 0.05);
            }
        }
    }
    least
}

/// A wall in the inside of the corner.
pub(super) const BESIDE: (Vec3, Vec3) = (Vec3::new(0.4, 0.8, 0.0), Vec3::new(0.5, 0.5, 1.0));
/// Two ways around a corner of a wall.
pub(super) const AROUND: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.2], [1.2, 1.2]];

#[test]
fn each_stage_is_proved_and_faster_than_the_one_before() {
    let model = testing::slider(&[BESIDE]);
    let limits = alike(2, 1.0, 2.0);
    let (best, published) = timed(&model, &AROUND, &settings(limits.clone())).unwrap();
    let stages: Vec<&str> = published
        .iter()
        .map(|timed| timed.stage.name())
        .collect();
    assert_eq!(stages, ["stops", "rounded", "shortcuts"]);
    for pair in published.windows(2) {
        assert!(pair[1].duration_ns() < pair[0].duration_ns());
    }
    for timed in &published {
        check(timed, &AROUND, &limits);
        assert!(timed.proof.as_ref().unwrap().clearance_m() >= FLOOR_M);
        assert!(least_distance(timed, &[BESIDE]) >= FLOOR_M);
    }
    assert_eq!(published.last(), Some(&best));
    println!(
        "{:?}, bound {}",
        published
            .iter()
            .map(|timed| timed.duration_s())
            .collect::<Vec<_>>(),
        best.bound.time_s
    );
}

#[test]
fn in_an_empty_room_the_bound_is_reached() {
    let model = testing::slider(&[]);
    let limits = alike(2, 1.0, 2.0);
    let (best, _) = timed(&model, &AROUND, &settings(limits.clone())).unwrap();
    check(&best, &AROUND, &limits);
    let excess = best.duration_s() / best.bound.time_s - 1.0;
    assert!((0.0..1e-3).contains(&excess), "{excess}");
    assert!(
        (best.bound.time_s - 1.7).abs() < 1e-12,
        "{}",
        best.bound.time_s
    );
}

#[test]
fn the_same_request_has_the_same_answer() {
    let model = testing::slider(&[BESIDE]);
    let once = || timed(&model, &AROUND, &settings(alike(2, 1.0, 2.0))).unwrap();
    assert_eq!(once(), once());
}

/// What other timers make no trajectory of, or a wrong one.
#[test]
fn odd_paths_are_timed_all_the_same() {
    let model = testing::slider(&[]);
    let limits = alike(2, 1.0, 2.0);
    let duration = |rows: &[[f64; 2]]| {
        let (best, published) = timed(&model, rows, &settings(limits.clone())).unwrap();
        published
            .iter()
            .for_each(|timed| check(timed, rows, &limits));
        best.duration_s()
    };
    let near = |duration: f64, expected: f64| {
        assert!(
            (duration - expected).abs() < 2e-3,
            "{duration} is not {expected}"
        )
    };
    // Duplicates, and segments of next to nothing.
    near(
        duration(&[[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [1.0, 0.0]]),
        1.5,
    );
    near(duration(&[[0.0, 0.0], [1e-10, 0.0], [1.0, 0.0]]), 1.5);
    near(
        duration(&[[0.0, 0.0], [0.5, 0.0], [0.5 + 1e-6, 0.0], [1.0, 0.0]]),
        1.5,
    );
    near(duration(&[[0.0, 0.0], [1e-6, 0.0], [1.0, 0.0]]), 1.5);
    near(duration(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1e-10]]), 1.5);
    // There and back again: it need not come all the way.
    near(
        duration(&[[0.0, 0.0], [1.0, 0.0], [0.2, 0.0]]),
        (0.2_f64 / 2.0).sqrt() * 2.0,
    );
    // Nothing to do.
    let (still, published) =
        timed(&model, &[[0.3, 0.1], [0.3, 0.1]], &settings(limits.clone())).unwrap();
    assert_eq!(
        (still.duration_ns(), still.points.len(), published.len()),
        (0, 1, 0)
    );
}

#[test]
fn limits_that_leave_no_way_to_move_are_named() {
    let model = testing::slider(&[]);
    let refusal = |limits: Limits, rows: &[[f64; 2]]| {
        timed(&model, rows, &settings(limits))
            .unwrap_err()
            .to_string()
    };
    let moving = [[0.0, 0.0], [1.0, 0.0]];
    assert_eq!(
        refusal(alike(2, 0.0, 1.0), &moving),
        "joint0 moves, but its velocity limits are [-0, 0]; each must be a number, the first below 0 and the second above"
    );
    assert_eq!(
        refusal(alike(2, 1.0, 0.0), &moving),
        "joint0 moves, but its acceleration limits are [-0, 0]; each must be a number, the first below 0 and the second above"
    );
    assert!(
        refusal(alike(2, 1.0, f64::INFINITY), &moving)
            .starts_with("joint0 moves, but its acceleration limits")
    );
    assert_eq!(
        refusal(alike(3, 1.0, 1.0), &moving),
        "limits of 3 columns given; the robot has 2"
    );
    // What stands still needs none.
    let mut columns = alike(2, 1.0, 2.0).columns().to_vec();
    columns[1] = ColumnLimits {
        velocity: Range::symmetric(0.0),
        acceleration: Range::symmetric(0.0),
    };
    let limits = Limits::new(columns);
    let (best, _) = timed(&model, &moving, &settings(limits)).unwrap();
    assert!((best.duration_s() - 1.5).abs() < 1e-3);
}

#[test]
fn two_sided_limits_count_in_their_direction() {
    let model = testing::slider(&[]);
    let own = ColumnLimits {
        velocity: Range {
            least: -0.5,
            most: 1.0,
        },
        acceleration: Range {
            least: -4.0,
            most: 1.0,
        },
    };
    let limits = Limits::new(vec![own; 2]);
    for rows in [
        [[0.0, 0.0], [0.6, 0.1], [1.0, 0.0]],
        [[1.0, 0.0], [0.6, 0.1], [0.0, 0.3]],
    ] {
        let (best, published) = timed(&model, &rows, &settings(limits.clone())).unwrap();
        published
            .iter()
            .for_each(|timed| check(timed, &rows, &limits));
        assert!(best.duration_s() < 1.02 * best.bound.time_s, "{best:?}");
    }
}

#[test]
fn a_wall_in_the_way_of_a_path_is_found() {
    let model = testing::slider(&[(Vec3::new(0.5, 0.1, 0.0), Vec3::new(0.01, 0.1, 1.0))]);
    let refused = timed(&model, &AROUND, &settings(alike(2, 1.0, 2.0)));
    assert!(
        matches!(refused, Err(TimingError::Refused(_))),
        "{refused:?}"
    );
}

#[test]
fn a_stop_leaves_what_is_proved() {
    let model = testing::slider(&[BESIDE]);
    let path = Path::from_rows(2, AROUND.concat()).unwrap();
    let space = model.robot().space().unwrapped();
    let limits = alike(2, 1.0, 2.0);
    for asked in [0, 1, 3, 10, 30, 100] {
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, &space, &[], FLOOR_M, &mut scratch).closely();
        let mut left = asked;
        let mut stop = || {
            left -= i32::from(left > 0);
            left == 0
        };
        let mut published = Vec::new();
        let mut publish = |timed: &Timed| published.push(timed.clone());
        let outcome = run(
            model.robot(),
            &mut validator,
            &path,
            &settings(limits.clone()),
            &mut stop,
            &mut publish,
        )
        .unwrap();
        match outcome {
            Outcome::Stopped => assert!(published.is_empty()),
            Outcome::Timed(timed) => {
                check(&timed, &AROUND, &limits);
                assert_eq!(published.last(), Some(&timed));
            }
        }
    }
}

/// Random stretches that are smooth where they meet, of some columns.
fn random_stretches(rng: &mut Rng, columns: usize, limits: &Limits) -> Vec<Stretch> {
    let mut row = || -> Vec<f64> {
        (0..columns)
            .map(|_| testing::uniform(rng, -1.0, 1.0))
            .collect()
    };
    let rows: Vec<f64> = (0..5).flat_map(|_| row()).collect();
    let path = Path::from_rows(columns, rows).unwrap();
    let mut corners = Corners::new(distinct(&path, &Fixed::Ends, limits), limits);
    for waypoint in corners.inner() {
        let room = corners.room(waypoint);
        corners.round(waypoint, room * [1.0, 0.5, 0.0][rng.usize(0..3)]);
    }
    corners.stretches()
}

/// The passes are as fast as the convex program on the same places (Verscheure et al., 2009).
#[test]
fn the_passes_are_as_fast_as_the_convex_program() {
    let mut rng = Rng::with_seed(5);
    for _ in 0..12 {
        let columns = rng.usize(1..5);
        let limits = Limits::new(
            (0..columns)
                .map(|_| ColumnLimits {
                    velocity: Range {
                        least: -testing::uniform(&mut rng, 0.5, 2.0),
                        most: testing::uniform(&mut rng, 0.5, 2.0),
                    },
                    acceleration: Range {
                        least: -testing::uniform(&mut rng, 0.5, 4.0),
                        most: testing::uniform(&mut rng, 0.5, 4.0),
                    },
                })
                .collect(),
        );
        let stretches = random_stretches(&mut rng, columns, &limits);
        let places = fastest(&stretches, &limits);
        let own = oracle::duration(&stretches, &places);
        let least = oracle::least(&stretches, &places, &limits);
        assert!(
            own <= least * (1.0 + 1e-3),
            "{own} where {least} is possible"
        );
        assert!(own >= least * (1.0 - 1e-3), "{own} is less than {least}");
    }
}

#[test]
fn ramps_reach_their_ends_within_limits_and_in_about_the_least_time() {
    let (count, mut rng) = cases(2_000);
    let mut found = 0;
    let mut at_least = 0;
    for _ in 0..count {
        let columns = rng.usize(1..4);
        let own = two_sided(&mut rng);
        let limits = Limits::new(vec![own; columns]);
        let mut state = || State {
            positions: (0..columns)
                .map(|_| testing::uniform(&mut rng, -1.0, 1.0))
                .collect(),
            velocities: (0..columns)
                .map(|_| testing::uniform(&mut rng, own.velocity.least, own.velocity.most))
                .collect(),
        };
        let ends = [state(), state()];
        let phasing = [Phasing::Common, Phasing::Own][rng.usize(0..2)];
        let motors = Motors {
            limits: &limits,
            tick_ns: 100_000,
        };
        let Some(states) = motors.ramps([&ends[0], &ends[1]], phasing, 0, i64::MAX) else {
            continue;
        };
        found += 1;
        assert_eq!(states[0].state, ends[0]);
        assert_eq!(states[states.len() - 1].state, ends[1]);
        let points: Vec<proof::Point> = states
            .iter()
            .map(|known| TimedPoint::of_state(known).point())
            .collect();
        let curve = Curve::of_lines(columns, &points).unwrap();
        let usage = limits.usage(&curve);
        assert!(usage.stretch() <= 1.0 + 1e-7, "{usage:?}");
        let least_s = (0..columns)
            .map(|column| {
                let ends = ramp::Ends {
                    way: ends[1].positions[column] - ends[0].positions[column],
                    velocities: [0, 1].map(|end| ends[end].velocities[column]),
                };
                ends.least_s(&own)
            })
            .fold(0.0, f64::max);
        let excess = curve.total_s() - least_s;
        assert!(excess >= -1e-9, "{excess}");
        at_least += usize::from(excess < 1e-3);
    }
    println!("{found} of {count} found, {at_least} in the least time");
    assert!(
        found * 10 > count * 7 && at_least * 2 > found,
        "{found}, {at_least}"
    );
}

/// The least time of one column against the program of a second order system in small steps.
#[test]
fn no_column_is_faster_than_the_least_time() {
    let mut rng = Rng::with_seed(9);
    for _ in 0..40 {
        let own = two_sided(&mut rng);
        let ends = ramp::Ends {
            way: testing::uniform(&mut rng, -1.0, 1.0),
            velocities: [0, 1]
                .map(|_| testing::uniform(&mut rng, own.velocity.least, own.velocity.most)),
        };
        let least_s = ends.least_s(&own);
        assert!(
            oracle::column_can(&ends, &own, least_s * (1.0 + 1e-6), 1e-3),
            "{ends:?} {own:?} {least_s}"
        );
        assert!(
            !oracle::column_can(&ends, &own, 0.97 * least_s, 0.0),
            "{ends:?} {own:?} {least_s}"
        );
    }
}

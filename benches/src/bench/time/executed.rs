//! What a controller makes of a trajectory, by the formulas of ros2_control's `trajectory.cpp`
//! (`interpolate_between_points`, joint_trajectory_controller), written down anew: nothing of taut's proof
//! or of its curves is used.

use taut::timing::{Limits, TimedPoint};

/// Looks along each piece, besides those where a velocity turns.
const LOOKS: u32 = 32;

/// What is seen of the executed curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Executed {
    /// The largest part of a velocity limit, ...
    pub velocity: f64,
    /// ... and of an acceleration limit.
    pub acceleration: f64,
    /// How far positions are outside of their limits (m or rad); 0 where they are inside.
    pub outside: f64,
}

/// A polynomial of the time since a point, from the constant term on.
type Coefficients = [f64; 6];

/// Looks at a trajectory whose columns have these limits of position.
pub(super) fn executed(points: &[TimedPoint], limits: &Limits, positions: &[[f64; 2]]) -> Executed {
    let mut seen = Executed::default();
    for ends in points.windows(2) {
        let duration = (ends[1].time_ns - ends[0].time_ns) as f64 / 1e9;
        for (column, own) in limits.columns().iter().enumerate() {
            let c = coefficients([&ends[0], &ends[1]], column, duration);
            for t in places(&c, duration) {
                let [at, velocity, acceleration] = state(&c, t);
                let [least, most] = positions[column];
                seen.velocity = seen.velocity.max(own.velocity.part(velocity));
                let part = own.acceleration.part(acceleration);
                seen.acceleration = seen.acceleration.max(part);
                seen.outside = seen.outside.max(least - at).max(at - most);
            }
        }
    }
    seen
}

/// Whether a trajectory starts and ends at these positions, to the last bit, at rest.
pub(super) fn is_at_rest_at(points: &[TimedPoint], ends: [&[f64]; 2]) -> bool {
    let both = points.first().zip(points.last());
    both.is_some_and(|(first, last)| {
        [first, last]
            .into_iter()
            .zip(ends)
            .all(|(point, end)| {
                point.positions == end && point.velocities.iter().all(|v| *v == 0.0)
            })
    })
}

fn coefficients([a, b]: [&TimedPoint; 2], column: usize, duration: f64) -> Coefficients {
    let t: [f64; 6] = std::array::from_fn(|power| duration.powi(power as i32));
    let [p0, p1] = [a, b].map(|point| point.positions[column]);
    let has_velocity = !a.velocities.is_empty() && !b.velocities.is_empty();
    let has_acceleration = !a.accelerations.is_empty() && !b.accelerations.is_empty();
    if !has_velocity {
        return [p0, (p1 - p0) / t[1], 0.0, 0.0, 0.0, 0.0];
    }
    let [v0, v1] = [a, b].map(|point| point.velocities[column]);
    if !has_acceleration {
        let square = (-3.0 * p0 + 3.0 * p1 - 2.0 * v0 * t[1] - v1 * t[1]) / t[2];
        let cube = (2.0 * p0 - 2.0 * p1 + v0 * t[1] + v1 * t[1]) / t[3];
        return [p0, v0, square, cube, 0.0, 0.0];
    }
    let [a0, a1] = [a, b].map(|point| point.accelerations[column]);
    let third =
        -20.0 * p0 + 20.0 * p1 - 3.0 * a0 * t[2] + a1 * t[2] - 12.0 * v0 * t[1] - 8.0 * v1 * t[1];
    let fourth = 30.0 * p0 - 30.0 * p1 + 3.0 * a0 * t[2] - 2.0 * a1 * t[2]
        + 16.0 * v0 * t[1]
        + 14.0 * v1 * t[1];
    let fifth = -12.0 * p0 + 12.0 * p1 - a0 * t[2] + a1 * t[2] - 6.0 * v0 * t[1] - 6.0 * v1 * t[1];
    [
        p0,
        v0,
        0.5 * a0,
        third / (2.0 * t[3]),
        fourth / (2.0 * t[4]),
        fifth / (2.0 * t[5]),
    ]
}

/// Position, velocity and acceleration.
fn state(c: &Coefficients, t: f64) -> [f64; 3] {
    let p: [f64; 6] = std::array::from_fn(|power| t.powi(power as i32));
    [
        c[0] + c[1] * p[1] + c[2] * p[2] + c[3] * p[3] + c[4] * p[4] + c[5] * p[5],
        c[1] + 2.0 * c[2] * p[1] + 3.0 * c[3] * p[2] + 4.0 * c[4] * p[3] + 5.0 * c[5] * p[4],
        2.0 * c[2] + 6.0 * c[3] * p[1] + 12.0 * c[4] * p[2] + 20.0 * c[5] * p[3],
    ]
}

/// Where to look: evenly, and where the velocity turns between two such places.
fn places(c: &Coefficients, duration: f64) -> Vec<f64> {
    let even = |look: u32| duration * f64::from(look) / f64::from(LOOKS);
    let mut places: Vec<f64> = (0..=LOOKS).map(even).collect();
    for look in 0..LOOKS {
        let mut between = [even(look), even(look + 1)];
        let bends = |t: f64| state(c, t)[2] > 0.0;
        if bends(between[0]) == bends(between[1]) {
            continue;
        }
        for _ in 0..50 {
            let middle = 0.5 * (between[0] + between[1]);
            let half = usize::from(bends(middle) != bends(between[0]));
            between[half] = middle;
        }
        places.push(between[0]);
    }
    places
}

#[cfg(test)]
mod tests {
    use taut::timing::{ColumnLimits, Range};

    use super::*;

    fn point(time_ns: i64, position: f64, velocity: f64) -> TimedPoint {
        TimedPoint {
            time_ns,
            positions: vec![position],
            velocities: vec![velocity],
            accelerations: Vec::new(),
        }
    }

    fn limits(velocity: f64, acceleration: f64) -> Limits {
        Limits::new(vec![ColumnLimits {
            velocity: Range::symmetric(velocity),
            acceleration: Range::symmetric(acceleration),
        }])
    }

    #[test]
    fn a_cubic_from_rest_to_rest_is_fastest_in_its_middle() {
        // 3 t² − 2 t³: velocity 1.5 at ½, acceleration 6 at both ends.
        let points = [point(0, 0.0, 0.0), point(1_000_000_000, 1.0, 0.0)];
        let seen = executed(&points, &limits(1.5, 3.0), &[[0.0, 0.9]]);
        assert!((seen.velocity - 1.0).abs() < 1e-12, "{seen:?}");
        assert!((seen.acceleration - 2.0).abs() < 1e-12, "{seen:?}");
        assert!((seen.outside - 0.1).abs() < 1e-12, "{seen:?}");
        assert!(is_at_rest_at(&points, [&[0.0], &[1.0]]));
        assert!(!is_at_rest_at(&points, [&[0.0], &[1.0 + 1e-15]]));
        assert!(!is_at_rest_at(
            &[points[0].clone(), point(1, 1.0, 1e-9)],
            [&[0.0], &[1.0]]
        ));
    }

    #[test]
    fn a_quintic_has_the_accelerations_of_its_ends() {
        let mut points = [point(0, 0.0, 0.0), point(2_000_000_000, 1.0, 0.0)];
        points[0].accelerations = vec![0.0];
        points[1].accelerations = vec![0.0];
        // 10 u³ − 15 u⁴ + 6 u⁵: at most 15/8 a unit, 10/√3 a unit squared.
        let seen = executed(&points, &limits(1.0, 1.0), &[[-1.0, 2.0]]);
        assert!((seen.velocity - 15.0 / 16.0).abs() < 1e-12, "{seen:?}");
        let most = 10.0 / 3.0_f64.sqrt() / 4.0;
        assert!((seen.acceleration - most).abs() < 5e-3 * most, "{seen:?}");
        assert_eq!(seen.outside, 0.0);
    }
}

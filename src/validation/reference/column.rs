//! A column between two points of a trajectory, by its control points (Bernstein's form).
//!
//! With u = 0 at one point and u = 1 at the next, Σ b_i B_i(u) never leaves the least and the greatest
//! of its control points b_i, and its derivative is the polynomial whose control points are their
//! differences, times its degree. De Casteljau's halving gives the control points of a part of it,
//! which are the nearer to the curve the shorter the part. No roots are looked for.

use crate::validation::Interpolation;
use crate::validation::timed::Point;

/// Halvings after which a part says no more than its ends.
const DEEPEST: u32 = 40;

/// One column on a piece of a trajectory, by the ratio on it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column(Vec<f64>);

impl Column {
    /// What stands still.
    pub(super) fn standing(value: f64) -> Self {
        Self(vec![value])
    }

    /// A column between two points, so many seconds apart, by Hermite's conditions at both.
    pub(super) fn between(
        interpolation: Interpolation,
        [a, b]: [&Point; 2],
        column: usize,
        duration_s: f64,
    ) -> Self {
        let [p, q] = [a, b].map(|point| point.positions[column]);
        let ways = || [a, b].map(|point| duration_s * point.velocities[column]);
        Self(match interpolation {
            Interpolation::Linear => vec![p, q],
            Interpolation::Cubic => {
                let [v, w] = ways();
                vec![p, p + v / 3.0, q - w / 3.0, q]
            }
            Interpolation::Quintic => {
                let [v, w] = ways();
                let bends = [a, b].map(|point| duration_s.powi(2) * point.accelerations[column]);
                let inner = [p + 0.4 * v + bends[0] / 20.0, q - 0.4 * w + bends[1] / 20.0];
                vec![p, p + v / 5.0, inner[0], inner[1], q - w / 5.0, q]
            }
        })
    }

    /// Its value at a ratio.
    pub(super) fn at(&self, ratio: f64) -> f64 {
        let mut points = self.0.clone();
        for last in (1..points.len()).rev() {
            for first in 0..last {
                points[first] = (1.0 - ratio) * points[first] + ratio * points[first + 1];
            }
        }
        points[0]
    }

    /// What is before a ratio and what is after it, each by a ratio of its own.
    fn cut(&self, ratio: f64) -> [Self; 2] {
        let mut points = self.0.clone();
        let mut before = Vec::with_capacity(points.len());
        let mut after = Vec::with_capacity(points.len());
        while let (Some(first), Some(last)) = (points.first(), points.last()) {
            before.push(*first);
            after.push(*last);
            points = points
                .windows(2)
                .map(|two| (1.0 - ratio) * two[0] + ratio * two[1])
                .collect();
        }
        after.reverse();
        [Self(before), Self(after)]
    }

    /// What is between two ratios, which are not both 0.
    pub(super) fn part(&self, [from, to]: [f64; 2]) -> Self {
        let [before, _] = self.cut(to);
        let [_, part] = before.cut(from / to);
        part
    }

    /// Its derivative by the ratio.
    pub(super) fn derivative(&self) -> Self {
        let degree = self.0.len() - 1;
        let steps = self.0.windows(2);
        let derivative: Vec<f64> = steps
            .map(|two| degree as f64 * (two[1] - two[0]))
            .collect();
        match derivative.is_empty() {
            true => Self::standing(0.0),
            false => Self(derivative),
        }
    }

    /// No |value| is greater.
    pub(super) fn size(&self) -> f64 {
        let sizes = self.0.iter().map(|point| point.abs());
        sizes.fold(0.0, f64::max)
    }

    /// A place where it is outside of a range, and its value there.
    pub(super) fn outside(&self, range: [f64; 2]) -> Option<(f64, f64)> {
        self.outside_part([0.0, 1.0], range, 0)
    }

    fn outside_part(
        &self,
        [from, to]: [f64; 2],
        range: [f64; 2],
        depth: u32,
    ) -> Option<(f64, f64)> {
        let is_outside = |value: &f64| !(range[0]..=range[1]).contains(value);
        let ends = [(from, self.0[0]), (to, self.0[self.0.len() - 1])];
        let found = ends
            .into_iter()
            .find(|(_, value)| is_outside(value));
        if found.is_some() || depth == DEEPEST || !self.0.iter().any(is_outside) {
            return found;
        }
        let middle = 0.5 * (from + to);
        let [before, after] = self.cut(0.5);
        before
            .outside_part([from, middle], range, depth + 1)
            .or_else(|| after.outside_part([middle, to], range, depth + 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use crate::validation::polynomial::{Knot, Polynomial};

    fn point(rng: &mut fastrand::Rng) -> Point {
        let mut number = || vec![testing::uniform(rng, -2.0, 2.0)];
        Point {
            time_s: 0.0,
            positions: number(),
            velocities: number(),
            accelerations: number(),
        }
    }

    fn knot(point: &Point) -> Knot {
        Knot {
            position: point.positions[0],
            velocity: point.velocities[0],
            acceleration: point.accelerations[0],
        }
    }

    #[test]
    fn it_is_the_polynomial_of_the_proof() {
        let mut rng = fastrand::Rng::with_seed(4);
        for _ in 0..300 {
            let ends = [point(&mut rng), point(&mut rng)];
            let duration_s = testing::uniform(&mut rng, 0.1, 2.0);
            for (interpolation, make) in [
                (
                    Interpolation::Linear,
                    Polynomial::linear as fn(Knot, Knot, f64) -> Polynomial,
                ),
                (Interpolation::Cubic, Polynomial::cubic),
                (Interpolation::Quintic, Polynomial::quintic),
            ] {
                let own = Column::between(interpolation, [&ends[0], &ends[1]], 0, duration_s);
                let other = make(knot(&ends[0]), knot(&ends[1]), duration_s);
                let speeds = own.derivative();
                let from = 0.7 * rng.f64();
                let part = speeds.part([from, from + 0.2]);
                for look in 0..=20 {
                    let ratio = f64::from(look) / 20.0;
                    let at = other.at(ratio * duration_s);
                    assert!((own.at(ratio) - at).abs() < 1e-11, "{at}");
                    let speed = duration_s
                        * other
                            .derivative()
                            .at((from + 0.2 * ratio) * duration_s);
                    assert!((part.at(ratio) - speed).abs() < 1e-10, "{speed}");
                    assert!(speed.abs() <= part.size() + 1e-10, "{speed}");
                }
            }
        }
    }

    #[test]
    fn it_is_outside_of_a_range_where_its_extremes_are() {
        let mut rng = fastrand::Rng::with_seed(6);
        for _ in 0..300 {
            let ends = [point(&mut rng), point(&mut rng)];
            let own = Column::between(Interpolation::Quintic, [&ends[0], &ends[1]], 0, 1.3);
            let other = Polynomial::quintic(knot(&ends[0]), knot(&ends[1]), 1.3);
            let [(least, _), (most, _)] = other.extremes(0.0, 1.3);
            assert_eq!(own.outside([least - 1e-9, most + 1e-9]), None);
            let (ratio, value) = own
                .outside([least - 1e-9, most - 1e-6])
                .unwrap();
            assert!(
                value > most - 1e-6 && (value - other.at(1.3 * ratio)).abs() < 1e-10,
                "{value}"
            );
        }
    }
}

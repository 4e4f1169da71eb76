//! Clouds with a point for each cell of a grid. What that leaves out is paid for: the points that
//! stay become so much thicker that each point left out is still inside.

use std::collections::HashMap;

use crate::math::Vec3;

/// A cloud with fewer points.
#[derive(Clone, Debug, PartialEq)]
pub struct Thinned {
    /// A point for each cell that held one: the middle of those it stands for.
    pub points: Vec<Vec3>,
    /// Greatest distance (m) from a point to the one that stands for it: balls have to grow by it.
    /// At most half the diagonal of a cell.
    pub growth: f64,
}

/// A cell, by the bits of its place: no number of cells is too large.
type Key = [u64; 3];

impl Thinned {
    /// Thins points by a grid of cells with this edge (m).
    ///
    /// # Errors
    /// An edge that is none.
    pub fn of(points: &[Vec3], edge: f64) -> Result<Self, String> {
        if !(edge.is_finite() && edge > 0.0) {
            return Err(format!(
                "thin is {edge}; it must be finite and greater than 0: the edge of a cell (metres)"
            ));
        }
        let mut cells: HashMap<Key, usize> = HashMap::new();
        let mut boxes: Vec<(Vec3, Vec3)> = Vec::new();
        let mut of_points = Vec::with_capacity(points.len());
        for point in points {
            let cell = *cells
                .entry(key(*point, edge))
                .or_insert(boxes.len());
            match boxes.get_mut(cell) {
                Some((low, high)) => (*low, *high) = (low.min(*point), high.max(*point)),
                None => boxes.push((*point, *point)),
            }
            of_points.push(cell);
        }
        let middles: Vec<Vec3> = boxes
            .iter()
            .map(|(low, high)| *low + (*high - *low) / 2.0)
            .collect();
        let distances = points
            .iter()
            .zip(&of_points)
            .map(|(point, cell)| point.distance(middles[*cell]));
        Ok(Self {
            growth: upwards(distances.fold(0.0, f64::max)),
            points: middles,
        })
    }
}

/// The cell of a point. Where cells are finer than numbers, each number has its own.
fn key(point: Vec3, edge: f64) -> Key {
    let cell = |coordinate: f64| match (coordinate / edge).floor() {
        0.0 => 0,
        cell if cell.is_finite() => cell.to_bits(),
        _ => coordinate.to_bits(),
    };
    point.to_array().map(cell)
}

/// A distance with its rounding paid for.
fn upwards(distance: f64) -> f64 {
    distance * (1.0 + 8.0 * f64::EPSILON)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(offset: f64) -> Vec<Vec3> {
        let mut random = fastrand::Rng::with_seed(3);
        let mut number = || offset + random.f64() - 0.5;
        (0..3000)
            .map(|_| Vec3::new(number(), number(), 0.001 * number()))
            .collect()
    }

    #[test]
    fn every_point_lies_in_a_ball_of_one_that_stays() {
        for offset in [0.0, 1e6] {
            let points = cloud(offset);
            let thinned = Thinned::of(&points, 0.05).unwrap();
            assert!(
                thinned.points.len() <= 21 * 21 * 2,
                "{}",
                thinned.points.len()
            );
            assert!(thinned.growth <= 0.05 * 0.75f64.sqrt() * 1.001);
            let is_inside = |point: &Vec3| {
                let mut kept = thinned.points.iter();
                kept.any(|kept| kept.distance(*point) <= thinned.growth)
            };
            assert!(points.iter().all(is_inside));
        }
    }

    #[test]
    fn points_apart_stay_as_they_are() {
        let points = [Vec3::X, -Vec3::X, Vec3::splat(1e300)];
        let thinned = Thinned::of(&points, 0.5).unwrap();
        assert_eq!(thinned.points, points);
        assert_eq!(thinned.growth, 0.0);
        assert!(
            Thinned::of(&points, 0.0)
                .unwrap_err()
                .contains("thin is 0; it must be finite")
        );
    }
}

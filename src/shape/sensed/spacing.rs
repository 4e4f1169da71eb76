//! How far apart the points of a cloud lie: what lies between them is not seen.

use crate::math::Vec3;

/// Points whose nearest neighbour is looked for: more would say the same.
const ASKED: usize = 4096;
/// Points of a part that is not divided further.
const PART: usize = 8;

/// Distances from points to their nearest other ones (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spacing {
    /// Half of the points have one that is nearer.
    pub median: f64,
    /// 95 of 100 have.
    pub most: f64,
}

impl Spacing {
    /// The spacing of points, of many that of some, evenly chosen. None where fewer than two are in
    /// different places.
    pub fn of(points: &[Vec3]) -> Option<Self> {
        let tree = Tree::of(points);
        let step = points.len().div_ceil(ASKED).max(1);
        let asked = points.iter().step_by(step);
        let mut found: Vec<f64> = asked
            .map(|point| tree.nearest(*point).sqrt())
            .filter(|distance| distance.is_finite())
            .collect();
        found.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| found.get((share * (found.len() as f64 - 1.0)).round() as usize);
        Some(Self {
            median: *at(0.5)?,
            most: *at(0.95)?,
        })
    }
}

/// A k-d tree: in the middle of a part stands the point that divides it along its widest axis.
struct Tree {
    points: Vec<Vec3>,
    /// The axis along which a point divides its part.
    axes: Vec<u8>,
}

impl Tree {
    fn of(points: &[Vec3]) -> Self {
        let mut tree = Self {
            points: points.to_vec(),
            axes: vec![0; points.len()],
        };
        divide(&mut tree.points, &mut tree.axes);
        tree
    }

    /// Square of the distance from a place to the nearest point that is not there; infinite where
    /// there is none.
    fn nearest(&self, from: Vec3) -> f64 {
        let mut search = Search {
            from,
            best: f64::INFINITY,
        };
        search.part(&self.points, &self.axes);
        search.best
    }
}

fn divide(points: &mut [Vec3], axes: &mut [u8]) {
    if points.len() <= PART {
        return;
    }
    let axis = widest(points);
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
    axes[middle] = axis as u8;
    divide(&mut points[..middle], &mut axes[..middle]);
    divide(&mut points[middle + 1..], &mut axes[middle + 1..]);
}

/// The axis along which points are farthest apart.
fn widest(points: &[Vec3]) -> usize {
    let low = points.iter().copied().reduce(Vec3::min);
    let high = points.iter().copied().reduce(Vec3::max);
    let size = high.unwrap_or_default() - low.unwrap_or_default();
    let wider = |a: &usize, b: &usize| size[*a].total_cmp(&size[*b]);
    (0..3).max_by(wider).unwrap_or_default()
}

struct Search {
    from: Vec3,
    /// Square of the least distance so far.
    best: f64,
}

impl Search {
    fn look(&mut self, point: Vec3) {
        let distance = point.distance_squared(self.from);
        if distance > 0.0 {
            self.best = self.best.min(distance);
        }
    }

    fn part(&mut self, points: &[Vec3], axes: &[u8]) {
        if points.len() <= PART {
            points
                .iter()
                .for_each(|point| self.look(*point));
            return;
        }
        let middle = points.len() / 2;
        let axis = usize::from(axes[middle]);
        let beyond = self.from[axis] - points[middle][axis];
        self.look(points[middle]);
        let low = (&points[..middle], &axes[..middle]);
        let high = (&points[middle + 1..], &axes[middle + 1..]);
        let (near, far) = if beyond < 0.0 {
            (low, high)
        } else {
            (high, low)
        };
        self.part(near.0, near.1);
        if beyond * beyond < self.best {
            self.part(far.0, far.1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spacing_is_that_of_all_pairs() {
        let mut random = fastrand::Rng::with_seed(5);
        let mut points: Vec<Vec3> = (0..700)
            .map(|_| Vec3::new(random.f64(), random.f64() * 0.01, random.f64()))
            .collect();
        points.extend_from_within(..50);
        let mut wanted: Vec<f64> = points
            .iter()
            .map(|a| {
                let others = points.iter().map(|b| a.distance(*b));
                others
                    .filter(|distance| *distance > 0.0)
                    .fold(f64::INFINITY, f64::min)
            })
            .collect();
        wanted.sort_unstable_by(f64::total_cmp);
        let spacing = Spacing::of(&points).unwrap();
        assert!((spacing.median - wanted[375]).abs() < 1e-12);
        assert!((spacing.most - wanted[712]).abs() < 1e-12);
    }

    #[test]
    fn one_place_has_no_spacing() {
        assert_eq!(Spacing::of(&[]), None);
        assert_eq!(Spacing::of(&[Vec3::X, Vec3::X]), None);
        assert_eq!(
            Spacing::of(&[Vec3::ZERO, Vec3::X])
                .unwrap()
                .median,
            1.0
        );
    }
}

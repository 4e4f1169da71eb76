//! From the world to a plane of the picture: outlines of solids, and the frame that holds them.

use taut::math::{Pose, Vec3};
use taut::shape::PlacedShape;
use taut::solid::piece::Piece;

use crate::cli::svg::Point;

/// Directions that an outline is looked at from: enough for a round circle.
const DIRECTIONS: usize = 72;

/// A direction to look in.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// What goes to the right.
    right: Vec3,
    /// What goes up.
    up: Vec3,
    /// How it is called.
    pub(super) caption: &'static str,
}

impl View {
    /// x to the right, y up.
    pub(super) const TOP: Self = Self {
        right: Vec3::X,
        up: Vec3::Y,
        caption: "from above (x, y)",
    };
    /// x to the right, z up.
    pub(super) const SIDE: Self = Self {
        right: Vec3::X,
        up: Vec3::Z,
        caption: "from the side (x, z)",
    };

    /// Where a point of the world is seen [m].
    pub(super) fn point(&self, point: Vec3) -> Point {
        [self.right.dot(point), self.up.dot(point)]
    }

    /// Outline of a shape's convex hull: its farthest points in directions all around.
    pub(super) fn outline(&self, at: &Pose, placed: &PlacedShape) -> Vec<Point> {
        let shape = placed.shape.clone();
        let pose = *at * placed.pose;
        let mut pieces = Vec::new();
        Piece::append_of(&PlacedShape { pose, shape }, &mut pieces);
        let directions = (0..DIRECTIONS).map(|step| self.direction(step));
        directions
            .map(|direction| self.point(farthest(&pieces, direction)))
            .collect()
    }

    /// A direction of this plane. Half a step aside, so that a box that stands straight has no
    /// direction with two farthest corners.
    fn direction(&self, step: usize) -> Vec3 {
        let angle = (step as f64 + 0.5) / DIRECTIONS as f64 * std::f64::consts::TAU;
        self.right * angle.cos() + self.up * angle.sin()
    }
}

/// The farthest point of a shape's pieces in a direction.
fn farthest(pieces: &[Piece], direction: Vec3) -> Vec3 {
    let points = pieces
        .iter()
        .map(|piece| piece.core.support(direction) + direction * piece.radius);
    points
        .max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)))
        .unwrap_or(Vec3::ZERO)
}

/// A rectangle of the plane [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    low: Point,
    high: Point,
}

impl Bounds {
    /// Around points; `None` around none.
    pub(super) fn around(points: impl Iterator<Item = Point>) -> Option<Self> {
        points
            .map(|point| Self {
                low: point,
                high: point,
            })
            .reduce(Self::with)
    }

    /// Around both.
    fn with(self, other: Self) -> Self {
        Self {
            low: std::array::from_fn(|i| self.low[i].min(other.low[i])),
            high: std::array::from_fn(|i| self.high[i].max(other.high[i])),
        }
    }

    fn size(self) -> [f64; 2] {
        std::array::from_fn(|i| self.high[i] - self.low[i])
    }

    /// With room on all sides, as a part of its longer side.
    pub(super) fn widened(self, part: f64) -> Self {
        let [width, height] = self.size();
        let room = part * width.max(height);
        Self {
            low: self.low.map(|low| low - room),
            high: self.high.map(|high| high + room),
        }
    }

    /// Whether another one is all around it.
    fn is_inside(self, other: Self) -> bool {
        (0..2).all(|i| other.low[i] <= self.low[i] && self.high[i] <= other.high[i])
    }

    /// Whether the upright rectangle around an outline fills it, which then shows nothing.
    pub(super) fn is_filled_by(self, outline: &[Point]) -> bool {
        Self::around(outline.iter().copied()).is_some_and(|bounds| self.is_inside(bounds))
    }
}

/// A part of the world on a part of the picture, to scale and in its middle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    scale: f64,
    world: Point,
    middle: Point,
}

impl Frame {
    /// All of `bounds` within `width` × `height` pixels.
    pub(super) fn new(bounds: Bounds, width: f64, height: f64) -> Self {
        let fit = |pixels: f64, metres: f64| pixels / metres.max(1e-6);
        let [wide, high] = bounds.size();
        Self {
            scale: fit(width, wide).min(fit(height, high)),
            world: std::array::from_fn(|i| (bounds.low[i] + bounds.high[i]) / 2.0),
            middle: [width / 2.0, height / 2.0],
        }
    }

    /// Pixels of a place [m].
    pub(super) fn pixel(&self, [x, y]: Point) -> Point {
        let [wx, wy] = self.world;
        [
            self.middle[0] + (x - wx) * self.scale,
            self.middle[1] - (y - wy) * self.scale,
        ]
    }

    /// Pixels of places.
    pub(super) fn pixels(&self, points: &[Point]) -> Vec<Point> {
        points
            .iter()
            .map(|point| self.pixel(*point))
            .collect()
    }

    /// All that `width` × `height` pixels show.
    pub(super) fn shown(&self, width: f64, height: f64) -> Bounds {
        let [wx, wy] = self.world;
        let x = width / 2.0 / self.scale;
        let y = height / 2.0 / self.scale;
        Bounds {
            low: [wx - x, wy - y],
            high: [wx + x, wy + y],
        }
    }

    /// A round length of at most `pixels` pixels: metres, and pixels that it takes.
    pub(super) fn ruler(&self, pixels: f64) -> (f64, f64) {
        let most = pixels / self.scale;
        let decade = 10.0_f64.powf(most.log10().floor());
        let mut steps = [5.0, 2.0, 1.0]
            .into_iter()
            .map(|step| step * decade);
        let metres = steps
            .find(|metres| *metres <= most)
            .unwrap_or(decade);
        (metres, metres * self.scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use taut::shape::Shape;

    fn near(found: Option<Bounds>, low: Point, high: Point) -> bool {
        let found = found.unwrap();
        (0..2)
            .all(|i| (found.low[i] - low[i]).abs() < 2e-3 && (found.high[i] - high[i]).abs() < 2e-3)
    }

    #[test]
    fn outlines_reach_as_far_as_the_shapes() {
        let at = Pose::from_translation(Vec3::new(1.0, 2.0, 3.0));
        let sizes = [
            (Shape::sphere(0.5).unwrap(), [0.5, 0.5]),
            (Shape::cuboid(Vec3::new(1.0, 2.0, 3.0)).unwrap(), [0.5, 1.5]),
            (Shape::cylinder(2.0, 0.5).unwrap(), [0.5, 1.0]),
            (Shape::capsule(2.0, 0.5).unwrap(), [0.5, 1.5]),
        ];
        for (shape, [x, z]) in sizes {
            let placed = PlacedShape {
                pose: Pose::identity(),
                shape,
            };
            let bounds = Bounds::around(View::SIDE.outline(&at, &placed).into_iter());
            assert!(
                near(bounds, [1.0 - x, 3.0 - z], [1.0 + x, 3.0 + z]),
                "{placed:?}: {bounds:?}"
            );
        }
    }

    #[test]
    fn a_frame_is_to_scale_with_y_upwards() {
        let bounds = Bounds {
            low: [0.0, 0.0],
            high: [4.0, 1.0],
        };
        let frame = Frame::new(bounds, 200.0, 100.0);
        assert_eq!(frame.pixel([0.0, 0.0]), [0.0, 75.0]);
        assert_eq!(frame.pixel([4.0, 1.0]), [200.0, 25.0]);
        assert_eq!(frame.ruler(60.0), (1.0, 50.0));
        assert!(bounds.is_inside(frame.shown(200.0, 100.0)));
    }
}

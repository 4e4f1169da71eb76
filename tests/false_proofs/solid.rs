//! What a body is made of: convex parts, whose union it is.

use super::pose::{Pose, Vector, dot, length, sub};

/// A convex body in its own frame (m). Round ones are a core and a radius about it.
#[derive(Clone, Debug)]
pub enum Convex {
    Sphere {
        radius: f64,
    },
    /// Along z; `half` of its straight part.
    Capsule {
        half: f64,
        radius: f64,
    },
    /// Along z.
    Cylinder {
        half: f64,
        radius: f64,
    },
    /// The hull of points.
    Hull(Vec<Vector>),
}

impl Convex {
    pub fn cuboid(size: Vector) -> Self {
        let corner = |i: usize| {
            std::array::from_fn(|axis| if i >> axis & 1 == 0 { -0.5 } else { 0.5 } * size[axis])
        };
        Self::Hull((0..8).map(corner).collect())
    }

    /// Radius about the core.
    pub fn roundness(&self) -> f64 {
        match self {
            Self::Sphere { radius } | Self::Capsule { radius, .. } => *radius,
            Self::Cylinder { .. } | Self::Hull(_) => 0.0,
        }
    }

    /// The point of the core that lies farthest along a direction.
    pub fn farthest(&self, d: Vector) -> Vector {
        match self {
            Self::Sphere { .. } => [0.0; 3],
            Self::Capsule { half, .. } => [0.0, 0.0, half.copysign(d[2])],
            Self::Cylinder { half, radius } => {
                let across = d[0].hypot(d[1]);
                let by = if across > 0.0 { radius / across } else { 0.0 };
                [d[0] * by, d[1] * by, half.copysign(d[2])]
            }
            Self::Hull(points) => {
                let along = |p: &&Vector| dot(**p, d);
                *points
                    .iter()
                    .max_by(|a, b| along(a).total_cmp(&along(b)))
                    .expect("a hull has points")
            }
        }
    }
}

/// A convex part of a body, in the body's frame.
#[derive(Clone, Debug)]
pub struct Part {
    pub pose: Pose,
    pub shape: Convex,
    /// A ball around it: centre in the body's frame, radius.
    pub ball: (Vector, f64),
}

impl Part {
    pub fn new(pose: Pose, shape: Convex) -> Self {
        let (centre, radius) = match &shape {
            Convex::Sphere { radius } => ([0.0; 3], *radius),
            Convex::Capsule { half, radius } => ([0.0; 3], half + radius),
            Convex::Cylinder { half, radius } => ([0.0; 3], half.hypot(*radius)),
            Convex::Hull(points) => {
                let middle = middle(points);
                (
                    middle,
                    points
                        .iter()
                        .map(|p| length(sub(*p, middle)))
                        .fold(0.0, f64::max),
                )
            }
        };
        Self {
            pose,
            ball: (pose.point(centre), radius),
            shape,
        }
    }
}

pub fn middle(points: &[Vector]) -> Vector {
    let sum = points
        .iter()
        .fold([0.0; 3], |sum, p| super::pose::add(sum, *p));
    super::pose::scaled(sum, 1.0 / points.len() as f64)
}

/// A ball around all parts, in their frame.
pub fn ball_of(parts: &[Part]) -> (Vector, f64) {
    let centres: Vec<Vector> = parts.iter().map(|part| part.ball.0).collect();
    let centre = middle(&centres);
    let reach = |part: &Part| length(sub(part.ball.0, centre)) + part.ball.1;
    (centre, parts.iter().map(reach).fold(0.0, f64::max))
}

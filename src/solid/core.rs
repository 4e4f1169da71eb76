//! Convex cores, and all that is known of one by itself; a new kind of core is led here by the
//! compiler.

use serde::{Deserialize, Serialize};

use super::transform::Transform;
use crate::math::{Mat3, Vec3};

/// Points on the rim of a cylinder's lid.
const RIM: usize = 16;

/// Convex core in the frame of its body (m).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Core {
    /// A point.
    Point(Vec3),
    /// A segment.
    Segment(Vec3, Vec3),
    /// A triangle.
    Triangle(Vec3, Vec3, Vec3),
    /// A box: centre, axes (columns), half sizes.
    Box {
        /// Centre.
        center: Vec3,
        /// Unit axes, one a column.
        axes: Mat3,
        /// Half sizes along them.
        half: Vec3,
    },
    /// A cylinder with flat ends: centre, axes (columns, the third along it), half height, radius.
    Cylinder {
        /// Centre.
        center: Vec3,
        /// Unit axes, one a column.
        axes: Mat3,
        /// Half of the height.
        half_height: f64,
        /// Radius.
        radius: f64,
    },
}

/// The longest direction of a core.
#[derive(Clone, Copy, Debug)]
pub struct Length {
    /// Its middle (m).
    pub center: Vec3,
    /// The direction, a unit vector.
    pub along: Vec3,
    /// Half of its length along that (m).
    pub half: f64,
    /// Most distance of its points from the line through the middle (m).
    pub across: f64,
}

/// A box or cylinder around a core.
#[derive(Clone, Copy, Debug)]
pub struct Enclosure {
    /// Centre (m).
    pub center: Vec3,
    /// Unit axes, one a column; a cylinder's third is along it.
    pub axes: Mat3,
    /// Half sizes along them (m).
    pub half: Vec3,
    /// A cylinder, not a box.
    pub is_cylinder: bool,
}

impl Core {
    /// A point in its middle.
    pub fn center(&self) -> Vec3 {
        match *self {
            Self::Point(a) => a,
            Self::Segment(a, b) => (a + b) / 2.0,
            Self::Triangle(a, b, c) => (a + b + c) / 3.0,
            Self::Box { center, .. } | Self::Cylinder { center, .. } => center,
        }
    }

    /// Whether it is a part of a surface, which may hide something inside; every other core is a
    /// solid by itself.
    pub fn is_surface(&self) -> bool {
        self.triangle().is_some()
    }

    /// The corners of a box.
    pub fn box_corners(&self) -> Option<[Vec3; 8]> {
        let Self::Box { center, axes, half } = *self else {
            return None;
        };
        let signs =
            |corner: usize| [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 });
        Some(std::array::from_fn(|corner| {
            center + axes * (half * Vec3::from_array(signs(corner)))
        }))
    }

    /// The corners of a triangle.
    pub fn triangle(&self) -> Option<[Vec3; 3]> {
        match *self {
            Self::Triangle(a, b, c) => Some([a, b, c]),
            Self::Point(_) | Self::Segment(..) | Self::Box { .. } | Self::Cylinder { .. } => None,
        }
    }

    /// Whether [`Self::enclosure`] is the core itself.
    pub fn is_its_enclosure(&self) -> bool {
        match self {
            Self::Point(_) | Self::Segment(..) | Self::Box { .. } | Self::Cylinder { .. } => true,
            Self::Triangle(..) => false,
        }
    }

    /// The square of [`Self::farthest`] (m²): of a triangle it needs no root.
    pub fn farthest_squared(&self, from: Vec3) -> f64 {
        match self.triangle() {
            Some(corners) => corners
                .map(|corner| corner.distance_squared(from))
                .into_iter()
                .fold(0.0, f64::max),
            None => self.farthest(from).powi(2),
        }
    }

    /// Its longest direction, for cutting it across; a triangle has none.
    pub fn length(&self) -> Option<Length> {
        let (center, along, half, across) = match *self {
            Self::Point(a) => (a, Vec3::ZERO, 0.0, 0.0),
            Self::Segment(a, b) => {
                let along = (b - a).normalize_or_zero();
                ((a + b) / 2.0, along, a.distance(b) / 2.0, 0.0)
            }
            Self::Box { center, axes, half } => {
                let long = (0..3)
                    .max_by(|&i, &j| half[i].total_cmp(&half[j]))
                    .unwrap_or(0);
                let across = half.length_squared() - half[long] * half[long];
                (center, axes.col(long), half[long], across.max(0.0).sqrt())
            }
            Self::Cylinder {
                center,
                axes,
                half_height,
                radius,
            } => (center, axes.z_axis, half_height, radius),
            Self::Triangle(..) => return None,
        };
        Some(Length {
            center,
            along,
            half,
            across,
        })
    }

    /// A box or cylinder that encloses it closely.
    pub fn enclosure(&self) -> Enclosure {
        let is_cylinder = matches!(self, Self::Cylinder { .. });
        let (center, axes, half) = match *self {
            Self::Point(center) => (center, Mat3::IDENTITY, Vec3::ZERO),
            Self::Segment(a, b) => {
                let along = (b - a).try_normalize().unwrap_or(Vec3::Z);
                let (x, y) = along.any_orthonormal_pair();
                let half = Vec3::new(0.0, 0.0, a.distance(b) / 2.0);
                ((a + b) / 2.0, Mat3::from_cols(x, y, along), half)
            }
            Self::Triangle(a, b, c) => {
                let low = a.min(b).min(c);
                let high = a.max(b).max(c);
                ((low + high) / 2.0, Mat3::IDENTITY, (high - low) / 2.0)
            }
            Self::Box { center, axes, half } => (center, axes, half),
            Self::Cylinder {
                center,
                axes,
                half_height,
                radius,
            } => (center, axes, Vec3::new(radius, radius, half_height)),
        };
        Enclosure {
            center,
            axes,
            half,
            is_cylinder,
        }
    }

    /// Distance from `from` to the farthest point of the core (m).
    pub fn farthest(&self, from: Vec3) -> f64 {
        match *self {
            Self::Point(a) => a.distance(from),
            Self::Segment(a, b) => a.distance(from).max(b.distance(from)),
            Self::Triangle(a, b, c) => a
                .distance(from)
                .max(b.distance(from))
                .max(c.distance(from)),
            Self::Box { center, axes, half } => {
                ((axes.transpose() * (from - center)).abs() + half).length()
            }
            Self::Cylinder {
                center,
                axes,
                half_height,
                radius,
            } => {
                let local = axes.transpose() * (from - center);
                (local.z.abs() + half_height).hypot(local.truncate().length() + radius)
            }
        }
    }

    /// The core in the frame in which `pose` places its body.
    pub fn transformed(&self, pose: &Transform) -> Self {
        let place = |p: Vec3| pose.point(p);
        match *self {
            Self::Point(a) => Self::Point(place(a)),
            Self::Segment(a, b) => Self::Segment(place(a), place(b)),
            Self::Triangle(a, b, c) => Self::Triangle(place(a), place(b), place(c)),
            Self::Box { center, axes, half } => Self::Box {
                center: place(center),
                axes: pose.rotation * axes,
                half,
            },
            Self::Cylinder {
                center,
                axes,
                half_height,
                radius,
            } => Self::Cylinder {
                center: place(center),
                axes: pose.rotation * axes,
                half_height,
                radius,
            },
        }
    }

    /// The core's farthest point along `direction`, which may have any length.
    pub fn support(&self, direction: Vec3) -> Vec3 {
        match *self {
            Self::Point(a) => a,
            Self::Segment(a, b) => further(a, b, direction),
            Self::Triangle(a, b, c) => further(further(a, b, direction), c, direction),
            Self::Box { center, axes, half } => {
                let signs = axes.transpose() * direction;
                center
                    + axes
                        * Vec3::new(
                            half.x.copysign(signs.x),
                            half.y.copysign(signs.y),
                            half.z.copysign(signs.z),
                        )
            }
            Self::Cylinder {
                center,
                axes,
                half_height,
                radius,
            } => {
                // In the cylinder's own axes: beside its axis a direction is all rounding, and a
                // rim made of that in the world's axes would leave the lid's plane.
                let local = axes.transpose() * direction;
                let across = local.truncate().length();
                let stretch = if across > 0.0 { radius / across } else { 0.0 };
                center
                    + axes
                        * Vec3::new(
                            local.x * stretch,
                            local.y * stretch,
                            half_height.copysign(local.z),
                        )
            }
        }
    }

    /// Unit normals of its faces and lids.
    pub fn normals(&self) -> [Option<Vec3>; 3] {
        match *self {
            Self::Triangle(p, q, r) => [(q - p).cross(r - p).try_normalize(), None, None],
            Self::Box { axes, .. } => [Some(axes.x_axis), Some(axes.y_axis), Some(axes.z_axis)],
            Self::Cylinder { axes, .. } => [Some(axes.z_axis), None, None],
            Self::Point(_) | Self::Segment(..) => [None; 3],
        }
    }

    /// Adds points of which the core is the convex hull, but for the slack that it returns (m).
    pub fn outline(&self, points: &mut Vec<Vec3>) -> f64 {
        match *self {
            Self::Point(a) => points.push(a),
            Self::Segment(a, b) => points.extend([a, b]),
            Self::Triangle(a, b, c) => points.extend([a, b, c]),
            Self::Box { center, axes, half } => {
                let signs = (0..8).map(|corner: u32| {
                    [1, 2, 4].map(|bit| if corner & bit == 0 { 1.0 } else { -1.0 })
                });
                points.extend(signs.map(|signs| center + axes * (half * Vec3::from_array(signs))));
            }
            Self::Cylinder {
                center,
                axes,
                half_height,
                radius,
            } => {
                for index in 0..RIM {
                    let (sine, cosine) =
                        (std::f64::consts::TAU * index as f64 / RIM as f64).sin_cos();
                    let rim =
                        |height| center + axes * Vec3::new(radius * cosine, radius * sine, height);
                    points.extend([rim(half_height), rim(-half_height)]);
                }
                return radius * (1.0 - (std::f64::consts::PI / RIM as f64).cos());
            }
        }
        0.0
    }

    /// How deep a point is in a core that has an inside, and the way out; `None` outside.
    pub fn inner_depth(&self, point: Vec3) -> Option<(f64, Vec3)> {
        let (depth, way) = match *self {
            Self::Point(_) | Self::Segment(..) | Self::Triangle(..) => return None,
            Self::Box { center, axes, half } => {
                let local = axes.transpose() * (point - center);
                let room = half - local.abs();
                let axis = (0..3).min_by(|&a, &b| room[a].total_cmp(&room[b]))?;
                (room[axis], axes.col(axis) * 1.0_f64.copysign(local[axis]))
            }
            Self::Cylinder {
                center,
                axes,
                half_height,
                radius,
            } => {
                let local = axes.transpose() * (point - center);
                let across = local.truncate().length();
                let up = half_height - local.z.abs();
                let out = radius - across;
                let outwards = if across > 0.0 {
                    Vec3::new(local.x, local.y, 0.0) / across
                } else {
                    Vec3::X
                };
                if up < out {
                    (up, axes.z_axis * 1.0_f64.copysign(local.z))
                } else {
                    (out, axes * outwards)
                }
            }
        };
        (depth >= 0.0).then_some((depth, way))
    }
}

fn further(a: Vec3, b: Vec3, direction: Vec3) -> Vec3 {
    if (b - a).dot(direction) > 0.0 { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quat_exp;

    /// A normal beside the axis once gave a point a tenth of a millimetre inside the lid, and with
    /// it a gap above the distance; an axis a rounding away from unit length, one a radius above
    /// the lid.
    #[test]
    fn the_support_of_a_cylinder_lies_on_its_rim_however_close_the_direction_is_to_the_axis() {
        for turn in [Vec3::new(0.7, -1.1, 0.4), Vec3::ZERO, Vec3::Z * 0.3] {
            let axes = Mat3::from_quat(quat_exp(turn)) * (1.0 + 2.0 * f64::EPSILON);
            let core = Core::Cylinder {
                center: Vec3::ZERO,
                axes,
                half_height: 0.141,
                radius: 0.154,
            };
            for tilt in [0.0, 1e-16, 1e-14, 1.2e-12, 5.7e-12, 1e-9, 1e-3, 1.0] {
                let support = core.support(axes.z_axis + axes.x_axis * tilt);
                let along = support.dot(axes.z_axis);
                let across = (support - axes.z_axis * along).length();
                assert!(
                    (along - 0.141).abs() < 1e-12,
                    "tilt {tilt}: {along} along the axis"
                );
                assert!(
                    (across - 0.154).abs() < 1e-12 || across < 1e-12,
                    "tilt {tilt}: {across} across"
                );
            }
        }
    }
}

//! Convex pieces: a core swept by a ball. Every solid is made of them; a mesh's are its triangles.

use serde::{Deserialize, Serialize};

use crate::math::{Mat3, Pose, Vec3};
use crate::shape::{PlacedShape, Shape};

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

/// A convex solid: all points within `radius` of the core.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Piece {
    /// The core.
    pub core: Core,
    /// Rounding radius (m), 0 for shapes with edges.
    pub radius: f64,
}

impl Piece {
    /// The pieces of a shape, appended to `pieces`.
    pub fn append_of(placed: &PlacedShape, pieces: &mut Vec<Self>) {
        let pose = placed.pose;
        let along = pose.rotation * Vec3::Z;
        let (core, radius) = match &placed.shape {
            Shape::Sphere { radius } => (Core::Point(pose.translation), *radius),
            Shape::Capsule {
                radius,
                half_length,
            } => {
                let half = along * *half_length;
                (
                    Core::Segment(pose.translation - half, pose.translation + half),
                    *radius,
                )
            }
            Shape::Box { half_extents } => {
                let axes = Mat3::from_quat(pose.rotation);
                (
                    Core::Box {
                        center: pose.translation,
                        axes,
                        half: *half_extents,
                    },
                    0.0,
                )
            }
            Shape::Cylinder {
                radius,
                half_height,
            } => {
                let half_height = *half_height;
                let radius = *radius;
                let axes = Mat3::from_quat(pose.rotation);
                (
                    Core::Cylinder {
                        center: pose.translation,
                        axes,
                        half_height,
                        radius,
                    },
                    0.0,
                )
            }
            Shape::Mesh(mesh) => {
                let vertices: Vec<Vec3> = mesh
                    .vertices()
                    .iter()
                    .map(|v| pose.transform_point(*v))
                    .collect();
                // The inside test counts on triangles that face outwards.
                let inwards = mesh.signed_volume() < 0.0;
                pieces.extend(mesh.triangles().iter().map(|t| {
                    let [a, mut b, mut c] = t.map(|i| vertices[i as usize]);
                    if inwards {
                        std::mem::swap(&mut b, &mut c);
                    }
                    Self {
                        core: Core::Triangle(a, b, c),
                        radius: 0.0,
                    }
                }));
                return;
            }
        };
        pieces.push(Self { core, radius });
    }

    /// A point of the core, in its middle.
    pub fn center(&self) -> Vec3 {
        match self.core {
            Core::Point(a) => a,
            Core::Segment(a, b) => (a + b) / 2.0,
            Core::Triangle(a, b, c) => (a + b + c) / 3.0,
            Core::Box { center, .. } | Core::Cylinder { center, .. } => center,
        }
    }

    /// Distance from `from` to the farthest point of the piece (m).
    pub fn farthest(&self, from: Vec3) -> f64 {
        self.core.farthest(from) + self.radius
    }

    /// The square of [`Self::farthest`] (m²): of a triangle it needs no root.
    pub fn farthest_squared(&self, from: Vec3) -> f64 {
        match self.core {
            Core::Triangle(a, b, c) if self.radius == 0.0 => a
                .distance_squared(from)
                .max(b.distance_squared(from))
                .max(c.distance_squared(from)),
            _ => self.farthest(from).powi(2),
        }
    }

    /// The piece as seen from the frame in which `pose` places its body.
    pub fn transformed(&self, pose: &Transform) -> Self {
        Self {
            core: self.core.transformed(pose),
            radius: self.radius,
        }
    }
}

impl Core {
    /// Distance from `from` to the farthest point of the core (m).
    pub fn farthest(&self, from: Vec3) -> f64 {
        match *self {
            Self::Point(a) => a.distance(from),
            Self::Segment(a, b) => a.distance(from).max(b.distance(from)),
            Self::Triangle(a, b, c) => a.distance(from).max(b.distance(from)).max(c.distance(from)),
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
}

fn further(a: Vec3, b: Vec3, direction: Vec3) -> Vec3 {
    if (b - a).dot(direction) > 0.0 { b } else { a }
}

/// A pose with its rotation as a matrix, for moving many points.
#[derive(Clone, Copy, Debug)]
pub struct Transform {
    /// Rotation.
    pub rotation: Mat3,
    /// Translation (m).
    pub translation: Vec3,
}

impl Transform {
    /// No motion at all.
    pub const IDENTITY: Self = Self {
        rotation: Mat3::IDENTITY,
        translation: Vec3::ZERO,
    };

    /// Moves a point.
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.rotation * p + self.translation
    }

    /// `self · other`: where `other`, given in this frame, is in the frame that this one is given
    /// in.
    pub fn of(&self, other: &Self) -> Self {
        Self {
            rotation: self.rotation * other.rotation,
            translation: self.point(other.translation),
        }
    }

    /// `self⁻¹ · other`: other's frame as seen from this one.
    pub fn inverse_of(&self, other: &Self) -> Self {
        let back = self.rotation.transpose();
        Self {
            rotation: back * other.rotation,
            translation: back * (other.translation - self.translation),
        }
    }

    /// Brings a point back into the body's frame.
    pub fn inverse_point(&self, p: Vec3) -> Vec3 {
        self.rotation.transpose() * (p - self.translation)
    }
}

impl From<&Pose> for Transform {
    fn from(pose: &Pose) -> Self {
        Self {
            rotation: Mat3::from_quat(pose.rotation),
            translation: pose.translation,
        }
    }
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

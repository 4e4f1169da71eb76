//! Convex pieces: a core swept by a ball. Every solid is made of them; a mesh's are its triangles.

use serde::{Deserialize, Serialize};

use super::core::Core;
use super::transform::Transform;
use crate::math::{Mat3, Pose, Vec3};
use crate::shape::cloud::Cell;
use crate::shape::{Cloud, Mesh, PlacedShape, Shape};

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
        let center = placed.pose.translation;
        let axes = Mat3::from_quat(placed.pose.rotation);
        let (core, radius) = match &placed.shape {
            Shape::Sphere { radius } => (Core::Point(center), *radius),
            Shape::Capsule {
                radius,
                half_length,
            } => {
                let half = placed.pose.rotation * Vec3::Z * *half_length;
                (Core::Segment(center - half, center + half), *radius)
            }
            Shape::Box { half_extents } => {
                let half = *half_extents;
                (Core::Box { center, axes, half }, 0.0)
            }
            Shape::Cylinder {
                radius,
                half_height,
            } => {
                let core = Core::Cylinder {
                    center,
                    axes,
                    half_height: *half_height,
                    radius: *radius,
                };
                (core, 0.0)
            }
            Shape::Mesh(mesh) => return append_triangles(mesh, &placed.pose, pieces),
            Shape::Cloud(cloud) => return append_cells(cloud, &placed.pose, pieces),
        };
        pieces.push(Self { core, radius });
    }

    /// A cell of a cloud, about the cloud's origin, swept by a ball of `radius` (m).
    pub fn of_cell(Cell { center, half }: Cell, radius: f64) -> Self {
        let axes = Mat3::IDENTITY;
        let core = match half > 0.0 {
            true => Core::Box {
                center,
                axes,
                half: Vec3::splat(half),
            },
            false => Core::Point(center),
        };
        Self { core, radius }
    }

    /// A box along the axes, given by its corners (m), swept by a ball of `radius` (m).
    pub fn of_bounds([low, high]: [Vec3; 2], radius: f64) -> Self {
        let core = Core::Box {
            center: (low + high) / 2.0,
            axes: Mat3::IDENTITY,
            half: (high - low) / 2.0,
        };
        Self { core, radius }
    }

    /// A point of the core, in its middle.
    pub fn center(&self) -> Vec3 {
        self.core.center()
    }

    /// Distance from `from` to the farthest point of the piece (m).
    pub fn farthest(&self, from: Vec3) -> f64 {
        self.core.farthest(from) + self.radius
    }

    /// The square of [`Self::farthest`] (m²): of a triangle it needs no root.
    pub fn farthest_squared(&self, from: Vec3) -> f64 {
        if self.radius == 0.0 {
            self.core.farthest_squared(from)
        } else {
            self.farthest(from).powi(2)
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

/// The cells of a cloud, where it stands among other shapes.
fn append_cells(cloud: &Cloud, pose: &Pose, pieces: &mut Vec<Piece>) {
    let place = Transform::from(pose).of(&Transform::shift(cloud.origin()));
    let cells = (0..cloud.len()).map(|at| Piece::of_cell(cloud.cell(at), cloud.radius()));
    pieces.extend(cells.map(|piece| piece.transformed(&place)));
}

/// The triangles of a mesh, all facing outwards: the inside test counts on it.
fn append_triangles(mesh: &Mesh, pose: &Pose, pieces: &mut Vec<Piece>) {
    let placed = mesh
        .vertices()
        .iter()
        .map(|v| pose.transform_point(*v));
    let vertices: Vec<Vec3> = placed.collect();
    let inwards = mesh.signed_volume() < 0.0;
    pieces.extend(mesh.triangles().iter().map(|triangle| {
        let [a, mut b, mut c] = triangle.map(|i| vertices[i as usize]);
        if inwards {
            std::mem::swap(&mut b, &mut c);
        }
        Piece {
            core: Core::Triangle(a, b, c),
            radius: 0.0,
        }
    }));
}

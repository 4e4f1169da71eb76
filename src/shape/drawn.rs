//! What a viewer draws. Viewers know a few forms; every other shape reaches them as triangles, so
//! that a new kind of shape needs no viewer.

use std::borrow::Cow;

use super::cloud::Cloud;
use super::kind::Shape;
use super::mesh::Mesh;
use crate::math::Vec3;

/// A shape as viewers have it, in its own frame, axis along z (m).
#[derive(Clone, Debug)]
pub enum Drawn<'a> {
    /// A box of full sizes.
    Box {
        /// Along x, y and z.
        size: Vec3,
    },
    /// A ball.
    Sphere {
        /// Its radius.
        radius: f64,
    },
    /// A cylinder with flat ends.
    Cylinder {
        /// Its radius.
        radius: f64,
        /// Its full height.
        length: f64,
    },
    /// A cylinder with round ends.
    Capsule {
        /// Its radius.
        radius: f64,
        /// Its height without the ends.
        length: f64,
    },
    /// Triangles.
    Mesh(Cow<'a, Mesh>),
}

impl Shape {
    /// What a viewer draws.
    pub fn drawn(&self) -> Drawn<'_> {
        match self {
            Self::Sphere { radius } => Drawn::Sphere { radius: *radius },
            Self::Box { half_extents } => Drawn::Box {
                size: *half_extents * 2.0,
            },
            Self::Cylinder {
                radius,
                half_height,
            } => Drawn::Cylinder {
                radius: *radius,
                length: 2.0 * half_height,
            },
            Self::Capsule {
                radius,
                half_length,
            } => Drawn::Capsule {
                radius: *radius,
                length: 2.0 * half_length,
            },
            Self::Mesh(mesh) => Drawn::Mesh(Cow::Borrowed(mesh)),
            Self::Cloud(cloud) => Drawn::Mesh(Cow::Owned(cubes(cloud))),
        }
    }
}

/// Cells of a cloud that are drawn: one in so many, evenly spread, where there are more.
const DRAWN_CELLS: usize = 4096;

/// The faces of a cube, by the bits of its corners.
const FACES: [[u32; 3]; 12] = [
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
];

/// A cube for each cell that is drawn, as wide as the cell.
fn cubes(cloud: &Cloud) -> Mesh {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for place in (0..cloud.len()).step_by(cloud.len().div_ceil(DRAWN_CELLS)) {
        let cell = cloud.cell(place);
        let first = vertices.len() as u32;
        let half = cell.half + cloud.radius();
        let sign = |corner: u32, bit: u32| if corner & bit == 0 { -half } else { half };
        let corner = |c: u32| Vec3::new(sign(c, 1), sign(c, 2), sign(c, 4));
        vertices.extend((0..8).map(|c| cloud.origin() + cell.center + corner(c)));
        triangles.extend(FACES.map(|face| face.map(|corner| first + corner)));
    }
    Mesh::new("cloud", vertices, triangles).expect("cubes have faces")
}

//! The kinds of shapes, and what each is called: one table for all files, hashes and messages, so
//! that a new kind is a variant and a row here.

use std::sync::Arc;

use super::cloud::Cloud;
use super::mesh::Mesh;
use crate::hash::number;
use crate::math::Vec3;
use crate::warning::Warning;

/// A solid in its own frame (m). Symmetric shapes are centred at the origin, axis along z.
///
/// Build one with the checked constructors: every size is finite and positive.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Ball.
    Sphere {
        /// Radius (m).
        radius: f64,
    },
    /// Box.
    Box {
        /// Half of each full size (m).
        half_extents: Vec3,
    },
    /// Cylinder with flat ends.
    Cylinder {
        /// Radius (m).
        radius: f64,
        /// Half of the full height (m).
        half_height: f64,
    },
    /// Segment along z swept by a ball.
    Capsule {
        /// Radius (m).
        radius: f64,
        /// Half of the segment's length (m) (the whole capsule is `2 (half_length + radius)` long).
        half_length: f64,
    },
    /// Triangle mesh, an exact solid: a point inside its surface is inside the shape.
    Mesh(Arc<Mesh>),
    /// Points or voxels, all of them together.
    Cloud(Arc<Cloud>),
}

/// A kind of primitive as texts, files and hashes have it.
#[derive(Debug)]
pub struct PrimitiveKind {
    /// Its name.
    pub name: &'static str,
    /// Its number in `shape_msgs/SolidPrimitive`, where that has it.
    pub number: Option<u64>,
    /// Names of its dimensions (m), in MoveIt's order.
    pub dimensions: &'static [&'static str],
    make: fn(Dimensions) -> Shape,
}

/// Sizes of a primitive (m), in the order of [`PrimitiveKind::dimensions`]; those that a kind does
/// not have are 0.
type Dimensions = [f64; 3];

/// Every kind of primitive. A kind's row is where [`Shape::description`] says.
pub static PRIMITIVES: [PrimitiveKind; 4] = [
    PrimitiveKind {
        name: "box",
        number: Some(1),
        dimensions: &["x size", "y size", "z size"],
        make: |size| Shape::Box {
            half_extents: Vec3::from_array(size) / 2.0,
        },
    },
    PrimitiveKind {
        name: "sphere",
        number: Some(2),
        dimensions: &["radius"],
        make: |[radius, ..]| Shape::Sphere { radius },
    },
    PrimitiveKind {
        name: "cylinder",
        number: Some(3),
        dimensions: &["height", "radius"],
        make: |[height, radius, _]| Shape::Cylinder {
            radius,
            half_height: height / 2.0,
        },
    },
    PrimitiveKind {
        name: "capsule",
        number: None,
        dimensions: &["length", "radius"],
        make: |[length, radius, _]| Shape::Capsule {
            radius,
            half_length: length / 2.0,
        },
    },
];

/// What a shape is, by name and number.
#[derive(Clone, Copy, Debug)]
pub enum Description<'a> {
    /// A primitive and its dimensions (m), 0 for those that the kind does not have.
    Primitive(&'static PrimitiveKind, [f64; 3]),
    /// A mesh.
    Mesh(&'a Arc<Mesh>),
    /// Points or voxels.
    Cloud(&'a Arc<Cloud>),
}

impl PrimitiveKind {
    /// The kind of a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        PRIMITIVES.iter().find(|kind| kind.name == name)
    }

    /// The dimensions that it has of those of a [`Description`].
    pub fn own<'a>(&self, dimensions: &'a [f64; 3]) -> &'a [f64] {
        &dimensions[..self.dimensions.len()]
    }

    /// The shape of these dimensions (m); `None` where the kind has another number of them.
    pub fn checked(&self, dimensions: &[f64]) -> Option<Result<Shape, ShapeError>> {
        if dimensions.len() != self.dimensions.len() {
            return None;
        }
        let mut all = Dimensions::default();
        all[..dimensions.len()].copy_from_slice(dimensions);
        Some(self.check(dimensions).map(|()| self.of(all)))
    }

    fn check(&self, dimensions: &[f64]) -> Result<(), ShapeError> {
        let mut sizes = self.dimensions.iter().zip(dimensions);
        match sizes.find(|(_, value)| !(value.is_finite() && **value > 0.0)) {
            None => Ok(()),
            Some((size, value)) => Err(ShapeError {
                shape: self.name,
                size,
                value: *value,
            }),
        }
    }

    /// The shape of dimensions that are known to be some.
    pub(super) fn of(&self, dimensions: Dimensions) -> Shape {
        (self.make)(dimensions)
    }
}

/// A size that no solid can have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{shape}: {size} is {value}, it must be finite and greater than 0")]
pub struct ShapeError {
    /// Kind of shape.
    pub shape: &'static str,
    /// Which size.
    pub size: &'static str,
    /// Its value.
    pub value: f64,
}

impl Shape {
    /// Its kind and dimensions, or its mesh or cloud.
    pub fn description(&self) -> Description<'_> {
        let (row, dimensions) = match self {
            Self::Box { half_extents } => (0, (*half_extents * 2.0).to_array()),
            Self::Sphere { radius } => (1, [*radius, 0.0, 0.0]),
            Self::Cylinder {
                radius,
                half_height,
            } => (2, [2.0 * half_height, *radius, 0.0]),
            Self::Capsule {
                radius,
                half_length,
            } => (3, [2.0 * half_length, *radius, 0.0]),
            Self::Mesh(mesh) => return Description::Mesh(mesh),
            Self::Cloud(cloud) => return Description::Cloud(cloud),
        };
        Description::Primitive(&PRIMITIVES[row], dimensions)
    }

    /// What is hashed of it, in words that never change: those of the first hashes, by which
    /// certificates and journals name robots and scenes.
    pub(crate) fn words(&self) -> String {
        match self {
            Self::Sphere { radius } => format!("Sphere {{ radius: {} }}", number(*radius)),
            Self::Box { half_extents } => {
                let [x, y, z] = half_extents.to_array().map(number);
                format!("Box {{ half_extents: DVec3({x}, {y}, {z}) }}")
            }
            Self::Cylinder {
                radius,
                half_height,
            } => {
                let sizes = [*radius, *half_height].map(number);
                format!(
                    "Cylinder {{ radius: {}, half_height: {} }}",
                    sizes[0], sizes[1]
                )
            }
            Self::Capsule {
                radius,
                half_length,
            } => {
                let sizes = [*radius, *half_length].map(number);
                format!(
                    "Capsule {{ radius: {}, half_length: {} }}",
                    sizes[0], sizes[1]
                )
            }
            Self::Mesh(mesh) => format!("Mesh {:016x}", mesh.hash()),
            Self::Cloud(cloud) => format!("Cloud {:016x}", cloud.hash()),
        }
    }

    /// The mesh, if it is one.
    pub fn mesh(&self) -> Option<&Arc<Mesh>> {
        match self.description() {
            Description::Mesh(mesh) => Some(mesh),
            Description::Primitive(..) | Description::Cloud(_) => None,
        }
    }

    /// The cloud, if it is one.
    pub fn cloud(&self) -> Option<&Arc<Cloud>> {
        match self.description() {
            Description::Cloud(cloud) => Some(cloud),
            Description::Primitive(..) | Description::Mesh(_) => None,
        }
    }

    /// What is odd about it, a line each.
    pub fn warnings(&self) -> &[Warning] {
        match self.description() {
            Description::Mesh(mesh) => mesh.warnings(),
            Description::Cloud(cloud) => &cloud.provenance().warnings,
            Description::Primitive(..) => &[],
        }
    }

    /// Ball of `radius` (m).
    pub fn sphere(radius: f64) -> Result<Self, ShapeError> {
        Self::row(1, &[radius])
    }

    /// Box of full sizes x, y, z (m).
    pub fn cuboid(size: Vec3) -> Result<Self, ShapeError> {
        Self::row(0, &size.to_array())
    }

    /// Cylinder of full `height` (m) along z (MoveIt's order of dimensions: height, radius).
    pub fn cylinder(height: f64, radius: f64) -> Result<Self, ShapeError> {
        Self::row(2, &[height, radius])
    }

    /// Capsule whose segment has full `length` (m) along z.
    pub fn capsule(length: f64, radius: f64) -> Result<Self, ShapeError> {
        Self::row(3, &[length, radius])
    }

    fn row(row: usize, dimensions: &[f64]) -> Result<Self, ShapeError> {
        let shape = PRIMITIVES[row].checked(dimensions);
        shape.expect("each caller gives as many dimensions as the row has")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row that a description does not name, or that makes another shape, would lose shapes on
    /// their way through files.
    #[test]
    fn a_description_makes_its_shape_again() {
        for kind in &PRIMITIVES {
            let sizes = &[0.3, 0.2, 0.7][..kind.dimensions.len()];
            let shape = kind.checked(sizes).unwrap().unwrap();
            let Description::Primitive(found, dimensions) = shape.description() else {
                panic!("{} is a mesh", kind.name)
            };
            assert_eq!((found.name, found.own(&dimensions)), (kind.name, sizes));
            assert_eq!(found.of(dimensions), shape);
            assert_eq!(PrimitiveKind::named(kind.name).unwrap().name, kind.name);
        }
    }
}

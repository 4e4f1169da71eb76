//! Shapes of a URDF, and what becomes of those without a size.

use roxmltree::Node;

use super::super::xml::{children, line};
use super::{CAPSULES, Reading};
use crate::math::Vec3;
use crate::robot::RobotError;
use crate::shape::{Shape, ShapeError};
use crate::warning::Warning;

/// What a sheet or a line is taken for (m): a solid that holds it, so that what clears the solid
/// clears it.
const THIN: f64 = 1e-6;

impl Reading<'_, '_> {
    /// The shape of a collision or visual element; `None` for a point, which marks a place and
    /// fills none.
    pub(super) fn shape(
        &mut self,
        geometry: &urdf_rs::Geometry,
        node: Node,
        link: &str,
    ) -> Result<Option<Shape>, RobotError> {
        use urdf_rs::Geometry;
        // Lines are counted only for messages: that takes a walk through the file.
        let at = || {
            children(node, "geometry")
                .next()
                .map_or(0, line)
        };
        let of = |name: &str| format!("line {}: link {link:?}: <{name}>", at());
        let shape = match geometry {
            Geometry::Box { size } => {
                let Some(size) = self.sized(|| of("box"), &**size) else {
                    return Ok(None);
                };
                Shape::cuboid(Vec3::new(size[0], size[1], size[2]))
            }
            Geometry::Cylinder { radius, length } => {
                let Some(size) = self.sized(|| of("cylinder"), &[*radius, *length]) else {
                    return Ok(None);
                };
                Shape::cylinder(size[1], size[0])
            }
            // `length` is the straight part, without the round ends.
            Geometry::Capsule { radius, length } => {
                self.old_capsule(|| of("capsule"));
                let Some(size) = self.sized(|| of("capsule"), &[*radius, *length]) else {
                    return Ok(None);
                };
                if *length == 0.0 {
                    Shape::sphere(size[0])
                } else {
                    Shape::capsule(size[1], size[0])
                }
            }
            Geometry::Sphere { radius } => {
                let Some(size) = self.sized(|| of("sphere"), &[*radius]) else {
                    return Ok(None);
                };
                Shape::sphere(size[0])
            }
            Geometry::Mesh { filename, scale } => {
                let scale = scale.map_or(Vec3::ONE, |scale| Vec3::from_array(*scale));
                let mesh = (self.meshes)(filename, scale);
                return match mesh {
                    Ok(mesh) => Ok(Some(Shape::Mesh(mesh))),
                    Err(source) => Err(RobotError::Mesh {
                        link: link.to_owned(),
                        source,
                    }),
                };
            }
        };
        shape
            .map(Some)
            .map_err(|error| bad_size(&error, at(), link))
    }

    fn is_told(&self, text: &str) -> bool {
        let mut warnings = self.warnings.iter();
        warnings.any(|warning| warning.ends_with(text))
    }

    /// One line for a file: its first capsule, where others would not read any.
    fn old_capsule(&mut self, of: impl Fn() -> String) {
        let (major, minor) = self.version;
        let text = format!(
            "is of URDF 1.2 and this file of {major}.{minor}; capsules are read all the same"
        );
        if self.version < CAPSULES && !self.is_told(&text) {
            self.warnings
                .push(Warning::cosmetic("capsule", format!("{} {text}", of())));
        }
    }

    /// The sizes with no 0 among them; `None` where they are all 0.
    fn sized(&mut self, of: impl Fn() -> String, sizes: &[f64]) -> Option<Vec<f64>> {
        if sizes.iter().all(|size| *size == 0.0) {
            self.warnings.push(Warning::uncovered(format!(
                "{} has no size; it is left out",
                of()
            )));
            return None;
        }
        if sizes.contains(&0.0) && sizes.iter().all(|size| *size >= 0.0) {
            let numbers: Vec<String> = sizes.iter().map(f64::to_string).collect();
            let text = format!("fills no space; it is taken to be {THIN} m thick");
            let text = format!("{} of size {} {text}", of(), numbers.join(" × "));
            self.warnings.push(Warning::uncovered(text));
        }
        Some(
            sizes
                .iter()
                .map(|size| if *size == 0.0 { THIN } else { *size })
                .collect(),
        )
    }
}

fn bad_size(error: &ShapeError, line: u32, link: &str) -> RobotError {
    RobotError::BadValue {
        what: format!(
            "link {link:?}: the {} of {} in line {line}",
            error.size, error.shape
        ),
        value: error.value.to_string(),
        rule: "it must be finite and at least 0",
    }
}

//! Triangles as a file gives them, and what it gives besides.

use std::collections::BTreeMap;

use super::edges::Triangle;
use super::polygon;
use crate::math::Vec3;

/// What is read from a mesh file, in its unit.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    /// Vertices.
    pub vertices: Vec<Vec3>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<Triangle>,
    /// Polygons that cross themselves.
    pub crossing: usize,
    /// How many there are of each thing that has no surface and is left out.
    pub without_surface: BTreeMap<&'static str, usize>,
}

impl Surface {
    /// Adds a polygon of vertices that are there.
    ///
    /// # Errors
    /// A polygon that is too large to be cut into triangles.
    pub fn add_polygon(&mut self, corners: &[u32]) -> Result<(), String> {
        match *corners {
            [] | [_] | [_, _] => self.leave_out("polygons of fewer than three corners"),
            [a, b, c] => self.triangles.push([a, b, c]),
            _ => self.fill(corners)?,
        }
        Ok(())
    }

    fn fill(&mut self, corners: &[u32]) -> Result<(), String> {
        let places = corners
            .iter()
            .map(|&corner| self.vertices[corner as usize]);
        let filled = polygon::fill(&places.collect::<Vec<Vec3>>())?;
        self.crossing += usize::from(filled.crosses);
        let triangles = filled.triangles.into_iter();
        self.triangles
            .extend(triangles.map(|triangle| triangle.map(|at| corners[at])));
        Ok(())
    }

    /// Multiplies its coordinates; what is outside stays outside.
    pub fn scale(&mut self, factors: Vec3) {
        self.vertices
            .iter_mut()
            .for_each(|vertex| *vertex *= factors);
        let negative = factors
            .to_array()
            .into_iter()
            .filter(|factor| *factor < 0.0);
        // An odd number of negative factors turns the triangles over.
        if negative.count() % 2 == 1 {
            self.triangles
                .iter_mut()
                .for_each(|triangle| triangle.swap(1, 2));
        }
    }

    /// Adds polygons whose corners are all new, in order.
    pub fn add_corners(&mut self, corners: &[Vec3]) -> Result<(), String> {
        let first = self.vertices.len() as u32;
        self.vertices.extend(corners);
        self.add_polygon(&(first..first + corners.len() as u32).collect::<Vec<_>>())
    }

    /// Counts one of the things that have no surface.
    pub fn leave_out(&mut self, what: &'static str) {
        *self.without_surface.entry(what).or_default() += 1;
    }

    /// What a person should know about the file, besides what is odd about its triangles.
    pub fn words(&self) -> Vec<String> {
        let crossing = (self.crossing > 0).then(|| {
            format!(
                "has {} polygons that cross themselves; they have no inside, and are filled anyway",
                self.crossing
            )
        });
        crossing
            .into_iter()
            .chain(self.left_out())
            .collect()
    }

    fn left_out(&self) -> Option<String> {
        let counts = self.without_surface.iter();
        let counted: Vec<_> = counts
            .map(|(what, count)| format!("{count} {what}"))
            .collect();
        (!counted.is_empty()).then(|| {
            format!(
                "has {}; they have no surface and are left out",
                counted.join(", ")
            )
        })
    }
}

/// A coordinate of a text file.
pub(super) fn number(word: &str) -> Result<f64, String> {
    let advice = if word.contains(',') {
        "; the decimal sign must be a point"
    } else {
        ""
    };
    word.parse()
        .map_err(|_| format!("{word:?} is no number{advice}"))
}

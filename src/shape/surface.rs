//! Triangles as a file gives them, and what it gives besides.

use std::collections::BTreeMap;

use super::polygon;
use crate::math::Vec3;

/// What is read from a mesh file, in its unit.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    /// Vertices.
    pub vertices: Vec<Vec3>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
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
        if let &[a, b, c] = corners {
            self.triangles.push([a, b, c]);
            return Ok(());
        }
        if corners.len() < 3 {
            self.leave_out("polygons of fewer than three corners");
            return Ok(());
        }
        let places: Vec<Vec3> = corners
            .iter()
            .map(|&corner| self.vertices[corner as usize])
            .collect();
        let filled = polygon::fill(&places)?;
        self.crossing += usize::from(filled.crosses);
        self.triangles.extend(
            filled
                .triangles
                .into_iter()
                .map(|triangle| triangle.map(|at| corners[at])),
        );
        Ok(())
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
        let mut words = Vec::new();
        if self.crossing > 0 {
            let count = self.crossing;
            words.push(format!(
                "has {count} polygons that cross themselves; they have no inside, and are filled anyway"
            ));
        }
        if !self.without_surface.is_empty() {
            let counted: Vec<_> = self
                .without_surface
                .iter()
                .map(|(what, count)| format!("{count} {what}"))
                .collect();
            words.push(format!(
                "has {}; they have no surface and are left out",
                counted.join(", ")
            ));
        }
        words
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

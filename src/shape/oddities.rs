//! What is odd about a mesh: it is used as it stands, but a person should look at it.

use super::edges::Edges;
use super::mesh::Mesh;
use super::sides::Mended;
use super::volume::bounds;
use crate::warning::Warning;

/// A mesh larger than this (m) was probably drawn in millimetres.
const SUSPICIOUS_SIZE_M: f64 = 10.0;
/// A mesh smaller than this (m) was probably scaled to metres twice.
const SUSPICIOUS_SMALLNESS_M: f64 = 1e-3;

/// What became of a mesh's triangles.
#[derive(Debug)]
pub(super) struct Making {
    /// Edges as the triangles came.
    pub edges: Edges,
    /// What was mended.
    pub mended: Mended,
    /// Edges then.
    pub left: Edges,
    /// Triangles that were left out because they have no area.
    pub dropped: usize,
}

/// A line for each odd thing.
pub(super) fn of(mesh: &Mesh, making: &Making) -> Vec<Warning> {
    let (largest, size) = size(mesh);
    let sides = Sides::of(mesh, making).found.into_iter();
    let lines = of_size(largest, &size)
        .into_iter()
        .chain(sides.map(|(what, then)| format!("{what}; {then} (size {size})")));
    let mut found: Vec<Warning> = lines
        .map(|text| Warning::uncovered(format!("mesh {} {text}", mesh.name())))
        .collect();
    found.extend(flat_triangles(mesh, making.dropped, &size));
    found
}

/// The largest side of a mesh's box, and all three in words.
fn size(mesh: &Mesh) -> (f64, String) {
    let (low, high) = bounds(mesh.vertices().iter().copied());
    let size = high - low;
    let [x, y, z] = size.to_array().map(length);
    (size.max_element(), format!("{x} × {y} × {z} m"))
}

/// A size that is probably in another unit.
fn of_size(largest: f64, size: &str) -> Option<String> {
    if largest > SUSPICIOUS_SIZE_M {
        let mended =
            r#"give it scale="0.001 0.001 0.001" (in a scene: "scale": [0.001, 0.001, 0.001])"#;
        return Some(format!(
            "is {size} large; if it was drawn in millimetres, {mended}"
        ));
    }
    (largest < SUSPICIOUS_SMALLNESS_M)
        .then(|| format!("is {size} small; was a scale of 0.001 applied twice?"))
}

fn flat_triangles(mesh: &Mesh, dropped: usize, size: &str) -> Option<Warning> {
    let all = dropped + mesh.triangles().len();
    let text = format!(
        "mesh {} has {dropped} triangles without an area among {all}; they are left out (size {size})",
        mesh.name()
    );
    (dropped > 0).then(|| Warning::cosmetic("flat triangles", text))
}

/// What is odd about the sides of a surface, and what it means for what is inside.
struct Sides<'a> {
    making: &'a Making,
    found: Vec<(String, String)>,
}

/// What follows where inside and outside cannot be told for sure.
const GUESS: &str =
    "a point inside it may count as outside; what it encloses nearly all round counts as inside";

impl<'a> Sides<'a> {
    fn of(mesh: &Mesh, making: &'a Making) -> Self {
        let mut sides = Self {
            making,
            found: Vec::new(),
        };
        sides.borders();
        sides.both_orders();
        sides.opposite_ways();
        sides.whole(mesh);
        sides
    }

    fn tell(&mut self, what: String, then: impl Into<String>) {
        self.found.push((what, then.into()));
    }

    fn borders(&mut self) {
        let Edges { all, open, .. } = self.making.edges;
        if open > 0 {
            let what = format!("is not closed: {open} of {all} edges are open");
            self.tell(what, GUESS);
        }
    }

    fn both_orders(&mut self) {
        let Mended {
            doubled, sheets, ..
        } = self.making.mended;
        let twice = |count| format!("has {count} triangles twice, facing both ways");
        if doubled > 0 {
            let what = format!("{}, that close a surface", twice(doubled));
            self.tell(what, "it is taken as the solid inside");
        }
        if sheets > 0 {
            let what = format!("{}: two-sided sheets", twice(sheets));
            self.tell(what, "sheets have no inside, only their surface counts");
        }
    }

    fn opposite_ways(&mut self) {
        let Edges { all, turned, .. } = self.making.edges;
        let what = format!("has triangles that face opposite ways, at {turned} of {all} edges");
        match (turned, self.making.left.turned) {
            (0, _) => {}
            (_, 0) => {
                let what = format!("{what}; {} are turned over", self.making.mended.turned);
                self.tell(what, "they face as their neighbours do");
            }
            (_, left) => self.tell(format!("{what}; no turning mends {left} of them"), GUESS),
        }
    }

    /// What a surface without borders encloses.
    fn whole(&mut self, mesh: &Mesh) {
        let Making {
            edges,
            mended,
            left,
            ..
        } = self.making;
        let volume = mesh.signed_volume();
        if left.are_closed() && mesh.encloses_nothing() && mended.sheets == 0 {
            let what = format!("encloses no volume ({volume:.1e} m³)");
            self.tell(what, "it is a sheet, only its surface counts");
        } else if edges.are_closed() && volume < 0.0 {
            self.inwards(volume);
        } else if edges.are_closed() && mended.doubled == 0 && mended.turned > 0 {
            self.parts_inwards(mended.turned);
        }
    }

    fn inwards(&mut self, volume: f64) {
        let what =
            format!("faces inwards: its normals are inverted, signed volume {volume:.3e} m³");
        self.tell(what, "it is turned over and taken as the solid inside");
    }

    fn parts_inwards(&mut self, turned: usize) {
        let what = format!("has parts that face inwards and are no cavities, {turned} triangles");
        self.tell(what, "they are turned over and taken as solid inside");
    }
}

/// A length with about three digits (m).
fn length(metres: f64) -> String {
    match metres {
        m if m >= 10.0 => format!("{m:.1}"),
        m if m >= 1.0 => format!("{m:.2}"),
        m if m >= 0.001 || m == 0.0 => format!("{m:.3}"),
        m => format!("{m:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    /// Corners and faces of a box of this size, facing outwards.
    fn cuboid(size: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let corner =
            |i: u32| Vec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) * size;
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let faces = quads
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .collect();
        ((0..8).map(corner).collect(), faces)
    }

    fn warnings(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Vec<Warning> {
        Mesh::new("cup.stl", vertices, triangles)
            .unwrap()
            .warnings()
            .to_vec()
    }

    fn assert_only(warnings: &[Warning], parts: &[&str]) {
        let [only] = warnings else {
            panic!("one warning, not {warnings:?}")
        };
        assert!(
            parts.iter().all(|part| only.contains(part)),
            "{only:?} lacks one of {parts:?}"
        );
        assert!(!only.contains('\n'), "{only:?}");
    }

    #[test]
    fn a_good_mesh_has_no_warnings_and_two_boxes_may_share_an_edge() {
        let (mut vertices, mut faces) = cuboid(Vec3::new(0.1, 0.2, 9.0));
        assert!(warnings(vertices.clone(), faces.clone()).is_empty());
        let (second, more) = cuboid(Vec3::new(-0.1, -0.2, 9.0));
        vertices.extend(second);
        // Mirrored twice, so it faces outwards as it stands.
        faces.extend(more.iter().map(|face| face.map(|i| i + 8)));
        assert!(warnings(vertices, faces).is_empty());
    }

    #[test]
    fn a_mesh_in_millimetres_is_named_with_its_size_and_the_line_that_mends_it() {
        let (vertices, faces) = cuboid(Vec3::new(80.0, 80.0, 120.5));
        let mended = r#"scale="0.001 0.001 0.001""#;
        assert_only(
            &warnings(vertices.clone(), faces.clone()),
            &["cup.stl is 80.0 × 80.0 × 120.5 m large", mended],
        );
        let twice = vertices
            .into_iter()
            .map(|vertex| vertex * 1e-6)
            .collect();
        assert_only(
            &warnings(twice, faces),
            &["cup.stl is 8.0e-5 × 8.0e-5 × 1.2e-4 m", "twice"],
        );
    }

    #[test]
    fn holes_inverted_normals_and_mixed_ones_are_told_apart() {
        let (vertices, faces) = cuboid(Vec3::new(0.1, 0.2, 1.0));
        let named = "0.100 × 0.200 × 1.00 m";
        assert_only(
            &warnings(vertices.clone(), faces[1..].to_vec()),
            &["cup.stl", named, "3 of 18 edges are open"],
        );
        let inverted: Vec<[u32; 3]> = faces
            .iter()
            .map(|&[a, b, c]| [a, c, b])
            .collect();
        assert_only(
            &warnings(vertices.clone(), inverted),
            &["cup.stl", named, "normals are inverted", "turned over"],
        );
        let mut mixed = faces.clone();
        mixed[3].swap(0, 1);
        assert_only(
            &warnings(vertices.clone(), mixed),
            &["cup.stl", named, "opposite ways", "3 of 18 edges"],
        );
        let mut slivers = faces;
        slivers.push([0, 0, 1]);
        assert_only(
            &warnings(vertices, slivers),
            &[
                "cup.stl",
                named,
                "1 triangles without an area among 13",
                "left out",
            ],
        );
    }
}

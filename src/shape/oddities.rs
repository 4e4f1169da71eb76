//! What is odd about a mesh: it is used as it stands, but a person should look at it.

use super::Mesh;
use super::sides::Mended;
use crate::math::Vec3;
use crate::warning::Warning;

/// A mesh larger than this (m) was probably drawn in millimetres.
const SUSPICIOUS_SIZE_M: f64 = 10.0;
/// A mesh smaller than this (m) was probably scaled to metres twice.
const SUSPICIOUS_SMALLNESS_M: f64 = 1e-3;

/// How the triangles of a surface meet. A surface is closed where every edge is walked as often one
/// way as the other by the triangles around it; only then does the winding number tell inside from
/// outside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Edges {
    /// All edges.
    pub all: usize,
    /// Edges of an odd number of triangles.
    pub open: usize,
    /// Edges of an even number of triangles that do not face the same way.
    pub turned: usize,
    /// Edges of more than two triangles.
    pub crowded: usize,
}

impl Edges {
    /// Counts the edges of triangles.
    pub(super) fn of(triangles: &[[u32; 3]]) -> Self {
        let ways = triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let mut ways: Vec<(u64, bool)> = ways
            .map(|(from, to)| {
                (
                    u64::from(from.min(to)) << 32 | u64::from(from.max(to)),
                    from < to,
                )
            })
            .collect();
        ways.sort_unstable();
        let mut edges = Self::default();
        for edge in ways.chunk_by(|a, b| a.0 == b.0) {
            let forward = edge.iter().filter(|way| way.1).count();
            edges.all += 1;
            edges.open += edge.len() % 2;
            edges.turned += usize::from(edge.len() % 2 == 0 && 2 * forward != edge.len());
            edges.crowded += usize::from(edge.len() > 2);
        }
        edges
    }
}

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
    let bounds = |(low, high): (Vec3, Vec3), v: &Vec3| (low.min(*v), high.max(*v));
    let (low, high) = mesh
        .vertices()
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), bounds);
    let size = high - low;
    let largest = size.max_element();
    let size = format!(
        "{} × {} × {} m",
        length(size.x),
        length(size.y),
        length(size.z)
    );
    let mut found = Vec::new();
    let mut tell =
        |text: String| found.push(Warning::uncovered(format!("mesh {} {text}", mesh.name())));
    if largest > SUSPICIOUS_SIZE_M {
        let mended =
            r#"give it scale="0.001 0.001 0.001" (in a scene: "scale": [0.001, 0.001, 0.001])"#;
        tell(format!(
            "is {size} large; if it was drawn in millimetres, {mended}"
        ));
    } else if largest < SUSPICIOUS_SMALLNESS_M {
        tell(format!(
            "is {size} small; was a scale of 0.001 applied twice?"
        ));
    }
    for (what, then) in sides(mesh, making) {
        tell(format!("{what}; {then} (size {size})"));
    }
    if making.dropped > 0 {
        let dropped = making.dropped;
        let all = making.dropped + mesh.triangles().len();
        let text = format!(
            "has {dropped} triangles without an area among {all}; they are left out (size {size})"
        );
        found.push(Warning::cosmetic(
            "flat triangles",
            format!("mesh {} {text}", mesh.name()),
        ));
    }
    found
}

/// What is odd about the sides of a surface, and what it means for what is inside.
fn sides(mesh: &Mesh, making: &Making) -> Vec<(String, String)> {
    let Making {
        edges: Edges {
            all, open, turned, ..
        },
        mended,
        left,
        ..
    } = making;
    let mut found = Vec::new();
    let mut tell = |what: String, then: &str| found.push((what, then.to_owned()));
    let guess = "a point inside it may count as outside; what it encloses nearly all round counts as inside";
    if *open > 0 {
        tell(
            format!("is not closed: {open} of {all} edges are open"),
            guess,
        );
    }
    if mended.doubled > 0 {
        let what = format!(
            "has {} triangles twice, facing both ways, that close a surface",
            mended.doubled
        );
        tell(what, "it is taken as the solid inside");
    }
    if mended.sheets > 0 {
        let what = format!(
            "has {} triangles twice, facing both ways: two-sided sheets",
            mended.sheets
        );
        tell(what, "sheets have no inside, only their surface counts");
    }
    if *turned > 0 {
        let what = format!("has triangles that face opposite ways, at {turned} of {all} edges");
        match left.turned {
            0 => tell(
                format!("{what}; {} are turned over", mended.turned),
                "they face as their neighbours do",
            ),
            left => tell(format!("{what}; no turning mends {left} of them"), guess),
        }
    }
    let volume = mesh.signed_volume();
    if left.open + left.turned == 0 && mesh.encloses_nothing() && mended.sheets == 0 {
        tell(
            format!("encloses no volume ({volume:.1e} m³)"),
            "it is a sheet, only its surface counts",
        );
    } else if open + turned == 0 && volume < 0.0 {
        let what =
            format!("faces inwards: its normals are inverted, signed volume {volume:.3e} m³");
        tell(what, "it is turned over and taken as the solid inside");
    } else if open + turned + mended.doubled == 0 && mended.turned > 0 {
        let what = format!(
            "has parts that face inwards and are no cavities, {} triangles",
            mended.turned
        );
        tell(what, "they are turned over and taken as solid inside");
    }
    found
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
        let twice = vertices.into_iter().map(|vertex| vertex * 1e-6).collect();
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
        let inverted: Vec<[u32; 3]> = faces.iter().map(|&[a, b, c]| [a, c, b]).collect();
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

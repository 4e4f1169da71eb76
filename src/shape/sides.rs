//! Which way the triangles of a surface face.
//!
//! Files say it by the order of corners, and often say it wrongly: some triangles the other way
//! round, every triangle twice with both orders (a two-sided sheet), a part inside out. Where the
//! surface itself tells, the order is mended: neighbours face the same way, and a closed part faces
//! outwards unless it is a cavity, which lies within another. The mended surface, mended again,
//! stays as it is.

use std::collections::HashMap;

use super::edges::{Edges, Triangle};
use super::parts::Parts;
use super::patches::Patches;
use super::volume::six_fold;
use crate::math::Vec3;

/// What was found and mended.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Mended {
    /// Triangles that came twice in the same order; one of each stays.
    pub repeated: usize,
    /// Triangles of closed surfaces that came in both orders; one of each stays, facing outwards.
    pub doubled: usize,
    /// Triangles of sheets that came in both orders; both stay, and have no inside.
    pub sheets: usize,
    /// Triangles that were turned over.
    pub turned: usize,
}

/// Mends the order of corners; `edges` are those of the triangles as they came.
pub(super) fn mend(vertices: &[Vec3], triangles: &mut Vec<Triangle>, edges: &Edges) -> Mended {
    let mut mended = Mended::default();
    if edges.crowded > 0 {
        single_out(triangles, &mut mended);
    }
    if edges.turned + mended.doubled > 0 || is_mixed(vertices, triangles) {
        mended.turned = turn(vertices, triangles);
    }
    mended
}

/// Turns triangles over until they face as they should; how many.
fn turn(vertices: &[Vec3], triangles: &mut [Triangle]) -> usize {
    let before = triangles.to_vec();
    let patches = Patches::of(triangles);
    patches.face_one_way(triangles);
    patches.face_outwards(vertices, triangles);
    let pairs = before.iter().zip(&*triangles);
    pairs
        .filter(|(before, after)| before != after)
        .count()
}

/// The same triangle, whatever the order of its corners; and whether this order is even.
fn unordered([a, b, c]: Triangle) -> (Triangle, bool) {
    let mut sorted = [a, b, c];
    sorted.sort_unstable();
    (sorted, [[a, b, c], [b, c, a], [c, a, b]].contains(&sorted))
}

/// How often triangles come in odd and in even order.
#[derive(Default)]
struct Times(HashMap<Triangle, [usize; 2]>);

impl Times {
    /// Counts a triangle; whether it is the first in its order.
    fn is_first(&mut self, triangle: Triangle) -> bool {
        let (key, is_even) = unordered(triangle);
        let times = &mut self.0.entry(key).or_default()[usize::from(is_even)];
        *times += 1;
        *times == 1
    }

    /// Whether a triangle is the even one of two that came in both orders.
    fn is_even_of_both(&self, triangle: Triangle) -> bool {
        let (key, is_even) = unordered(triangle);
        is_even && self.0[&key].iter().all(|times| *times > 0)
    }
}

/// Leaves one of each triangle that comes several times in one order, if that closes the surface
/// (two solids may share a face); of those in both orders, both, unless they close a surface.
fn single_out(triangles: &mut Vec<Triangle>, mended: &mut Mended) {
    let mut times = Times::default();
    let mut once = triangles.clone();
    once.retain(|&triangle| times.is_first(triangle));
    if once.len() < triangles.len() && Edges::of(&once).open < Edges::of(triangles).open {
        mended.repeated = triangles.len() - once.len();
        *triangles = once;
    }
    drop_doubled(triangles, &times, mended);
}

/// Leaves the even one of each two triangles in both orders that close a surface.
fn drop_doubled(triangles: &mut Vec<Triangle>, times: &Times, mended: &mut Mended) {
    let mut both = triangles.clone();
    both.retain(|&triangle| times.is_even_of_both(triangle));
    let closed = closed(&both);
    mended.doubled = closed
        .values()
        .filter(|is_closed| **is_closed)
        .count();
    mended.sheets = closed.len() - mended.doubled;
    triangles.retain(|&triangle| {
        let (key, is_even) = unordered(triangle);
        is_even
            || !closed
                .get(&key)
                .is_some_and(|is_closed| *is_closed)
    });
}

/// Whether the triangles that hang together with one close a surface.
fn closed(triangles: &[Triangle]) -> HashMap<Triangle, bool> {
    let are_closed = Patches::by_edges(triangles, |_| true).closed();
    let keys = triangles
        .iter()
        .map(|&triangle| unordered(triangle).0);
    keys.zip(are_closed).collect()
}

/// Whether connected parts enclose volumes of both signs.
fn is_mixed(vertices: &[Vec3], triangles: &[Triangle]) -> bool {
    let mut parts = Parts::apart(vertices.len());
    for triangle in triangles {
        parts.join(triangle.iter().map(|&i| i as usize));
    }
    let mut volumes = vec![0.0; vertices.len()];
    for triangle in triangles {
        let part = parts.of(triangle[0] as usize);
        volumes[part] += six_fold(vertices, triangle, vertices[part]);
    }
    volumes.iter().any(|volume| *volume > 0.0) && volumes.iter().any(|volume| *volume < 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::Mesh;
    use super::*;

    /// A box with one corner at `low`, facing outwards.
    fn cuboid(low: Vec3, size: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let corner =
            |i: u32| low + Vec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) * size;
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

    fn over(faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
        faces
            .iter()
            .map(|&[a, b, c]| [a, c, b])
            .collect()
    }

    fn joined(parts: &[(Vec<Vec3>, Vec<[u32; 3]>)]) -> Mesh {
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
        for (corners, faces) in parts {
            let first = vertices.len() as u32;
            vertices.extend(corners);
            triangles.extend(faces.iter().map(|face| face.map(|i| first + i)));
        }
        Mesh::new("cup", vertices, triangles).unwrap()
    }

    /// The mesh, made again of what it was made to, is the same: what is sent and kept has the same
    /// hash.
    fn assert_settled(mesh: &Mesh) {
        let again = Mesh::new("cup", mesh.vertices().to_vec(), mesh.triangles().to_vec()).unwrap();
        assert_eq!(
            (again.hash(), again.has_inside()),
            (mesh.hash(), mesh.has_inside())
        );
        let kept = Mesh::restore(
            "cup".into(),
            mesh.vertices().to_vec(),
            mesh.triangles().to_vec(),
            Vec::new(),
        );
        assert_eq!(kept.unwrap().has_inside(), mesh.has_inside());
    }

    #[test]
    fn triangles_that_face_opposite_ways_are_turned_as_most_do() {
        let (vertices, faces) = cuboid(Vec3::ZERO, Vec3::ONE);
        for seed in 0..64_u64 {
            let mut rng = fastrand::Rng::with_seed(seed);
            let mixed = faces
                .iter()
                .map(|&[a, b, c]| if rng.bool() { [a, c, b] } else { [a, b, c] })
                .collect();
            let mesh = Mesh::new("cup", vertices.clone(), mixed).unwrap();
            assert!(
                mesh.has_inside() && (mesh.signed_volume().abs() - 1.0).abs() < 1e-12,
                "seed {seed}"
            );
            assert_settled(&mesh);
        }
    }

    #[test]
    fn a_closed_surface_of_two_sided_triangles_is_a_solid_and_a_sheet_is_not() {
        let (vertices, faces) = cuboid(Vec3::ZERO, Vec3::ONE);
        let both = [faces.clone(), over(&faces)].concat();
        let mesh = Mesh::new("cup", vertices.clone(), both).unwrap();
        assert!(mesh.has_inside() && mesh.triangles().len() == 12);
        assert!(
            mesh.warnings()[0].contains("12 triangles twice")
                && mesh.warnings()[0].contains("solid"),
            "{mesh:?}"
        );
        assert_settled(&mesh);
        let lid = [faces[..2].to_vec(), over(&faces[..2])].concat();
        let mesh = Mesh::new("cup", vertices.clone(), lid).unwrap();
        assert!(!mesh.has_inside() && mesh.triangles().len() == 4);
        assert!(
            mesh.warnings()[0].contains("2 triangles twice")
                && mesh.warnings()[0].contains("no inside"),
            "{mesh:?}"
        );
        assert_settled(&mesh);
        // A solid in which a two-sided shelf stands stays a solid.
        let shelf = (
            vec![Vec3::splat(0.2), Vec3::splat(0.4), Vec3::new(0.2, 0.4, 0.2)],
            vec![[0, 1, 2], [0, 2, 1]],
        );
        let mesh = joined(&[(vertices, faces), shelf]);
        assert!(
            mesh.has_inside() && mesh.triangles().len() == 14,
            "{mesh:?}"
        );
        assert_settled(&mesh);
    }

    #[test]
    fn solids_may_share_a_face_and_a_stray_triangle_goes() {
        let (vertices, faces) = cuboid(Vec3::ZERO, Vec3::ONE);
        let beside = cuboid(Vec3::X, Vec3::ONE);
        let mesh = joined(&[(vertices.clone(), faces.clone()), beside]);
        assert!(
            mesh.has_inside() && (mesh.signed_volume() - 2.0).abs() < 1e-12,
            "{mesh:?}"
        );
        assert_settled(&mesh);
        let stray = [faces.clone(), faces[3..4].to_vec()].concat();
        let mesh = Mesh::new("cup", vertices, stray).unwrap();
        assert!(
            mesh.has_inside() && mesh.triangles().len() == 12,
            "{mesh:?}"
        );
    }

    #[test]
    fn a_part_inside_out_is_turned_over_and_a_cavity_is_not() {
        let outer = cuboid(Vec3::ZERO, Vec3::ONE);
        let (vertices, faces) = cuboid(Vec3::splat(0.25), Vec3::splat(0.5));
        let hollow = joined(&[outer.clone(), (vertices, over(&faces))]);
        assert!(
            hollow.has_inside() && hollow.warnings().is_empty(),
            "{:?}",
            hollow.warnings()
        );
        assert!((hollow.signed_volume() - 0.875).abs() < 1e-12);
        let (vertices, faces) = cuboid(Vec3::splat(2.0), Vec3::splat(0.5));
        let beside = joined(&[outer, (vertices, over(&faces))]);
        assert!((beside.signed_volume() - 1.125).abs() < 1e-12);
        assert!(
            beside.warnings()[0].contains("no cavities, 12 triangles"),
            "{:?}",
            beside.warnings()
        );
        assert_settled(&beside);
    }

    #[test]
    fn a_band_with_one_side_and_a_flat_surface_have_no_inside() {
        let count = 12_u32;
        let rim = |i: u32, side: f64| {
            let turn = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
            let out = Vec3::new(turn.cos(), turn.sin(), 0.0);
            out + (out * (turn / 2.0).cos() + Vec3::Z * (turn / 2.0).sin()) * (0.3 * side)
        };
        let vertices: Vec<Vec3> = (0..count)
            .flat_map(|i| [rim(i, -1.0), rim(i, 1.0)])
            .collect();
        let quad = |i: u32| {
            let [a, b] = [2 * i, 2 * i + 1];
            // After one turn the band comes back with its sides changed.
            let [c, d] = if i + 1 < count {
                [2 * i + 2, 2 * i + 3]
            } else {
                [1, 0]
            };
            [[a, b, d], [a, d, c]]
        };
        let band = Mesh::new("cup", vertices, (0..count).flat_map(quad).collect()).unwrap();
        assert!(!band.has_inside());
        assert!(
            band.warnings()
                .iter()
                .any(|text| text.contains("opposite ways") && text.contains("no turning"))
        );
        assert_settled(&band);
        let (vertices, faces) = cuboid(Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0));
        let mut distinct = vertices;
        distinct
            .iter_mut()
            .enumerate()
            .for_each(|(i, v)| *v += Vec3::X * 1e-3 * (i as f64) * v.y);
        let flat = Mesh::new("cup", distinct, faces).unwrap();
        assert!(
            !flat.has_inside() && flat.warnings()[0].contains("encloses no volume"),
            "{:?}",
            flat.warnings()
        );
    }
}

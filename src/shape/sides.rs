//! Which way the triangles of a surface face, and whether it has an inside.
//!
//! Files say it by the order of corners, and often say it wrongly: some triangles the other way
//! round, every triangle twice with both orders (a two-sided sheet), a part inside out. Where the
//! surface itself tells, the order is mended: neighbours face the same way, and a closed part faces
//! outwards unless it is a cavity, which lies within another. The mended surface, mended again,
//! stays as it is.

use std::collections::HashMap;

use super::oddities::Edges;
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

/// A surface encloses less than this part of its size cubed: none.
const NO_VOLUME: f64 = 1e-12;

/// Whether triangles enclose no volume.
pub(super) fn is_flat(vertices: &[Vec3], triangles: &[[u32; 3]]) -> bool {
    let corners = triangles.iter().flatten().map(|&i| vertices[i as usize]);
    let (low, high) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    volume(vertices, triangles.iter()).abs() <= NO_VOLUME * (high - low).length().powi(3)
}

/// Volume that triangles enclose (m³); negative where they face inwards.
pub(super) fn volume<'t>(
    vertices: &[Vec3],
    mut triangles: impl Iterator<Item = &'t [u32; 3]>,
) -> f64 {
    let Some(first) = triangles.next() else {
        return 0.0;
    };
    let origin = vertices[first[0] as usize];
    let six_fold = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| vertices[i as usize] - origin);
        a.dot(b.cross(c))
    };
    // The first one has a corner at the origin.
    triangles.map(six_fold).sum::<f64>() / 6.0
}

/// Mends the order of corners; `edges` are those of the triangles as they came.
pub(super) fn mend(vertices: &[Vec3], triangles: &mut Vec<[u32; 3]>, edges: &Edges) -> Mended {
    let mut mended = Mended::default();
    if edges.crowded > 0 {
        single_out(triangles, &mut mended);
    }
    if edges.turned + mended.doubled > 0 || is_mixed(vertices, triangles) {
        let before = triangles.clone();
        let patches = Patches::of(triangles);
        patches.face_one_way(triangles);
        patches.face_outwards(vertices, triangles);
        mended.turned = before
            .iter()
            .zip(&*triangles)
            .filter(|(before, after)| before != after)
            .count();
    }
    mended
}

/// The same triangle, whatever the order of its corners; and whether this order is even.
fn unordered([a, b, c]: [u32; 3]) -> ([u32; 3], bool) {
    let mut sorted = [a, b, c];
    sorted.sort_unstable();
    (sorted, [[a, b, c], [b, c, a], [c, a, b]].contains(&sorted))
}

/// Leaves one of each triangle that comes several times in one order, if that closes the surface
/// (two solids may share a face); of those in both orders, both, unless they close a surface.
fn single_out(triangles: &mut Vec<[u32; 3]>, mended: &mut Mended) {
    let mut seen: HashMap<[u32; 3], [usize; 2]> = HashMap::new();
    let mut once = triangles.clone();
    once.retain(|&triangle| {
        let (key, is_even) = unordered(triangle);
        let times = &mut seen.entry(key).or_default()[usize::from(is_even)];
        *times += 1;
        *times == 1
    });
    if once.len() < triangles.len() && Edges::of(&once).open < Edges::of(triangles).open {
        mended.repeated = triangles.len() - once.len();
        *triangles = once;
    }
    let both: Vec<[u32; 3]> = triangles
        .iter()
        .copied()
        .filter(|&triangle| {
            unordered(triangle).1 && seen[&unordered(triangle).0].iter().all(|times| *times > 0)
        })
        .collect();
    let patches = Patches::by_edges(&both, |_| true);
    let mut open = vec![false; both.len()];
    for edge in patches.edges.chunk_by(|a, b| a.edge == b.edge) {
        open[patches.of[edge[0].triangle]] |= edge.len() % 2 == 1;
    }
    let closed: HashMap<[u32; 3], bool> = both
        .iter()
        .enumerate()
        .map(|(at, &triangle)| (unordered(triangle).0, !open[patches.of[at]]))
        .collect();
    mended.doubled = closed.values().filter(|is_closed| **is_closed).count();
    mended.sheets = closed.len() - mended.doubled;
    triangles.retain(|&triangle| {
        let (key, is_even) = unordered(triangle);
        is_even || !closed.get(&key).is_some_and(|is_closed| *is_closed)
    });
}

/// Whether connected parts enclose volumes of both signs.
fn is_mixed(vertices: &[Vec3], triangles: &[[u32; 3]]) -> bool {
    let mut parent: Vec<usize> = (0..vertices.len()).collect();
    for triangle in triangles {
        join(&mut parent, triangle.iter().map(|&i| i as usize));
    }
    let mut volumes = vec![0.0; vertices.len()];
    for triangle in triangles {
        let part = root(&mut parent, triangle[0] as usize);
        let [a, b, c] = triangle.map(|i| vertices[i as usize] - vertices[part]);
        volumes[part] += a.dot(b.cross(c));
    }
    volumes.iter().any(|volume| *volume > 0.0) && volumes.iter().any(|volume| *volume < 0.0)
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

fn join(parent: &mut [usize], members: impl Iterator<Item = usize>) {
    let mut one = None;
    for member in members {
        let root_of_member = root(parent, member);
        let least = one.map_or(root_of_member, |other: usize| {
            root(parent, other).min(root_of_member)
        });
        if let Some(other) = one {
            let other = root(parent, other);
            parent[other] = least;
        }
        parent[root_of_member] = least;
        one = Some(least);
    }
}

/// A side of a triangle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    edge: [u32; 2],
    triangle: usize,
    is_forward: bool,
}

/// Triangles that hang together by edges of two of them.
struct Patches {
    /// All sides, in order of edges.
    edges: Vec<Side>,
    /// The patch of each triangle: the first triangle of it.
    of: Vec<usize>,
}

impl Patches {
    fn of(triangles: &[[u32; 3]]) -> Self {
        Self::by_edges(triangles, |count| count == 2)
    }

    /// Joined by the edges of as many triangles as `joins` says.
    fn by_edges(triangles: &[[u32; 3]], joins: impl Fn(usize) -> bool) -> Self {
        let sides = |(triangle, &[a, b, c]): (usize, &[u32; 3])| {
            [(a, b), (b, c), (c, a)].map(|(from, to)| {
                let edge = [from.min(to), from.max(to)];
                Side {
                    edge,
                    triangle,
                    is_forward: from < to,
                }
            })
        };
        let mut edges: Vec<Side> = triangles.iter().enumerate().flat_map(sides).collect();
        edges.sort_unstable();
        let mut parent: Vec<usize> = (0..triangles.len()).collect();
        for edge in edges
            .chunk_by(|a, b| a.edge == b.edge)
            .filter(|edge| joins(edge.len()))
        {
            join(&mut parent, edge.iter().map(|side| side.triangle));
        }
        let of = (0..triangles.len())
            .map(|triangle| root(&mut parent, triangle))
            .collect();
        Self { edges, of }
    }

    /// Turns triangles over so that those of a patch face the same way, as most of them did; a
    /// patch in which that cannot be stays as it is.
    fn face_one_way(&self, triangles: &mut [[u32; 3]]) {
        let mut neighbours: Vec<Vec<(usize, bool)>> = vec![Vec::new(); triangles.len()];
        for edge in self.edges.chunk_by(|a, b| a.edge == b.edge) {
            if let [a, b] = edge {
                let agree = a.is_forward != b.is_forward;
                neighbours[a.triangle].push((b.triangle, agree));
                neighbours[b.triangle].push((a.triangle, agree));
            }
        }
        let mut turned: Vec<Option<bool>> = vec![None; triangles.len()];
        for first in 0..triangles.len() {
            if turned[first].is_some() {
                continue;
            }
            turned[first] = Some(false);
            let mut patch = vec![first];
            let mut next = 0;
            let mut can_be = true;
            while let Some(&triangle) = patch.get(next) {
                next += 1;
                for &(other, agree) in &neighbours[triangle] {
                    let wanted = (turned[triangle] == Some(true)) == agree;
                    match turned[other] {
                        None => {
                            turned[other] = Some(wanted);
                            patch.push(other);
                        }
                        Some(is) => can_be &= is == wanted,
                    }
                }
            }
            let count = patch
                .iter()
                .filter(|triangle| turned[**triangle] == Some(true))
                .count();
            let most = 2 * count > patch.len();
            for triangle in patch
                .into_iter()
                .filter(|triangle| can_be && (turned[*triangle] == Some(true)) != most)
            {
                triangles[triangle].swap(1, 2);
            }
        }
    }

    /// Turns closed patches over that face the other way than the whole, unless they lie within it:
    /// cavities.
    fn face_outwards(&self, vertices: &[Vec3], triangles: &mut [[u32; 3]]) {
        let mut members: HashMap<usize, Vec<usize>> = HashMap::new();
        self.of
            .iter()
            .enumerate()
            .for_each(|(triangle, patch)| members.entry(*patch).or_default().push(triangle));
        let mut closed: Vec<Patch> = members
            .into_values()
            .filter_map(|members| Patch::closed(vertices, triangles, members))
            .collect();
        closed.sort_by_key(|patch| patch.members[0]);
        let sign = closed
            .iter()
            .map(|patch| patch.volume)
            .sum::<f64>()
            .signum();
        let (facing, other): (Vec<Patch>, Vec<Patch>) = closed
            .into_iter()
            .partition(|patch| patch.volume * sign >= 0.0);
        for patch in other {
            let point = vertices[triangles[patch.members[0]][0] as usize];
            let around = facing.iter().filter(|outer| {
                outer.low.cmple(patch.low).all() && patch.high.cmple(outer.high).all()
            });
            let around = around
                .flat_map(|outer| &outer.members)
                .map(|&triangle| triangles[triangle]);
            let angle: f64 = around
                .map(|t| solid_angle(t.map(|i| vertices[i as usize] - point)))
                .sum();
            if angle.abs() < 2.0 * std::f64::consts::PI {
                patch
                    .members
                    .iter()
                    .for_each(|&triangle| triangles[triangle].swap(1, 2));
            }
        }
    }
}

/// A closed patch.
struct Patch {
    members: Vec<usize>,
    volume: f64,
    low: Vec3,
    high: Vec3,
}

impl Patch {
    fn closed(vertices: &[Vec3], triangles: &[[u32; 3]], members: Vec<usize>) -> Option<Self> {
        let own: Vec<[u32; 3]> = members
            .iter()
            .map(|&triangle| triangles[triangle])
            .collect();
        let edges = Edges::of(&own);
        if edges.open + edges.turned > 0 {
            return None;
        }
        let corners = own.iter().flatten().map(|&i| vertices[i as usize]);
        let (low, high) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        });
        Some(Self {
            members,
            volume: volume(vertices, own.iter()),
            low,
            high,
        })
    }
}

/// Signed solid angle of a triangle seen from the origin (van Oosterom and Strackee, 1983).
pub fn solid_angle([a, b, c]: [Vec3; 3]) -> f64 {
    let la = a.length();
    let lb = b.length();
    let lc = c.length();
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * a.dot(b.cross(c)).atan2(denominator)
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
        faces.iter().map(|&[a, b, c]| [a, c, b]).collect()
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

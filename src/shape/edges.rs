//! How the triangles of a surface meet at their edges.

/// The vertices of a triangle, by their places, as it walks around them.
pub(super) type Triangle = [u32; 3];

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
    pub(super) fn of(triangles: &[Triangle]) -> Self {
        let mut walks: Vec<Walk> = triangles
            .iter()
            .flat_map(Walk::around)
            .collect();
        walks.sort_unstable();
        let mut edges = Self::default();
        walks
            .chunk_by(|a, b| a.edge == b.edge)
            .for_each(|edge| edges.count(edge));
        edges
    }

    fn count(&mut self, edge: &[Walk]) {
        let forward = edge
            .iter()
            .filter(|walk| walk.is_forward)
            .count();
        let is_even = edge.len().is_multiple_of(2);
        self.all += 1;
        self.open += usize::from(!is_even);
        self.turned += usize::from(is_even && 2 * forward != edge.len());
        self.crowded += usize::from(edge.len() > 2);
    }

    /// Whether the surface has no border and its triangles face the same way.
    pub(super) fn are_closed(&self) -> bool {
        self.open + self.turned == 0
    }
}

/// An edge as one of its triangles walks it; in one number, since large meshes sort many.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Walk {
    edge: u64,
    is_forward: bool,
}

impl Walk {
    fn around(triangle: &Triangle) -> [Self; 3] {
        walks(triangle).map(|(from, to)| Self {
            edge: u64::from(from.min(to)) << 32 | u64::from(from.max(to)),
            is_forward: from < to,
        })
    }
}

/// A side of a triangle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    /// Its vertices, the lower one first.
    pub edge: [u32; 2],
    /// Which triangle.
    pub triangle: usize,
    /// Whether the triangle walks it from the lower vertex to the higher.
    pub is_forward: bool,
}

impl Side {
    /// All sides of triangles, in order of edges.
    pub(super) fn all(triangles: &[Triangle]) -> Vec<Self> {
        let triangles = triangles.iter().enumerate();
        let mut sides: Vec<Self> = triangles
            .flat_map(|(at, triangle)| Self::around(at, triangle))
            .collect();
        sides.sort_unstable();
        sides
    }

    fn around(triangle: usize, corners: &Triangle) -> [Self; 3] {
        walks(corners).map(|(from, to)| Self {
            edge: [from.min(to), from.max(to)],
            triangle,
            is_forward: from < to,
        })
    }
}

/// The sides of a triangle as it walks around them.
fn walks(&[a, b, c]: &Triangle) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

//! What sensors see: points that stand for balls of one radius, or the occupied cells of a map.
//!
//! Both are cells, cubes about a centre swept by a ball: a point is a cube of size 0, a cell of a
//! map a cube swept by (almost) nothing. Cells stand along a curve that fills space, eight together, so that
//! neighbours in memory are neighbours in space, and trees over them need no links.
//!
//! Centres are f32 about an origin near them. What that rounds, and what it rounds of half sizes, is added to the ball's
//! radius: a cloud holds all that was given, whatever its coordinates are, and is larger by millionths of a millimetre in a room.

mod error;
mod order;
mod provenance;

pub use error::CloudError;
pub use provenance::{Making, Provenance, Source, Unknown};

use crate::hash::ContentHasher;
use crate::math::Vec3;
use order::{in_order, low_and_high};

/// Cells that stand together.
pub const OCTET: usize = 8;

/// Most cells of a cloud.
pub const MOST_CELLS: usize = 1 << 24;

/// What coordinates may lose to their rounding, as a part of a point's radius or of half a cell.
const MOST_ROUNDING: f64 = 0.05;

/// A cell of a map: a cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Voxel {
    /// Its middle, in the map's frame (m).
    pub center: [f64; 3],
    /// Its full size (m): leaves of an octree differ.
    pub size: f64,
}

/// Points or voxels that stand still relative to each other: one shape, however many there are.
#[derive(Clone, Debug, PartialEq)]
pub struct Cloud {
    kind: CloudKind,
    origin: Vec3,
    rounding: f64,
    centers: Vec<[[f32; OCTET]; 3]>,
    halves: Vec<[f32; OCTET]>,
    numbers: Vec<u32>,
    hash: u64,
    provenance: Provenance,
}

/// What the cells of a cloud stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CloudKind {
    /// Balls about points.
    Points {
        /// Of each of them (m).
        radius: f64,
    },
    /// Cubes.
    Voxels,
}

/// A cloud as plain data: what it is restored from, bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub struct CloudParts {
    /// What its cells stand for.
    pub kind: CloudKind,
    /// Where their coordinates begin (m).
    pub origin: [f64; 3],
    /// What these lost (m).
    pub rounding: f64,
    /// Centre and half size of each cell (m), in the order of space.
    pub cells: Vec<[f32; 4]>,
    /// The number that each had among those given.
    pub numbers: Vec<u32>,
}

/// One cell, about the cloud's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Its middle (m).
    pub center: Vec3,
    /// Half of its size (m), 0 for a point.
    pub half: f64,
}

impl Cloud {
    /// Balls of `radius` (m) about points (m, in the cloud's own frame).
    ///
    /// # Errors
    /// No point or more than [`MOST_CELLS`]; a coordinate that is not finite; a radius that is not finite
    /// and greater than 0; points so far apart that f32 cannot tell a twentieth of the radius.
    pub fn of_points(
        points: impl IntoIterator<Item = [f64; 3]>,
        radius: f64,
    ) -> Result<Self, CloudError> {
        if !(radius.is_finite() && radius > 0.0) {
            return Err(CloudError::Radius(radius));
        }
        let points: Vec<_> = points
            .into_iter()
            .map(Vec3::from_array)
            .collect();
        let cloud = Self::build(CloudKind::Points { radius }, &points, |_| 0.0)?;
        cloud.checked(radius)
    }

    /// Cubes (m, in the map's own frame).
    ///
    /// # Errors
    /// No voxel or more than [`MOST_CELLS`]; a centre that is not finite; a size that is not finite and
    /// greater than 0; voxels so far apart that f32 cannot tell a fortieth of the smallest of them.
    pub fn of_voxels(voxels: &[Voxel]) -> Result<Self, CloudError> {
        let is_bad = |voxel: &&Voxel| !(voxel.size.is_finite() && voxel.size > 0.0);
        if let Some(bad) = voxels.iter().find(is_bad) {
            return Err(CloudError::Size(bad.size));
        }
        let centers: Vec<_> = voxels
            .iter()
            .map(|voxel| Vec3::from_array(voxel.center))
            .collect();
        let cloud = Self::build(CloudKind::Voxels, &centers, |index| {
            voxels[index].size / 2.0
        })?;
        let smallest = voxels
            .iter()
            .map(|voxel| voxel.size)
            .fold(f64::INFINITY, f64::min);
        cloud.checked(smallest / 2.0)
    }

    fn build(
        kind: CloudKind,
        centers: &[Vec3],
        half: impl Fn(usize) -> f64,
    ) -> Result<Self, CloudError> {
        check(centers)?;
        let corners = low_and_high(centers);
        let origin = origin_of(corners);
        let numbers = in_order(centers, corners);
        let mut cloud = Self::empty(kind, origin, numbers);
        let order = std::mem::take(&mut cloud.numbers);
        let cell = |place: usize| {
            let number = order[place] as usize;
            (centers[number] - origin, half(number))
        };
        let lost = cloud.fill(order.len(), cell);
        cloud.numbers = order;
        // Differences and sums with the origin round too, by less than a last bit of each number.
        let largest = corners[0]
            .abs()
            .max(corners[1].abs())
            .max(origin.abs());
        cloud.rounding = lost + 4.0 * f64::EPSILON * largest.length();
        cloud.hash = cloud.content();
        Ok(cloud)
    }

    /// Room for so many cells.
    fn empty(kind: CloudKind, origin: Vec3, numbers: Vec<u32>) -> Self {
        let octets = numbers.len().div_ceil(OCTET);
        let halves = match kind {
            CloudKind::Points { .. } => 0,
            CloudKind::Voxels => octets,
        };
        Self {
            kind,
            origin,
            rounding: 0.0,
            centers: vec![[[0.0; OCTET]; 3]; octets],
            halves: vec![[0.0; OCTET]; halves],
            numbers,
            hash: 0,
            provenance: Provenance::default(),
        }
    }

    /// Writes so many cells, given by place, with their half sizes; places beyond the last repeat it.
    /// At most by how much one is larger than what is written (m).
    fn fill(&mut self, count: usize, cell: impl Fn(usize) -> (Vec3, f64)) -> f64 {
        let mut lost = Vec3::ZERO;
        let mut thinner = 0.0_f64;
        for place in 0..self.centers.len() * OCTET {
            let (octet, lane) = (place / OCTET, place % OCTET);
            let (center, half) = cell(place.min(count - 1));
            let single = center.to_array().map(|value| value as f32);
            let axes = self.centers[octet].iter_mut();
            axes.zip(single)
                .for_each(|(axis, value)| axis[lane] = value);
            let written = Vec3::from_array(single.map(f64::from));
            lost = lost.max((written - center).abs());
            if let Some(halves) = self.halves.get_mut(octet) {
                halves[lane] = half as f32;
                thinner = thinner.max(half - f64::from(halves[lane]));
            }
        }
        lost.length() + thinner * 3.0_f64.sqrt()
    }

    /// The cloud, unless it is too wide for its cells.
    fn checked(self, least: f64) -> Result<Self, CloudError> {
        match self.rounding <= MOST_ROUNDING * least {
            true => Ok(self),
            false => Err(CloudError::Wide {
                rounding: self.rounding,
                least,
            }),
        }
    }

    /// By content.
    fn content(&self) -> u64 {
        let mut hasher = ContentHasher::default();
        let radius = match self.kind {
            CloudKind::Points { radius } => radius,
            CloudKind::Voxels => 0.0,
        };
        hasher
            .text("cloud")
            .count(self.len())
            .floats(&[radius, self.rounding])
            .floats(&self.origin.to_array())
            .singles(self.centers.as_flattened().as_flattened())
            .singles(self.halves.as_flattened());
        hasher.finish()
    }

    /// What its cells stand for.
    pub fn kind(&self) -> CloudKind {
        self.kind
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.numbers.len()
    }

    /// Never: a cloud has at least one cell.
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// Where its cells' coordinates begin, in its own frame (m).
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// Radius of the ball that sweeps every cell (m): that of its points, and what their coordinates lost.
    pub fn radius(&self) -> f64 {
        match self.kind {
            CloudKind::Points { radius } => radius + self.rounding,
            CloudKind::Voxels => self.rounding,
        }
    }

    /// Centres of cells about the origin (m), eight together, by axis; places beyond the last cell repeat it.
    pub fn centers(&self) -> &[[[f32; OCTET]; 3]] {
        &self.centers
    }

    /// Half sizes of cells (m), eight together; empty for points.
    pub fn halves(&self) -> &[[f32; OCTET]] {
        &self.halves
    }

    /// One cell by its place in the order of space.
    pub fn cell(&self, place: usize) -> Cell {
        let (octet, lane) = (place / OCTET, place % OCTET);
        let center = self.centers[octet].map(|axis| f64::from(axis[lane]));
        Cell {
            center: Vec3::from_array(center),
            half: self
                .halves
                .get(octet)
                .map_or(0.0, |halves| f64::from(halves[lane])),
        }
    }

    /// The number that the cell at a place had among those given, from 0.
    pub fn number(&self, place: usize) -> usize {
        self.numbers[place] as usize
    }

    /// The same cloud with what is known of it besides.
    #[must_use]
    pub fn with_provenance(self, provenance: Provenance) -> Self {
        Self { provenance, ..self }
    }

    /// What is known of it besides its cells.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// Whether the cell at a place is one that nobody has seen.
    pub fn is_unknown(&self, place: usize) -> bool {
        let from = self.provenance.unknown_from;
        from.is_some_and(|from| self.number(place) >= from)
    }

    /// What the cell at a place is, for messages.
    pub fn words(&self, place: usize) -> String {
        let size = 2.0 * (self.cell(place).half as f32);
        match (self.kind, self.is_unknown(place)) {
            (CloudKind::Points { .. }, _) => {
                format!("point {} (counted from 0)", self.number(place))
            }
            (CloudKind::Voxels, false) => format!("an occupied cell of {size} m"),
            (CloudKind::Voxels, true) => format!("an unknown cell of {size} m"),
        }
    }

    /// Content hash.
    pub fn hash(&self) -> u64 {
        self.hash
    }

    /// Memory that it takes (bytes).
    pub fn bytes(&self) -> usize {
        size_of::<Self>()
            + size_of_val(&*self.centers)
            + size_of_val(&*self.halves)
            + size_of_val(&*self.numbers)
    }

    /// It as plain data.
    pub fn parts(&self) -> CloudParts {
        let cell = |place: usize| {
            let (octet, lane) = (place / OCTET, place % OCTET);
            let [x, y, z] = self.centers[octet].map(|axis| axis[lane]);
            [
                x,
                y,
                z,
                self.halves
                    .get(octet)
                    .map_or(0.0, |halves| halves[lane]),
            ]
        };
        CloudParts {
            kind: self.kind,
            origin: self.origin.to_array(),
            rounding: self.rounding,
            cells: (0..self.len()).map(cell).collect(),
            numbers: self.numbers.clone(),
        }
    }

    /// The cloud of its parts.
    ///
    /// # Errors
    /// Parts that are no cloud's.
    pub fn restore(parts: &CloudParts) -> Result<Self, CloudError> {
        let center = |place: usize| {
            let [x, y, z, _] = parts.cells[place].map(f64::from);
            Vec3::new(x, y, z)
        };
        let cell = |place: usize| (center(place), parts.cells[place][3].into());
        check(
            &(0..parts.cells.len())
                .map(center)
                .collect::<Vec<_>>(),
        )?;
        let origin = Vec3::from_array(parts.origin);
        let mut cloud = Self::empty(parts.kind, origin, parts.numbers.clone());
        cloud.fill(parts.cells.len(), cell);
        cloud.rounding = parts.rounding;
        cloud.hash = cloud.content();
        Ok(cloud)
    }

    /// The same cloud so many times as large, about the mean of its cells' centres.
    ///
    /// # Errors
    /// As of the constructors.
    pub fn scaled(&self, scale: f64) -> Result<Self, CloudError> {
        let mut cells: Vec<_> = (0..self.len())
            .map(|place| (self.number(place), self.cell(place)))
            .collect();
        cells.sort_unstable_by_key(|(number, _)| *number);
        let sum: Vec3 = cells.iter().map(|(_, cell)| cell.center).sum();
        let mean = sum / cells.len() as f64;
        let moved = |cell: &Cell| (self.origin + mean + (cell.center - mean) * scale).to_array();
        match self.kind {
            CloudKind::Points { .. } => {
                let points = cells.iter().map(|(_, cell)| moved(cell));
                Self::of_points(points, self.radius() * scale)
            }
            CloudKind::Voxels => {
                let size = |cell: &Cell| 2.0 * (cell.half + self.rounding) * scale;
                let voxel = |(_, cell): &(usize, Cell)| Voxel {
                    center: moved(cell),
                    size: size(cell),
                };
                Self::of_voxels(&cells.iter().map(voxel).collect::<Vec<_>>())
            }
        }
    }
}

/// Whether these can be the centres of a cloud's cells.
fn check(centers: &[Vec3]) -> Result<(), CloudError> {
    match centers.len() {
        0 => return Err(CloudError::Empty),
        count if count > MOST_CELLS => return Err(CloudError::TooMany(count)),
        _ => {}
    }
    match centers
        .iter()
        .position(|center| !center.is_finite())
    {
        Some(index) => Err(CloudError::NotFinite {
            index,
            point: centers[index].to_array(),
        }),
        None => Ok(()),
    }
}

/// Where coordinates begin: at the frame's own origin where that is not far from the cells, as with what a sensor sees, whose numbers are then as they
/// were; else at whole metres in their middle.
fn origin_of([low, high]: [Vec3; 2]) -> Vec3 {
    let middle = (low + high) / 2.0;
    let size = (high - low).length();
    match middle.length() <= 2.0 * size + 1.0 {
        true => Vec3::ZERO,
        false => middle.round(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::vector;

    /// Every cell with all of its rounding holds what was given for it.
    #[test]
    fn a_cloud_holds_what_was_given_wherever_it_is() {
        let mut rng = fastrand::Rng::with_seed(11);
        for far in [0.0, 3.0, 1e4, 6.7e6] {
            let corner = Vec3::new(far, -far / 3.0, far / 100.0);
            for count in [1, 8, 9, 500] {
                let points: Vec<_> = (0..count)
                    .map(|_| (corner + vector(&mut rng, 5.0)).to_array())
                    .collect();
                let cloud = Cloud::of_points(points.iter().copied(), 0.005).unwrap();
                assert!(cloud.radius() < 0.0051 && cloud.len() == count);
                for place in 0..count {
                    let given = Vec3::from_array(points[cloud.number(place)]);
                    let told = cloud.origin() + cloud.cell(place).center;
                    assert!(
                        told.distance(given) <= cloud.radius() - 0.005,
                        "{far}: {given}"
                    );
                }
                let again = Cloud::restore(&cloud.parts()).unwrap();
                assert_eq!(again, cloud);
                assert_eq!(again.hash(), cloud.hash());
            }
        }
    }

    #[test]
    fn voxels_are_covered_by_their_cells() {
        let mut rng = fastrand::Rng::with_seed(12);
        let voxels: Vec<_> = (0..100)
            .map(|index| Voxel {
                center: (vector(&mut rng, 20.0) + Vec3::X * 1e3).to_array(),
                size: 0.08 * f64::from(1 << (index % 3)),
            })
            .collect();
        let cloud = Cloud::of_voxels(&voxels).unwrap();
        for place in 0..cloud.len() {
            let Voxel { center, size } = voxels[cloud.number(place)];
            let cell = cloud.cell(place);
            let off = (cloud.origin() + cell.center - Vec3::from_array(center)).length();
            let thinner = 3.0_f64.sqrt() * (size / 2.0 - cell.half).max(0.0);
            assert!(off + thinner <= cloud.radius() && cloud.radius() < 1e-5);
        }
    }

    #[test]
    fn what_is_no_cloud_is_refused_with_the_number_that_is_wrong() {
        let points = |points: &[[f64; 3]], radius| Cloud::of_points(points.iter().copied(), radius);
        assert_eq!(points(&[], 0.01), Err(CloudError::Empty));
        let nan = points(&[[0.0; 3], [0.0, f64::NAN, 0.0]], 0.01).unwrap_err();
        assert!(
            nan.to_string()
                .starts_with("point 1 is [0.0, NaN, 0.0]"),
            "{nan}"
        );
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let refused = points(&[[0.0; 3]], radius).unwrap_err();
            assert!(matches!(refused, CloudError::Radius(_)), "{refused}");
        }
        let wide = points(&[[0.0; 3], [3e5 + 0.01, 0.1, 1.0 / 3.0]], 0.01).unwrap_err();
        assert!(matches!(wide, CloudError::Wide { .. }), "{wide}");
        let flat = Voxel {
            center: [0.0; 3],
            size: 0.0,
        };
        assert_eq!(Cloud::of_voxels(&[flat]), Err(CloudError::Size(0.0)));
    }

    #[test]
    fn a_cloud_is_scaled_about_the_mean_of_its_cells() {
        let cloud = Cloud::of_points([[1.0, 0.0, 0.0], [3.0, 0.0, 0.0]], 0.1).unwrap();
        let large = cloud.scaled(2.0).unwrap();
        let xs: Vec<_> = (0..2)
            .map(|place| large.cell(place).center.x)
            .collect();
        assert_eq!(xs, [0.0, 4.0]);
        assert!((large.radius() - 0.2).abs() < 1e-6);
    }
}

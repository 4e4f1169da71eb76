//! Obstacles as the filter sees them: boxes and cylinders swept by a ball.

use serde::{Deserialize, Serialize};

use super::cells::CellTree;
use super::core::Enclosure;
use super::piece::Piece;
use super::transform::Transform;
use crate::math::{Mat3, Vec3};

/// A box or cylinder in the world swept by a ball; encloses a part of an obstacle.
#[derive(Clone, Copy, Debug)]
pub struct Hull {
    /// Centre (m).
    pub center: [f32; 3],
    /// Axes by columns; `None` for the world's.
    pub axes: Option<[[f32; 3]; 3]>,
    /// What is swept.
    pub core: HullCore,
    /// Radius of the ball (m).
    pub radius: f32,
}

/// What a hull is made of, in its own axes.
#[derive(Clone, Copy, Debug)]
pub enum HullCore {
    /// Half sizes of a box (m).
    Box([f32; 3]),
    /// A cylinder about the third axis.
    Cylinder {
        /// Radius (m).
        radius: f32,
        /// Half of the height (m).
        half_height: f32,
    },
}

/// An obstacle.
#[derive(Clone, Debug)]
pub struct FilterObject {
    /// Encloses all of it.
    pub hull: Hull,
    /// Boxes that enclose it together, where there is more than the hull.
    pub boxes: Vec<Hull>,
    /// Cells that it is made of, where it is a cloud.
    pub cells: Option<PlacedCells>,
    /// Corners of the hull's bounding box in the world (m).
    pub bounds: [Vec3; 2],
    /// Twice the middle of these, by which trees are sorted (m).
    pub middle: [f64; 3],
    /// The object is what encloses it.
    pub is_exact: bool,
}

/// A cloud that stands in the world.
#[derive(Clone, Debug)]
pub struct PlacedCells {
    /// Its cells, about its origin.
    pub tree: CellTree,
    /// Where the origin is in the world (m).
    pub origin: [f32; 3],
    /// Axes by columns; `None` for the world's.
    pub axes: Option<[[f32; 3]; 3]>,
    /// Radius of the ball that sweeps every cell (m).
    pub radius: f32,
}

impl PlacedCells {
    fn new(tree: &CellTree, place: &Transform) -> Self {
        let single = |v: Vec3| v.to_array().map(|value| value as f32);
        let axes = place.rotation;
        let columns = [axes.x_axis, axes.y_axis, axes.z_axis];
        Self {
            tree: tree.clone(),
            origin: single(place.translation),
            axes: (axes != Mat3::IDENTITY).then(|| columns.map(single)),
            radius: (tree.radius() * (1.0 + ROUNDING)) as f32,
        }
    }
}

/// Boxes over a mesh, each around neighbouring triangles.
const MESH_BOXES: usize = 16;
/// Relative, far above what f32 loses in a box's own numbers.
const ROUNDING: f64 = 4e-7;

/// A hull in f64.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Exact {
    center: Vec3,
    axes: Mat3,
    /// Half sizes of the box around the core.
    half: Vec3,
    radius: f64,
    is_cylinder: bool,
}

impl Exact {
    fn of_piece(piece: &Piece) -> Self {
        let Enclosure {
            center,
            axes,
            half,
            is_cylinder,
        } = piece.core.enclosure();
        let exact = Self {
            center,
            axes,
            half,
            radius: piece.radius,
            is_cylinder,
        };
        // A triangle's box is along the world's axes already.
        match piece.core.is_surface() {
            true => exact,
            false => exact.upright(),
        }
    }

    fn of_bounds([low, high]: [Vec3; 2], radius: f64) -> Self {
        Self {
            center: (low + high) / 2.0,
            axes: Mat3::IDENTITY,
            half: (high - low) / 2.0,
            radius,
            is_cylinder: false,
        }
    }

    /// A box turned by quarter turns is one along the world's axes, a cylinder one about the third.
    fn upright(self) -> Self {
        if self.is_cylinder {
            let tilted = (self.axes.z_axis.z.abs() - 1.0).abs() > 1e-15;
            return Self {
                axes: if tilted { self.axes } else { Mat3::IDENTITY },
                ..self
            };
        }
        let columns = [self.axes.x_axis, self.axes.y_axis, self.axes.z_axis];
        let nearly = |value: f64| value.abs() < 1e-12 || (value.abs() - 1.0).abs() < 1e-12;
        if !columns
            .iter()
            .all(|column| column.to_array().into_iter().all(nearly))
        {
            return self;
        }
        let half = columns[0].abs() * self.half.x
            + columns[1].abs() * self.half.y
            + columns[2].abs() * self.half.z;
        Self {
            axes: Mat3::IDENTITY,
            half: half * (1.0 + 1e-11),
            ..self
        }
    }

    /// The hull in the frame in which `place` puts its own.
    fn placed(&self, place: &Transform) -> Self {
        Self {
            center: place.point(self.center),
            axes: place.rotation * self.axes,
            ..*self
        }
        .upright()
    }

    fn padded(&self, padding: f64) -> Self {
        Self {
            radius: self.radius + padding,
            ..*self
        }
    }

    fn bounds(&self) -> [Vec3; 2] {
        let [x, y, z] = [self.axes.x_axis, self.axes.y_axis, self.axes.z_axis].map(Vec3::abs);
        let reach = x * self.half.x + y * self.half.y + z * self.half.z + Vec3::splat(self.radius);
        [self.center - reach, self.center + reach]
    }

    fn hull(&self) -> Hull {
        let single = |v: Vec3| v.to_array().map(|value| value as f32);
        let columns = [self.axes.x_axis, self.axes.y_axis, self.axes.z_axis];
        let size = self.center.length() + self.half.length() + self.radius;
        Hull {
            center: single(self.center),
            axes: (self.axes != Mat3::IDENTITY).then(|| columns.map(single)),
            core: match single(self.half) {
                [radius, _, half_height] if self.is_cylinder => HullCore::Cylinder {
                    radius,
                    half_height,
                },
                half => HullCore::Box(half),
            },
            radius: (self.radius + ROUNDING * size) as f32,
        }
    }
}

/// Hulls of a solid in its own frame, made once however often it is moved.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SolidHulls {
    whole: Exact,
    /// Hulls that enclose it together, where there is more than one piece.
    parts: Vec<Exact>,
    /// The cells of a cloud, which are enclosed as they are.
    #[serde(skip)]
    cells: Option<CellTree>,
    /// The solid is what its hulls are.
    is_exact: bool,
}

impl SolidHulls {
    /// The hull over a cloud.
    pub fn of_cells(cells: &CellTree) -> Self {
        Self {
            whole: Exact::of_bounds(cells.bounds(), cells.radius()),
            parts: Vec::new(),
            cells: Some(cells.clone()),
            is_exact: true,
        }
    }

    /// Hulls over pieces that stand in the order of their tree: neighbours together.
    pub fn new(pieces: &[Piece]) -> Self {
        if let [piece] = pieces {
            let is_exact = piece.core.is_its_enclosure();
            return Self {
                whole: Exact::of_piece(piece),
                parts: Vec::new(),
                cells: None,
                is_exact,
            };
        }
        let is_exact = pieces
            .iter()
            .all(|piece| piece.core.is_its_enclosure());
        let parts: Vec<_> = if is_exact {
            pieces.iter().map(Exact::of_piece).collect()
        } else {
            let share = pieces.len().div_ceil(MESH_BOXES).max(1);
            pieces
                .chunks(share)
                .map(|part| Exact::of_bounds(bounds_of(part.iter().map(Exact::of_piece)), 0.0))
                .collect()
        };
        Self {
            whole: Exact::of_bounds(bounds_of(parts.iter().copied()), 0.0),
            parts,
            cells: None,
            is_exact,
        }
    }

    /// Memory of the parts (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.parts)
    }

    /// Hulls of the same solid, thicker by `padding` (m).
    #[must_use]
    pub fn padded(&self, padding: f64) -> Self {
        let parts = self
            .parts
            .iter()
            .map(|part| part.padded(padding))
            .collect();
        Self {
            whole: self.whole.padded(padding),
            parts,
            cells: self
                .cells
                .as_ref()
                .map(|cells| cells.padded(padding)),
            is_exact: self.is_exact,
        }
    }
}

impl FilterObject {
    /// The hulls of a solid that stands at `place` in the world.
    pub fn new(hulls: &SolidHulls, place: &Transform) -> Self {
        let whole = hulls.whole.placed(place);
        let parts: Vec<_> = hulls
            .parts
            .iter()
            .map(|part| part.placed(place))
            .collect();
        let bounds = if parts.is_empty() {
            whole.bounds()
        } else {
            bounds_of(parts.iter().copied())
        };
        let middle = std::array::from_fn(|axis| bounds.map(|corner| corner[axis]).iter().sum());
        let (hull, boxes) = (whole.hull(), parts.iter().map(Exact::hull).collect());
        let cells = hulls.cells.as_ref();
        Self {
            hull,
            boxes,
            cells: cells.map(|cells| PlacedCells::new(cells, place)),
            bounds,
            middle,
            is_exact: hulls.is_exact,
        }
    }

    /// Distance from a point to the object's bounding box (m).
    pub fn distance(&self, from: Vec3) -> f64 {
        from.distance(from.clamp(self.bounds[0], self.bounds[1]))
    }
}

/// A box along the world's axes.
pub fn box_hull(bounds: [Vec3; 2]) -> Hull {
    Exact::of_bounds(bounds, 0.0).hull()
}

fn bounds_of(hulls: impl Iterator<Item = Exact>) -> [Vec3; 2] {
    hulls.map(|hull| hull.bounds()).fold(
        [Vec3::INFINITY, Vec3::NEG_INFINITY],
        |[low, high], [l, h]| [low.min(l), high.max(h)],
    )
}

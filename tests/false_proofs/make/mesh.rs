//! Solids whose convex parts are known, to be written as meshes. Their coordinates are whole
//! multiples of 1/2048 m, which every format holds exactly.

use std::f64::consts::TAU;

use fastrand::Rng;

use super::{pick, uniform};
use crate::pose::{Vector, add, cross, dot, sub};
use crate::solid::Convex;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Form {
    Box,
    /// Corners about a centre that sees them all; its notches are deep.
    Star,
    /// A U.
    Comb,
    /// A box whose lid is a quad that is not flat.
    Roof,
}

/// A column over an outline: flat below, and above at a height of its own over each corner.
#[derive(Clone, Debug)]
pub struct Column {
    pub form: Form,
    /// Counter-clockwise; a star's centre is one more.
    points: Vec<[f64; 2]>,
    corners: usize,
    /// What fills the outline.
    triangles: Vec<[usize; 3]>,
    bottom: f64,
    top: Vec<f64>,
    /// Corner at which the lid's polygon begins.
    first: usize,
    /// Which axis its z becomes: 0 leaves it.
    turned: usize,
}

pub fn on_grid(x: f64) -> f64 {
    (x * 1024.0).round() / 1024.0
}

impl Column {
    pub fn new(rng: &mut Rng, form: Form, size: f64) -> Self {
        let (points, corners, triangles) = match form {
            Form::Box | Form::Roof => square(rng, size),
            Form::Star => star(rng, size),
            Form::Comb => comb(rng, size),
        };
        let flat = if form == Form::Roof { 0.5 } else { 1.0 };
        let half = on_grid(flat * uniform(rng, 0.5, 0.7) * size);
        let mut top = vec![half; points.len()];
        let first = rng.usize(0..corners);
        let mut triangles = triangles;
        if form == Form::Roof {
            top.iter_mut()
                .for_each(|z| *z = on_grid(half + uniform(rng, -0.4, 0.4) * size));
            // A convex polygon is a fan from its first corner.
            triangles = [[0, 1, 2], [0, 2, 3]]
                .map(|t| t.map(|i| (first + i) % 4))
                .to_vec();
        }
        Self {
            form,
            points,
            corners,
            triangles,
            bottom: -half - on_grid(0.2 * size),
            top,
            first,
            turned: rng.usize(0..3),
        }
    }

    /// The column's own coordinates as the mesh has them.
    fn turn(&self, p: Vector) -> Vector {
        std::array::from_fn(|axis| p[(axis + self.turned) % 3])
    }

    fn low(&self, i: usize) -> Vector {
        self.turn([self.points[i][0], self.points[i][1], self.bottom])
    }

    fn high(&self, i: usize) -> Vector {
        self.turn([self.points[i][0], self.points[i][1], self.top[i]])
    }

    /// Vertices: the ring below, then that above, each with the centre if it has one.
    pub fn vertices(&self) -> Vec<Vector> {
        let count = self.points.len();
        (0..count)
            .map(|i| self.low(i))
            .chain((0..count).map(|i| self.high(i)))
            .collect()
    }

    /// Its faces as polygons of vertices, seen from outside counter-clockwise: quads, and outlines
    /// of any form.
    pub fn polygons(&self) -> Vec<Vec<usize>> {
        let n = self.corners;
        let above = self.points.len();
        let lid = (0..n)
            .map(|i| above + (self.first + i) % n)
            .collect();
        let floor = (0..n)
            .rev()
            .map(|i| (self.first + i) % n)
            .collect();
        let wall = |i: usize| {
            let j = (i + 1) % n;
            vec![i, j, above + j, above + i]
        };
        [lid, floor]
            .into_iter()
            .chain((0..n).map(wall))
            .collect()
    }

    /// The same as triangles.
    pub fn triangulated(&self) -> Vec<Vec<usize>> {
        let n = self.corners;
        let above = self.points.len();
        let lids = self
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [vec![above + a, above + b, above + c], vec![c, b, a]]);
        let walls = (0..n).flat_map(|i| {
            let j = (i + 1) % n;
            [vec![i, j, above + j], vec![i, above + j, above + i]]
        });
        lids.chain(walls).collect()
    }

    /// Its convex parts.
    pub fn parts(&self) -> Vec<Convex> {
        let part = |t: &[usize; 3]| {
            t.iter()
                .flat_map(|&i| [self.low(i), self.high(i)])
                .collect()
        };
        self.triangles
            .iter()
            .map(part)
            .map(Convex::Hull)
            .collect()
    }

    pub fn volume(&self) -> f64 {
        let volume = |&[a, b, c]: &[usize; 3]| {
            let height = (self.top[a] + self.top[b] + self.top[c]) / 3.0 - self.bottom;
            0.5 * turn(self.points[a], self.points[b], self.points[c]) * height
        };
        self.triangles.iter().map(volume).sum()
    }

    /// Whether a point of the mesh lies inside.
    pub fn contains(&self, p: Vector) -> bool {
        let own: Vector = std::array::from_fn(|axis| p[(axis + 3 - self.turned) % 3]);
        let at = [own[0], own[1]];
        let is_in = |&[a, b, c]: &[usize; 3]| {
            let corners = [a, b, c].map(|i| self.points[i]);
            let weights: [f64; 3] =
                std::array::from_fn(|i| turn(at, corners[(i + 1) % 3], corners[(i + 2) % 3]));
            let all = turn(corners[0], corners[1], corners[2]);
            let lid: f64 = weights
                .iter()
                .zip([a, b, c])
                .map(|(w, i)| w / all * self.top[i])
                .sum();
            weights.iter().all(|w| *w >= 0.0) && own[2] >= self.bottom && own[2] <= lid
        };
        self.triangles.iter().any(is_in)
    }
}

type Outline = (Vec<[f64; 2]>, usize, Vec<[usize; 3]>);

fn square(rng: &mut Rng, size: f64) -> Outline {
    let [x, y] = [0, 1].map(|_| on_grid(uniform(rng, 0.5, 1.0) * size));
    (
        vec![[-x, -y], [x, -y], [x, y], [-x, y]],
        4,
        vec![[0, 1, 2], [0, 2, 3]],
    )
}

fn star(rng: &mut Rng, size: f64) -> Outline {
    let corners = rng.usize(4..10);
    let corner = |i: usize| {
        let angle = TAU * (i as f64 + uniform(rng, -0.2, 0.2)) / corners as f64;
        let radius = size
            * if i.is_multiple_of(2) {
                uniform(rng, 0.9, 1.4)
            } else {
                uniform(rng, 0.15, 0.7)
            };
        [on_grid(radius * angle.cos()), on_grid(radius * angle.sin())]
    };
    let mut points: Vec<_> = (0..corners).map(corner).collect();
    points.push([0.0, 0.0]);
    (
        points,
        corners,
        (0..corners)
            .map(|i| [corners, i, (i + 1) % corners])
            .collect(),
    )
}

fn comb(rng: &mut Rng, size: f64) -> Outline {
    let [x, y] = [0, 1].map(|_| on_grid(uniform(rng, 0.4, 0.7) * size));
    let outline = [
        [0, 0],
        [3, 0],
        [3, 2],
        [2, 2],
        [2, 1],
        [1, 1],
        [1, 2],
        [0, 2],
    ];
    let points = outline
        .map(|[i, j]| [x * (i as f64 - 1.5), y * (j as f64 - 1.0)])
        .to_vec();
    (
        points,
        8,
        vec![
            [0, 5, 7],
            [7, 5, 6],
            [0, 1, 5],
            [1, 4, 5],
            [1, 2, 4],
            [2, 3, 4],
        ],
    )
}

/// Twice the area of a triangle, positive counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// How a solid is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Format {
    StlText,
    StlBinary,
    Obj,
    Dae,
    /// Vertices and triangles in the scene's own text.
    Inline,
}

impl Format {
    pub const FILES: [Self; 4] = [Self::StlText, Self::StlBinary, Self::Obj, Self::Dae];

    pub fn name(self) -> &'static str {
        match self {
            Self::StlText => "STL, text",
            Self::StlBinary => "STL, binary",
            Self::Obj => "OBJ",
            Self::Dae => "DAE",
            Self::Inline => "in the scene",
        }
    }

    pub fn ending(self) -> &'static str {
        match self {
            Self::StlText | Self::StlBinary => "stl",
            Self::Obj => "obj",
            Self::Dae => "dae",
            Self::Inline => "",
        }
    }
}

/// A transform of a DAE's node.
#[derive(Clone, Copy, Debug)]
pub enum Step {
    Translate(Vector),
    /// Axis and degrees.
    Rotate(Vector, f64),
    Scale(Vector),
}

/// A solid as a file has it.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub column: Column,
    pub format: Format,
    /// The scale that robot or scene give it.
    pub scale: Vector,
    /// Where the file's coordinates have the solid's origin (m).
    pub offset: Vector,
    /// Faces as polygons, where the format can.
    pub has_polygons: bool,
    /// DAE: metres per unit.
    pub unit: f64,
    /// DAE: the node's transforms, the last done first.
    pub steps: Vec<Step>,
    /// A choice that the writer makes of small matters.
    pub whim: u64,
}

impl Mesh {
    /// A mesh of a form; `is_plain` keeps to triangles and boxes near the origin.
    pub fn new(rng: &mut Rng, form: Form, format: Format, size: f64) -> Self {
        let column = Column::new(rng, form, size);
        let scale = match rng.usize(0..4) {
            0 => [0.001; 3],
            1 => [
                pick(rng, &[2.0, -2.0, 0.5]),
                pick(rng, &[1.0, -1.0]),
                pick(rng, &[1.0, 0.25]),
            ],
            _ => [1.0; 3],
        };
        let (unit, steps) = if format == Format::Dae {
            dae_frame(rng)
        } else {
            (1.0, Vec::new())
        };
        let has_polygons = matches!(format, Format::Obj | Format::Dae)
            && (form == Form::Roof || rng.usize(0..4) > 0);
        Self {
            column,
            format,
            scale,
            offset: [0.0; 3],
            has_polygons,
            unit,
            steps,
            whim: rng.u64(..),
        }
    }

    /// Puts the solid far from the origin of its file.
    pub fn put_far(&mut self, rng: &mut Rng) {
        let far = pick(rng, &[300.0, 5e3, 4e5, 5.8e6]);
        self.offset = std::array::from_fn(|_| on_grid(uniform(rng, -far, far)));
    }

    pub fn faces(&self) -> Vec<Vec<usize>> {
        let is_fan = self.column.form != Form::Roof || self.has_convex_lid();
        if self.has_polygons && is_fan {
            self.column.polygons()
        } else {
            self.column.triangulated()
        }
    }

    /// Whether the lid turns one way as the file has it, seen along its own normal. A quad that is
    /// not flat may be convex in metres and not in a file whose node scales unevenly: readers
    /// decide before they scale, and some cut ears there, others a fan; what it means is then
    /// nobody's word.
    fn has_convex_lid(&self) -> bool {
        let corners = self.column.corners;
        let places: Vec<Vector> = (0..corners)
            .map(|i| self.in_file(self.column.high(i)))
            .collect();
        let side = |i: usize| sub(places[(i + 1) % corners], places[i % corners]);
        let normal = (1..corners - 1).fold([0.0; 3], |sum, i| {
            let area = cross(sub(places[i], places[0]), sub(places[i + 1], places[0]));
            add(sum, area)
        });
        // Of the whole area: near 0 rounding decides.
        (0..corners).all(|i| dot(cross(side(i), side(i + 1)), normal) > 1e-6 * dot(normal, normal))
    }

    /// Whether the file's coordinates are mirrored, so that faces turn over.
    pub fn is_mirrored(&self) -> bool {
        let of = |scale: &Vector| scale.iter().product::<f64>() < 0.0;
        let steps = self
            .steps
            .iter()
            .filter(|step| matches!(step, Step::Scale(scale) if of(scale)))
            .count();
        of(&self.scale) != (steps % 2 == 1)
    }

    /// A vertex of the solid as the file has it.
    pub fn in_file(&self, vertex: Vector) -> Vector {
        let mut at: Vector =
            std::array::from_fn(|i| (vertex[i] + self.offset[i]) / self.scale[i] / self.unit);
        for step in &self.steps {
            at = match step {
                Step::Translate(by) => sub(at, *by),
                Step::Rotate(axis, degrees) => rotated(*axis, -degrees, at),
                Step::Scale(by) => std::array::from_fn(|i| at[i] / by[i]),
            };
        }
        at
    }
}

pub fn rotated(axis: Vector, degrees: f64, p: Vector) -> Vector {
    crate::pose::Pose::turn(crate::pose::about(
        crate::pose::unit(axis),
        degrees.to_radians(),
    ))
    .point(p)
}

fn dae_frame(rng: &mut Rng) -> (f64, Vec<Step>) {
    let unit = pick(rng, &[1.0, 0.001, 0.01, 0.0254]);
    let count = rng.usize(0..4);
    let step = |_| match rng.usize(0..3) {
        0 => Step::Translate(super::vector(rng, 0.3)),
        1 => Step::Rotate(
            super::direction(rng),
            pick(rng, &[90.0, -90.0, 180.0, 33.0]),
        ),
        _ => Step::Scale([pick(rng, &[0.5, 2.0, -1.0]), pick(rng, &[1.0, 0.1]), 1.0]),
    };
    (unit, (0..count).map(step).collect())
}

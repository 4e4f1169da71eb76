//! Places for names beside dots where they cover neither each other nor the dots.

use crate::svg::Point;

/// Height of a name (px).
const HEIGHT: f64 = 12.0;
/// From a dot to its name, and further where there is no room (px).
const DISTANCES: [f64; 6] = [8.0, 16.0, 28.0, 42.0, 58.0, 76.0];
/// Directions that a name is looked for in, to the right first.
const DIRECTIONS: [Point; 8] = [
    [1.0, 0.0],
    [1.0, -0.7],
    [1.0, 0.7],
    [-1.0, 0.0],
    [-1.0, -0.7],
    [-1.0, 0.7],
    [0.2, -1.0],
    [0.2, 1.0],
];

/// What it costs to cover a point of a line, and to stand beside another dot, in pixels of
/// distance.
const COVERS: f64 = 2.5;
const MISLEADS: f64 = 16.0;

/// Left, top, right and bottom (px).
type Area = [f64; 4];

/// Where a name stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// The end of its base line that is towards the dot, for its true width is not known.
    pub anchor: Point,
    /// Whether that is its right end.
    pub is_right: bool,
    /// Its end that is nearest to the dot, where that is so far that a line should lead there.
    pub leader: Option<Point>,
}

/// What is taken in a plot.
pub(super) struct Room {
    plot: Area,
    dots: Vec<Point>,
    taken: Vec<Area>,
    /// Points of lines, which names should not cover but may.
    lines: Vec<Point>,
}

impl Room {
    /// All of a plot but some dots.
    pub(super) fn new(plot: Area, dots: &[Point], lines: Vec<Point>) -> Self {
        let around = |dot: &Point| [dot[0] - 5.0, dot[1] - 5.0, dot[0] + 5.0, dot[1] + 5.0];
        Self {
            plot,
            dots: dots.to_vec(),
            taken: dots.iter().map(around).collect(),
            lines,
        }
    }

    /// The best place for a name so many pixels wide, which is then taken; `None` where there is no
    /// room.
    pub(super) fn place(&mut self, dot: Point, width: f64) -> Option<Place> {
        let free = candidates(dot, [width, HEIGHT]).filter(|name| self.is_free(&name.area));
        let best = free.min_by(|a, b| self.cost(dot, a).total_cmp(&self.cost(dot, b)))?;
        self.taken.push(best.area);
        Some(best.place(dot))
    }

    /// The distance, and what it costs to cover lines and to mislead.
    fn cost(&self, dot: Point, name: &Candidate) -> f64 {
        let covered = self
            .lines
            .iter()
            .filter(|point| contains(&name.area, point));
        // A name right beside another dot would be taken for that one's.
        let wide = widened(&name.area);
        let beside = self
            .dots
            .iter()
            .filter(|other| **other != dot && contains(&wide, other));
        name.distance + COVERS * covered.count() as f64 + MISLEADS * beside.count() as f64
    }

    /// Takes the room of something that stands there already.
    pub(super) fn take(&mut self, [left, baseline]: Point, width: f64) {
        self.taken
            .push([left, baseline - HEIGHT, left + width, baseline + 3.0]);
    }

    fn is_free(&self, area: &Area) -> bool {
        let inside = area[0] >= self.plot[0]
            && area[1] >= self.plot[1]
            && area[2] <= self.plot[2]
            && area[3] <= self.plot[3];
        inside
            && !self
                .taken
                .iter()
                .any(|other| overlap(area, other))
    }
}

/// Where a name might stand.
struct Candidate {
    distance: f64,
    is_right: bool,
    area: Area,
}

impl Candidate {
    fn place(&self, dot: Point) -> Place {
        let [left, _, right, bottom] = self.area;
        Place {
            anchor: [if self.is_right { right } else { left }, bottom - 3.0],
            is_right: self.is_right,
            leader: (self.distance > DISTANCES[0]).then(|| self.nearest(dot)),
        }
    }

    fn nearest(&self, [x, y]: Point) -> Point {
        let [left, top, right, bottom] = self.area;
        [x.clamp(left, right), y.clamp(top + 2.0, bottom - 2.0)]
    }
}

/// Places for a name of this size, the nearest first.
fn candidates(dot: Point, size: [f64; 2]) -> impl Iterator<Item = Candidate> {
    let places = DISTANCES
        .iter()
        .flat_map(|distance| DIRECTIONS.map(|direction| (*distance, direction)));
    places.map(move |(distance, direction)| Candidate {
        distance,
        is_right: direction[0] < 0.0,
        area: area(dot, distance, direction, size),
    })
}

/// Where a name stands that begins, or to the left ends, so far from its dot.
fn area(dot: Point, distance: f64, direction: Point, [width, height]: [f64; 2]) -> Area {
    let [x, y] = [
        dot[0] + distance * direction[0],
        dot[1] + distance * direction[1],
    ];
    let left = if direction[0] < 0.0 { x - width } else { x };
    [left, y - height / 2.0, left + width, y + height / 2.0]
}

/// With the room that a dot beside it takes.
fn widened([left, top, right, bottom]: &Area) -> Area {
    [left - 14.0, top - 4.0, right + 14.0, bottom + 4.0]
}

fn overlap(a: &Area, b: &Area) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

fn contains(area: &Area, point: &Point) -> bool {
    (area[0]..=area[2]).contains(&point[0]) && (area[1]..=area[3]).contains(&point[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_near_dots_do_not_cover_each_other() {
        let dots = [[50.0, 50.0], [52.0, 51.0], [54.0, 50.0]];
        let mut room = Room::new([0.0, 0.0, 300.0, 100.0], &dots, Vec::new());
        let places: Vec<Place> = dots
            .iter()
            .filter_map(|dot| room.place(*dot, 40.0))
            .collect();
        assert_eq!(places.len(), 3);
        let taken = &room.taken;
        let pairs = (0..taken.len()).flat_map(|a| (a + 1..taken.len()).map(move |b| (a, b)));
        // The dots themselves may.
        assert!(
            pairs
                .filter(|(_, b)| *b >= dots.len())
                .all(|(a, b)| !overlap(&taken[a], &taken[b]))
        );
        assert_eq!(room.place([299.0, 50.0], 400.0), None);
    }
}

//! One planner's robot, obstacles and paths, drawn in one view.

use taut::math::Vec3;

use super::elements;
use super::motion::{Mover, STEPS, Track};
use super::view::{Bounds, Frame, View};
use super::world::World;
use crate::cli::svg::{Point, Svg};

/// Room around what moves, as a part of its size.
const ROOM: f64 = 0.12;
/// Robots of at most this many shapes are drawn along the whole path.
const FEW_SHAPES: usize = 2;
/// How often they are drawn.
const GHOSTS: usize = 16;
/// Heights that differ by less are one plane [m].
const FLAT_M: f64 = 1e-6;

/// What there is to draw, before it is seen from anywhere.
pub(super) struct Panel<'a> {
    world: &'a World,
    before: Track,
    after: Track,
    rows: &'a [f64],
    start: &'a [f64],
    goal: &'a [f64],
}

impl<'a> Panel<'a> {
    /// From the rows of both paths; either may be empty where there is no path.
    pub(super) fn new(world: &'a World, before: &'a [f64], after: &'a [f64]) -> Self {
        let mut mover = Mover::new(&world.robot);
        Self {
            world,
            before: mover.track(before),
            after: mover.track(after),
            rows: after,
            start: &world.start,
            goal: &world.goal,
        }
    }

    /// Places of the tool on both paths.
    fn places(&self) -> impl Iterator<Item = Vec3> {
        let before = self.before.places.iter();
        before.chain(&self.after.places).copied()
    }

    /// Whether all of the motion stays in one horizontal plane.
    pub(super) fn is_flat(&self) -> bool {
        let mut heights = self.places().map(|place| place.z);
        heights
            .next()
            .is_some_and(|first| heights.all(|height| (height - first).abs() < FLAT_M))
    }

    /// Draws it, seen in a direction, into a part of the picture.
    pub(super) fn draw(&self, svg: &mut Svg, view: View, [x, y]: Point, size: [f64; 2]) {
        let [width, height] = size;
        let robots = self.robots(view);
        let tracks = self.places().map(|place| view.point(place));
        let corners = robots
            .iter()
            .flat_map(|(_, outlines)| outlines.iter());
        let Some(bounds) = Bounds::around(tracks.chain(corners.flatten().copied())) else {
            return;
        };
        let frame = Frame::new(bounds.widened(ROOM), width, height);
        // A picture within the picture cuts off what lies outside.
        svg.begin(
            "svg",
            &[("x", &x), ("y", &y), ("width", &width), ("height", &height)],
        );
        elements::rectangle(svg, "view", size);
        self.obstacles(svg, view, &frame, size);
        self.swept(svg, view, &frame);
        for (class, outlines) in &robots {
            draw_outlines(svg, &frame, outlines, class);
        }
        path(svg, view, &frame, &self.before, "before", "as planned");
        path(svg, view, &frame, &self.after, "after", "shortened");
        svg.end();
        svg.label([x, y + height + 21.0], "small", view.caption);
        ruler(svg, &frame, [x + width, y + height + 19.0]);
    }

    /// Outlines of the robot at both ends of its path.
    fn robots(&self, view: View) -> [(&'static str, Vec<Vec<Point>>); 2] {
        let mut mover = Mover::new(&self.world.robot);
        [("start", self.start), ("goal", self.goal)].map(|(class, row)| {
            mover.place(row);
            (class, mover.outlines(view))
        })
    }

    fn obstacles(&self, svg: &mut Svg, view: View, frame: &Frame, [width, height]: [f64; 2]) {
        let shown = frame.shown(width, height);
        for obstacle in self.world.scene.obstacles() {
            for shape in obstacle.shapes.iter() {
                let outline = view.outline(&obstacle.pose, shape);
                // A floor seen from above fills everything and shows nothing.
                if !shown.is_filled_by(&outline) {
                    elements::outline(svg, &frame.pixels(&outline), "obstacle", &obstacle.id);
                }
            }
        }
    }

    /// The robot along the shortened path.
    fn swept(&self, svg: &mut Svg, view: View, frame: &Frame) {
        let mut mover = Mover::new(&self.world.robot);
        if mover.shapes() > FEW_SHAPES {
            return;
        }
        let places = self.after.places.len();
        let mut place = 0;
        mover.along(self.rows, STEPS, &mut |mover, _| {
            // So many of them that each can still be told from the next.
            let ghost = place * GHOSTS / places;
            place += 1;
            if place * GHOSTS / places > ghost {
                draw_ghost(svg, frame, &mover.outlines(view));
            }
        });
    }
}

fn draw_ghost(svg: &mut Svg, frame: &Frame, outlines: &[Vec<Point>]) {
    for outline in outlines {
        elements::outline(svg, &frame.pixels(outline), "swept", "the robot on its way");
    }
}

fn draw_outlines(svg: &mut Svg, frame: &Frame, outlines: &[Vec<Point>], class: &str) {
    for outline in outlines {
        elements::outline(svg, &frame.pixels(outline), class, class);
    }
}

fn path(svg: &mut Svg, view: View, frame: &Frame, track: &Track, class: &str, title: &str) {
    if track.places.is_empty() {
        return;
    }
    svg.line(&pixels(view, frame, &track.places), class, title);
    for dot in pixels(view, frame, &track.waypoints) {
        elements::dot(svg, dot, 2.4, &format!("{class}-dot"));
    }
}

fn pixels(view: View, frame: &Frame, places: &[Vec3]) -> Vec<Point> {
    let seen: Vec<Point> = places
        .iter()
        .map(|place| view.point(*place))
        .collect();
    frame.pixels(&seen)
}

/// How long a round length is.
fn ruler(svg: &mut Svg, frame: &Frame, [right, bottom]: Point) {
    let (metres, pixels) = frame.ruler(90.0);
    let left = right - pixels;
    let ends = [
        [left, bottom - 5.0],
        [left, bottom],
        [right, bottom],
        [right, bottom - 5.0],
    ];
    svg.line(&ends, "ruler", "scale");
    svg.label([left - 8.0, bottom], "small right", &format!("{metres} m"));
}

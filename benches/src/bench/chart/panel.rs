//! One set: a line for each mode, a dot for each peer.

use std::fmt::Display;

use super::super::peer_summary::PeerSummary;
use super::super::report::Report;
use super::super::row::{Figures, Row};
use super::super::summary::Summary;
use super::axes::Axes;
use super::dot::Dot;
use super::labels::Room;
use super::style::mode_class;
use crate::statistics::mean;
use crate::svg::{Point, Svg};
use crate::units::time;

/// Width and height (px).
pub(super) const PANEL: [f64; 2] = [760.0, 470.0];
/// What the best honest peers are called.
const BEST: &str = "best honest peer of each path";
/// Edges of the plot in it (px).
const PLOT: [f64; 4] = [62.0, 72.0, PANEL[0] - 20.0, PANEL[1] - 54.0];

/// Widths of a letter of peers' names, about (px).
const LETTER: f64 = 6.1;
const LETTER_BOLD: f64 = 7.4;

/// What there is to draw.
pub(super) struct Panel<'a> {
    summary: &'a Summary,
    rows: Vec<&'a Row>,
    /// Modes by their place in the report.
    modes: Vec<(usize, &'static str)>,
    axes: Axes,
}

impl<'a> Panel<'a> {
    /// One set of a report.
    pub(super) fn new(report: &'a Report, summary: &'a Summary) -> Self {
        let mut rows: Vec<&Row> = report.rows.iter().collect();
        rows.retain(|row| row.set == summary.set);
        Self {
            axes: Axes::around(PLOT, &times(&rows, summary), &lengths(&rows, summary)),
            summary,
            modes: report
                .modes
                .iter()
                .copied()
                .enumerate()
                .collect(),
            rows,
        }
    }

    /// Draws it at the origin.
    pub(super) fn draw(&self, svg: &mut Svg) {
        self.card(svg);
        self.axes.draw(svg);
        let mut lines = Vec::new();
        for &(index, mode) in &self.modes {
            lines.extend(self.line(svg, index, mode));
        }
        let dots: Vec<Point> = peers(self.summary)
            .map(|peer| self.dot(peer))
            .collect();
        let mut room = Room::new(PLOT, &dots, lines);
        self.bound(svg, &mut room);
        self.best(svg, &mut room);
        self.others(svg, &mut room);
        // The best last, so that no other dot covers it.
        if let Some(best) = &self.summary.best_honest_peer {
            let dot = Dot {
                at: self.dot(best),
                radius: 6.5,
                class: "best",
                opacity: 1.0,
                title: BEST,
            };
            dot.draw(svg);
        }
    }

    fn card(&self, svg: &mut Svg) {
        let [width, height] = PANEL;
        let attributes: [(&str, &dyn Display); 4] = [
            ("class", &"card"),
            ("width", &width),
            ("height", &height),
            ("rx", &10),
        ];
        svg.element("rect", &attributes);
        svg.label([20.0, 30.0], "name", &self.summary.set);
        svg.label([width - 20.0, 30.0], "small right", &self.paths());
        svg.label([20.0, 51.0], "small", &self.ends());
    }

    fn dot(&self, peer: &PeerSummary) -> Point {
        self.axes.point(peer.cpu_s, peer.ratio_mean)
    }

    /// What no path can be shorter than.
    fn bound(&self, svg: &mut Svg, room: &mut Room) {
        let Some(bound) = bound(&self.rows) else {
            return;
        };
        let y = self.axes.y(bound);
        let name = "straight way from start to goal";
        svg.line(&[[PLOT[0], y], [PLOT[2], y]], "bound", name);
        let place = [PLOT[0] + 6.0, y + 13.0];
        svg.label(place, "peer-name", name);
        room.take(place, LETTER * name.len() as f64);
    }

    fn paths(&self) -> String {
        let paths = match self.rows.len() {
            1 => "one path".to_owned(),
            count => format!("{count} paths"),
        };
        let mut geometries = self.rows.iter().map(|row| row.geometry);
        match geometries.find(|geometry| !geometry.is_empty()) {
            Some("spheres") => format!("{paths}, robot as spheres"),
            _ => paths,
        }
    }

    fn ends(&self) -> String {
        let ends = self.modes.iter().filter_map(|(_, mode)| {
            let figures = self.summary.modes.get(mode)?;
            Some(format!("{mode} {:.3}", figures.ratio_mean))
        });
        let ends: Vec<String> = ends.collect();
        format!("end: {}", ends.join(", "))
    }

    /// The mean of a mode's curves, drawn while any of its runs goes on, and thin from there; gives
    /// its points.
    fn line(&self, svg: &mut Svg, index: usize, mode: &str) -> Vec<Point> {
        let answers: Vec<&Figures> = self.answers(mode).collect();
        let times = answers.iter().map(|figures| figures.time_s);
        let end = self.axes.x(times.fold(0.0, f64::max)) + 1.0;
        let pixels = PLOT[0] as usize..=PLOT[2] as usize;
        let points = pixels.filter_map(|x| self.mean_at(&answers, x as f64));
        let (during, after): (Vec<Point>, Vec<Point>) = points.partition(|point| point[0] <= end);
        svg.line(&during, &mode_class("mode", index), mode);
        svg.line(&after, &mode_class("later", index), mode);
        during
    }

    fn answers(&self, mode: &str) -> impl Iterator<Item = &'a Figures> {
        self.rows
            .iter()
            .filter_map(move |row| row.answers.get(mode))
    }

    /// The point of the mean at a pixel.
    fn mean_at(&self, answers: &[&Figures], x: f64) -> Option<Point> {
        let time_s = self.axes.time_s(x);
        let lengths = answers
            .iter()
            .map(|figures| figures.curve.remaining(time_s));
        Some([x, self.axes.y(mean(lengths)?)])
    }

    fn best(&self, svg: &mut Svg, room: &mut Room) {
        let Some(best) = &self.summary.best_honest_peer else {
            return;
        };
        let dot = self.dot(best);
        svg.line(&[[PLOT[0], dot[1]], [PLOT[2], dot[1]]], "best-line", BEST);
        let time = time(best.cpu_s);
        let name = format!("best honest peer {:.3}, {time}", best.ratio_mean);
        name_beside(svg, room, dot, &name, "best-name");
    }

    fn others(&self, svg: &mut Svg, room: &mut Room) {
        let mut peers: Vec<(&String, &PeerSummary)> = self.summary.peers.iter().collect();
        // The shortest first: where there is not room for all names, theirs are worth most.
        peers.sort_by(|a, b| a.1.ratio_mean.total_cmp(&b.1.ratio_mean));
        for (name, peer) in &peers {
            name_beside(svg, room, self.dot(peer), short(name), "peer-name");
        }
        for (name, peer) in peers {
            let dot = Dot {
                at: self.dot(peer),
                radius: 4.0,
                class: "peer",
                opacity: peer.valid as f64 / peer.answers as f64,
                title: &title(name, peer),
            };
            dot.draw(svg);
        }
    }
}

/// What a pointer over a peer's dot shows.
fn title(name: &str, peer: &PeerSummary) -> String {
    format!(
        "{name}: {:.3}, {}, honest {}/{}",
        peer.ratio_mean,
        time(peer.cpu_s),
        peer.valid,
        peer.answers
    )
}

/// All peers, the best honest ones taken together too.
fn peers(summary: &Summary) -> impl Iterator<Item = &PeerSummary> {
    summary
        .peers
        .values()
        .chain(&summary.best_honest_peer)
}

/// Times that there are dots or steps at (s).
fn times(rows: &[&Row], summary: &Summary) -> Vec<f64> {
    let answers = rows.iter().flat_map(|row| row.answers.values());
    let ours = answers.flat_map(|one| [one.first_improvement_s.unwrap_or(1e-3), one.time_s]);
    ours.chain(peers(summary).map(|peer| peer.cpu_s))
        .collect()
}

fn lengths(rows: &[&Row], summary: &Summary) -> Vec<f64> {
    let ours = summary
        .modes
        .values()
        .map(|mode| mode.ratio_mean);
    let theirs = peers(summary).map(|peer| peer.ratio_mean);
    ours.chain(bound(rows)).chain(theirs).collect()
}

fn name_beside(svg: &mut Svg, room: &mut Room, dot: Point, name: &str, class: &str) {
    // What draws the picture has fonts of its own: widths are on the safe side.
    let letter = if class == "best-name" {
        LETTER_BOLD
    } else {
        LETTER
    };
    let Some(place) = room.place(dot, letter * name.chars().count() as f64) else {
        return;
    };
    if let Some(end) = place.leader {
        svg.line(&[dot, end], "leader", name);
    }
    let side = if place.is_right { " right" } else { "" };
    svg.label(place.anchor, &format!("{class}{side}"), name);
}

/// A peer's name without what the set's name says already.
fn short(name: &str) -> &str {
    name.strip_prefix("hpp/").unwrap_or(name)
}

/// Mean distance of the ends, as a part of the length.
fn bound(rows: &[&Row]) -> Option<f64> {
    mean(
        rows.iter()
            .filter_map(|row| row.lower_bound_ratio()),
    )
}

//! One set: a line for each mode, a dot for each peer.

use super::super::peer_summary::PeerSummary;
use super::super::report::Report;
use super::super::row::{Figures, Row};
use super::super::summary::Summary;
use super::axes::Axes;
use super::labels::Room;
use super::style::mode_class;
use crate::statistics::mean;
use crate::svg::{Point, Svg};
use crate::units::time;

/// Width and height [px].
pub(super) const PANEL: [f64; 2] = [760.0, 470.0];
/// Edges of the plot in it [px].
const PLOT: [f64; 4] = [62.0, 72.0, PANEL[0] - 20.0, PANEL[1] - 54.0];

/// Widths of a letter of peers' names, about [px].
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
        let rows: Vec<&Row> = report
            .rows
            .iter()
            .filter(|row| row.set == summary.set)
            .collect();
        let modes: Vec<(usize, &'static str)> = report.modes.iter().copied().enumerate().collect();
        let answers = || rows.iter().flat_map(|row| row.answers.values());
        let peers = || summary.peers.values().chain(&summary.best_honest_peer);
        let times = answers()
            .flat_map(|figures| [figures.first_improvement_s.unwrap_or(1e-3), figures.time_s]);
        let lengths = summary
            .modes
            .values()
            .map(|figures| figures.ratio_mean)
            .chain(bound(&rows));
        let times: Vec<f64> = times.chain(peers().map(|peer| peer.cpu_s)).collect();
        let lengths: Vec<f64> = lengths.chain(peers().map(|peer| peer.ratio_mean)).collect();
        Self {
            axes: Axes::around(PLOT, &times, &lengths),
            summary,
            modes,
            rows,
        }
    }

    /// Draws it at the origin.
    pub(super) fn draw(&self, svg: &mut Svg) {
        let [width, height] = PANEL;
        svg.element(
            "rect",
            &[
                ("class", &"card"),
                ("width", &width),
                ("height", &height),
                ("rx", &10),
            ],
        );
        svg.label([20.0, 30.0], "name", &self.summary.set);
        svg.label([width - 20.0, 30.0], "small right", &self.paths());
        svg.label([20.0, 51.0], "small", &self.ends());
        self.axes.draw(svg);
        let mut lines = Vec::new();
        for &(index, mode) in &self.modes {
            lines.extend(self.line(svg, index, mode));
        }
        let dots: Vec<Point> = self.peers().map(|peer| self.dot(peer)).collect();
        let mut room = Room::new(PLOT, &dots, lines);
        self.bound(svg, &mut room);
        self.best(svg, &mut room);
        self.others(svg, &mut room);
        // The best last, so that no other dot covers it.
        if let Some(best) = &self.summary.best_honest_peer {
            svg.titled_dot(
                self.dot(best),
                6.5,
                "best",
                1.0,
                "best honest peer of each path",
            );
        }
    }

    /// All peers, the best honest ones taken together too.
    fn peers(&self) -> impl Iterator<Item = &'a PeerSummary> {
        self.summary
            .peers
            .values()
            .chain(&self.summary.best_honest_peer)
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
        let geometry = self
            .rows
            .iter()
            .find(|row| !row.geometry.is_empty())
            .map_or("", |row| row.geometry);
        let robot = if geometry == "spheres" {
            ", robot as spheres"
        } else {
            ""
        };
        format!("{paths}{robot}")
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
        let answers: Vec<&Figures> = self
            .rows
            .iter()
            .filter_map(|row| row.answers.get(mode))
            .collect();
        let last_s = answers
            .iter()
            .map(|figures| figures.time_s)
            .fold(0.0, f64::max);
        let at = |x: f64| {
            let time_s = self.axes.time_s(x);
            mean(
                answers
                    .iter()
                    .map(|figures| figures.curve.remaining(time_s)),
            )
            .map(|length| [x, self.axes.y(length)])
        };
        let pixels = (PLOT[0] as usize..=PLOT[2] as usize).filter_map(|x| at(x as f64));
        let (during, after): (Vec<Point>, Vec<Point>) =
            pixels.partition(|point| point[0] <= self.axes.x(last_s) + 1.0);
        svg.line(&during, &mode_class("mode", index), mode);
        svg.line(&after, &mode_class("later", index), mode);
        during
    }

    fn best(&self, svg: &mut Svg, room: &mut Room) {
        let Some(best) = &self.summary.best_honest_peer else {
            return;
        };
        let dot = self.dot(best);
        svg.line(
            &[[PLOT[0], dot[1]], [PLOT[2], dot[1]]],
            "best-line",
            "best honest peer of each path",
        );
        let name = format!(
            "best honest peer {:.3}, {}",
            best.ratio_mean,
            time(best.cpu_s)
        );
        name_beside(svg, room, dot, &name, "best-name");
    }

    fn others(&self, svg: &mut Svg, room: &mut Room) {
        let mut peers: Vec<(&str, &PeerSummary)> = self
            .summary
            .peers
            .iter()
            .map(|(name, peer)| (name.as_str(), peer))
            .collect();
        // The shortest first: where there is not room for all names, theirs are worth most.
        peers.sort_by(|a, b| a.1.ratio_mean.total_cmp(&b.1.ratio_mean));
        for (name, peer) in &peers {
            name_beside(svg, room, self.dot(peer), short(name), "peer-name");
        }
        for (name, peer) in peers {
            let PeerSummary {
                answers,
                valid,
                ratio_mean,
                cpu_s,
                ..
            } = peer;
            let title = format!(
                "{name}: {ratio_mean:.3}, {}, honest {valid}/{answers}",
                time(*cpu_s)
            );
            svg.titled_dot(
                self.dot(peer),
                4.0,
                "peer",
                *valid as f64 / *answers as f64,
                &title,
            );
        }
    }
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
            .filter_map(|row| Some(row.lower_bound? / row.length_before?)),
    )
}

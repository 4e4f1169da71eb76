//! The picture of `taut bench`: remaining length over time, a panel for each set.

mod axes;
mod dot;
mod labels;
mod panel;
mod style;

use std::fmt::Display;

use super::report::Report;
use crate::svg::Svg;
use crate::units::time;
use dot::Dot;
use panel::{PANEL, Panel};
use style::{STYLE, mode_class};

const MARGIN: f64 = 24.0;
const HEAD: f64 = 118.0;
const COLUMNS: usize = 2;

/// Draws every set.
pub(super) fn draw(report: &Report) -> String {
    let sets = report.sets.len();
    let columns = sets.clamp(1, COLUMNS);
    let width = MARGIN + columns as f64 * (PANEL[0] + MARGIN);
    let height = HEAD + sets.div_ceil(columns) as f64 * (PANEL[1] + MARGIN);
    let mut svg = Svg::new(width, height, STYLE);
    let page: [(&str, &dyn Display); 3] =
        [("class", &"page"), ("width", &width), ("height", &height)];
    svg.element("rect", &page);
    head(&mut svg, report);
    for (index, summary) in report.sets.iter().enumerate() {
        svg.begin(
            "g",
            &[
                ("id", &format!("set-{index}")),
                ("transform", &place(index, columns)),
            ],
        );
        Panel::new(report, summary).draw(&mut svg);
        svg.end();
    }
    svg.finish()
}

/// Where a panel stands.
fn place(index: usize, columns: usize) -> String {
    let x = MARGIN + (index % columns) as f64 * (PANEL[0] + MARGIN);
    let y = HEAD + (index / columns) as f64 * (PANEL[1] + MARGIN);
    format!("translate({x} {y})")
}

fn head(svg: &mut Svg, report: &Report) {
    svg.label(
        [MARGIN, 42.0],
        "title",
        "taut bench: remaining length over time",
    );
    svg.label([MARGIN, 66.0], "small", &conditions(report));
    let x = names_of_modes(svg, report);
    names_of_peers(svg, x);
}

fn conditions(report: &Report) -> String {
    let given = report.from.as_deref().unwrap_or("the planner");
    let runs = match report.repeat {
        1 => "one run".to_owned(),
        count => format!("{count} runs"),
    };
    format!(
        "Means over each set; 1 is the path of {given}, and counts until the first improvement and where nothing is proved. One thread, medians of {runs}; calibration kernel {}.",
        time(report.calibration_s)
    )
}

/// Tells where they end (px).
fn names_of_modes(svg: &mut Svg, report: &Report) -> f64 {
    let mut x = MARGIN;
    for (index, mode) in report.modes.iter().enumerate() {
        let line = [[x, 92.0], [x + 30.0, 92.0]];
        svg.line(&line, &mode_class("mode", index), mode);
        svg.label([x + 38.0, 96.0], "", mode);
        x += 62.0 + 7.0 * mode.len() as f64;
    }
    x
}

fn names_of_peers(svg: &mut Svg, mut x: f64) {
    let peer = "recorded peer (median CPU, mean length), filled by its share of honest answers";
    let best = "best honest peer of each path";
    for (class, radius, text) in [("peer", 4.0, peer), ("best", 6.5, best)] {
        let dot = Dot {
            at: [x + 6.0, 92.0],
            radius,
            class,
            opacity: 1.0,
            title: text,
        };
        dot.draw(svg);
        svg.label([x + 17.0, 96.0], "small", text);
        x += 44.0 + 6.4 * text.len() as f64;
    }
}

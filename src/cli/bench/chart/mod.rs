//! The picture of `taut bench`: remaining length over time, a panel for each set.

mod axes;
mod labels;
mod panel;

use super::report::Report;
use crate::cli::report::time;
use crate::cli::svg::Svg;
use panel::{PANEL, Panel};

const STYLE: &str = "
text { font-family: system-ui, 'Segoe UI', 'Helvetica Neue', 'DejaVu Sans', sans-serif; fill: #23272e; font-size: 12px }
.page { fill: #f4f3ef } .card { fill: #ffffff; stroke: #dedbd3 } .plot { fill: #fbfaf7 }
.title { font-size: 24px; font-weight: 600 } .name { font-size: 16px; font-weight: 600 }
.small { fill: #6a6f78 } .right { text-anchor: end } .middle { text-anchor: middle }
.grid { fill: none; stroke: #e7e4dc; stroke-width: 1 } .axis { fill: none; stroke: #8b8f97; stroke-width: 1.2 }
.bound { fill: none; stroke: #8b8f97; stroke-width: 1.2; stroke-dasharray: 2 4 }
.mode { fill: none; stroke-width: 2.4; stroke-linejoin: round; stroke-linecap: round }
.later { fill: none; stroke-width: 1.2; stroke-dasharray: 1 4; stroke-opacity: 0.9 }
.peer { fill: #5d636d; stroke: #5d636d; stroke-width: 1.2 }
.best { fill: #c2185b; stroke: #ffffff; stroke-width: 1.2 } .best-line { fill: none; stroke: #c2185b; stroke-opacity: 0.45; stroke-width: 1; stroke-dasharray: 6 4 }
.peer-name { font-size: 10.5px; fill: #5d636d } .best-name { font-size: 11.5px; font-weight: 600; fill: #c2185b }
.peer-name, .best-name { paint-order: stroke; stroke: #fbfaf7; stroke-width: 3px; stroke-linejoin: round }
.leader { fill: none; stroke: #a9adb4; stroke-width: 0.8 }
.m0 { stroke: #0072b2 } .m1 { stroke: #e69f00 } .m2 { stroke: #009e73 } .m3 { stroke: #d55e00 }
.m4 { stroke: #7b3fa0 } .m5 { stroke: #56b4e9 } .m6 { stroke: #4d4d4d }
";
/// Colours in the style sheet.
const COLOURS: usize = 7;

const MARGIN: f64 = 24.0;
const HEAD: f64 = 118.0;
const COLUMNS: usize = 2;

/// Draws every set.
pub(super) fn draw(report: &Report) -> String {
    let columns = report.sets.len().clamp(1, COLUMNS);
    let lines = report.sets.len().div_ceil(columns);
    let width = MARGIN + columns as f64 * (PANEL[0] + MARGIN);
    let height = HEAD + lines as f64 * (PANEL[1] + MARGIN);
    let mut svg = Svg::new(width, height, STYLE);
    svg.element(
        "rect",
        &[("class", &"page"), ("width", &width), ("height", &height)],
    );
    head(&mut svg, report);
    for (index, summary) in report.sets.iter().enumerate() {
        let x = MARGIN + (index % columns) as f64 * (PANEL[0] + MARGIN);
        let y = HEAD + (index / columns) as f64 * (PANEL[1] + MARGIN);
        let place = format!("translate({x} {y})");
        svg.begin(
            "g",
            &[("id", &format!("set-{index}")), ("transform", &place)],
        );
        Panel::new(report, summary).draw(&mut svg);
        svg.end();
    }
    svg.finish()
}

fn head(svg: &mut Svg, report: &Report) {
    svg.label(
        [MARGIN, 42.0],
        "title",
        "taut bench: remaining length over time",
    );
    let given = report.from.as_deref().unwrap_or("the planner");
    let runs = if report.repeat == 1 {
        "one run".to_owned()
    } else {
        format!("{} runs", report.repeat)
    };
    let text = format!(
        "Means over each set; 1 is the path of {given}, and counts until the first improvement and where nothing is proved. One thread, medians of {runs}; calibration kernel {}.",
        time(report.calibration_s)
    );
    svg.label([MARGIN, 66.0], "small", &text);
    let mut x = MARGIN;
    for (index, mode) in report.modes.iter().enumerate() {
        svg.line(
            &[[x, 92.0], [x + 30.0, 92.0]],
            &mode_class("mode", index),
            mode,
        );
        svg.label([x + 38.0, 96.0], "", mode);
        x += 62.0 + 7.0 * mode.len() as f64;
    }
    for (class, radius, text) in [
        (
            "peer",
            4.0,
            "recorded peer (median CPU, mean length), filled by its share of honest answers",
        ),
        ("best", 6.5, "best honest peer of each path"),
    ] {
        svg.titled_dot([x + 6.0, 92.0], radius, class, 1.0, text);
        svg.label([x + 17.0, 96.0], "small", text);
        x += 44.0 + 6.4 * text.len() as f64;
    }
}

/// Class of a mode's line: colours go round.
fn mode_class(kind: &str, index: usize) -> String {
    format!("{kind} m{}", index % COLOURS)
}

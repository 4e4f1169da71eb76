//! The picture of `taut demo`: a card for each planner, its path before and after among the
//! obstacles.

use super::elements;
use super::panel::Panel;
use super::row::Row;
use super::view::View;
use super::world::World;
use crate::cli::report;
use crate::cli::svg::Svg;

const STYLE: &str = "
text { font-family: system-ui, 'Segoe UI', 'Helvetica Neue', 'DejaVu Sans', sans-serif; fill: #23272e; font-size: 13px }
.page { fill: #f4f3ef } .card { fill: #ffffff; stroke: #dedbd3 } .view { fill: #fbfaf7 }
.title { font-size: 24px; font-weight: 600 } .name { font-size: 16px; font-weight: 600 }
.small { fill: #6a6f78; font-size: 12px } .right { text-anchor: end }
.proved { fill: #12803c; font-weight: 600; text-anchor: end } .failed { fill: #b3261e; font-weight: 600; text-anchor: end }
.obstacle { fill: #b9a88f; fill-opacity: 0.3; stroke: #7d6d55; stroke-width: 1.1 }
.before { fill: none; stroke: #8f949c; stroke-width: 1.8; stroke-linejoin: round }
.after { fill: none; stroke: #17964a; stroke-width: 3.2; stroke-linejoin: round; stroke-linecap: round }
.before-dot { fill: #8f949c } .after-dot { fill: #ffffff; stroke: #17964a; stroke-width: 1.6 }
.start { fill: #2f6db5; fill-opacity: 0.14; stroke: #2f6db5; stroke-opacity: 0.55; stroke-width: 1 }
.goal { fill: #dd7a1f; fill-opacity: 0.16; stroke: #dd7a1f; stroke-opacity: 0.65; stroke-width: 1 }
.swept { fill: #17964a; fill-opacity: 0.05; stroke: #17964a; stroke-opacity: 0.22; stroke-width: 0.8 }
.ruler { fill: none; stroke: #6a6f78; stroke-width: 1.4 }
";

const MARGIN: f64 = 24.0;
const HEAD: f64 = 112.0;
const CARD: [f64; 2] = [610.0, 430.0];
const COLUMNS: usize = 2;

/// Draws every planner.
pub(super) fn draw(rows: &[Row], worlds: &[World]) -> String {
    let columns = rows.len().clamp(1, COLUMNS);
    let lines = rows.len().div_ceil(columns);
    let [width, height] = corner(columns, lines);
    let mut svg = Svg::new(width, height, STYLE);
    elements::rectangle(&mut svg, "page", [width, height]);
    head(&mut svg, rows);
    for (index, (row, world)) in rows.iter().zip(worlds).enumerate() {
        let [x, y] = corner(index % columns, index / columns);
        svg.begin(
            "g",
            &[
                ("id", &format!("planner-{}", row.planner)),
                ("transform", &format!("translate({x} {y})")),
            ],
        );
        card(&mut svg, row, world);
        svg.end();
    }
    svg.finish()
}

/// The upper left corner of the card at a column and a line, from 0.
fn corner(column: usize, line: usize) -> [f64; 2] {
    [
        MARGIN + column as f64 * (CARD[0] + MARGIN),
        HEAD + line as f64 * (CARD[1] + MARGIN),
    ]
}

fn head(svg: &mut Svg, rows: &[Row]) {
    let count = rows.len();
    let proved = rows.iter().filter(|row| row.proved).count();
    let title = match count {
        1 => "taut: one daemon, one planner".to_owned(),
        _ => format!("taut: one daemon, {count} planners"),
    };
    svg.label([MARGIN, 42.0], "title", &title);
    let text = "free of collisions at every instant of the motion. Lengths say how many metres the joints move the robot's farthest points.";
    svg.label(
        [MARGIN, 66.0],
        "small",
        &format!("{proved} of {count} shortened paths are proved {text}"),
    );
    legend(svg);
}

/// What each line and each colour means.
fn legend(svg: &mut Svg) {
    let mut x = MARGIN;
    for (class, text) in [("before", "as planned"), ("after", "shortened")] {
        svg.line(&[[x, 90.0], [x + 34.0, 90.0]], class, text);
        svg.label([x + 42.0, 94.0], "small", text);
        x += 132.0;
    }
    for class in ["start", "goal", "obstacle"] {
        let corners = [[x, 83.0], [x + 22.0, 83.0], [x + 22.0, 97.0], [x, 97.0]];
        elements::outline(svg, &corners, class, class);
        svg.label([x + 30.0, 94.0], "small", class);
        x += 82.0;
    }
}

fn card(svg: &mut Svg, row: &Row, world: &World) {
    let [width, height] = CARD;
    svg.element(
        "rect",
        &[
            ("class", &"card"),
            ("width", &width),
            ("height", &height),
            ("rx", &10),
        ],
    );
    labels(svg, row, width - 20.0);
    views(svg, &Panel::new(world, &row.before, &row.after));
}

/// What is said of a planner, up to the right border.
fn labels(svg: &mut Svg, row: &Row, right: f64) {
    let name = format!("Planner {}: {}", row.planner, row.problem);
    let robot = format!("{}, seed {}", row.robot, row.seed);
    let (class, verdict) = verdict(row);
    svg.label([20.0, 30.0], "name", &name);
    svg.label([right, 30.0], class, &verdict);
    svg.label([20.0, 52.0], "small", &figures(row));
    svg.label([right, 52.0], "small right", &robot);
}

/// How it is drawn, and in words.
fn verdict(row: &Row) -> (&'static str, String) {
    match &row.error {
        None if row.proved => ("proved", "✓ proved".to_owned()),
        None => ("failed", format!("not proved: {}", row.code)),
        Some(error) => ("failed", error.clone()),
    }
}

/// The panel from the side and from above, or only from above where that shows it all.
fn views(svg: &mut Svg, panel: &Panel) {
    let views: &[View] = match panel.is_flat() {
        true => &[View::TOP],
        false => &[View::SIDE, View::TOP],
    };
    let [width, height] = CARD;
    let gap = 12.0;
    let wide = (width - 40.0 - gap * (views.len() - 1) as f64) / views.len() as f64;
    for (index, view) in views.iter().enumerate() {
        let corner = [20.0 + index as f64 * (wide + gap), 66.0];
        panel.draw(svg, *view, corner, [wide, height - 102.0]);
    }
}

fn figures(row: &Row) -> String {
    let (Some(before), Some(after)) = (row.length_before, row.length_after) else {
        return String::new();
    };
    let percent = row.saved_percent().unwrap_or(0.0);
    let clearance = report::clearance(row.clearance_m);
    let time = row.time_s.map_or(String::new(), report::time);
    format!("length {before:.2} → {after:.2} (−{percent:.1} %)  ·  {clearance}  ·  {time}")
}

//! The picture of `taut demo`: a card for each planner, its path before and after among the
//! obstacles.

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
    let width = MARGIN + columns as f64 * (CARD[0] + MARGIN);
    let height = HEAD + lines as f64 * (CARD[1] + MARGIN);
    let mut svg = Svg::new(width, height, STYLE);
    svg.element(
        "rect",
        &[("class", &"page"), ("width", &width), ("height", &height)],
    );
    head(&mut svg, rows);
    for (index, (row, world)) in rows.iter().zip(worlds).enumerate() {
        let x = MARGIN + (index % columns) as f64 * (CARD[0] + MARGIN);
        let y = HEAD + (index / columns) as f64 * (CARD[1] + MARGIN);
        let place = format!("translate({x} {y})");
        svg.begin(
            "g",
            &[
                ("id", &format!("planner-{}", row.planner)),
                ("transform", &place),
            ],
        );
        card(&mut svg, row, world);
        svg.end();
    }
    svg.finish()
}

fn head(svg: &mut Svg, rows: &[Row]) {
    let proved = rows.iter().filter(|row| row.proved).count();
    let planners = if rows.len() == 1 {
        "one planner".to_owned()
    } else {
        format!("{} planners", rows.len())
    };
    svg.label(
        [MARGIN, 42.0],
        "title",
        &format!("taut: one daemon, {planners}"),
    );
    let text = "free of collisions at every instant of the motion. Lengths say how many metres the joints move the robot's farthest points.";
    svg.label(
        [MARGIN, 66.0],
        "small",
        &format!(
            "{proved} of {} shortened paths are proved {text}",
            rows.len()
        ),
    );
    let mut x = MARGIN;
    for (class, text) in [("before", "as planned"), ("after", "shortened")] {
        svg.line(&[[x, 90.0], [x + 34.0, 90.0]], class, text);
        svg.label([x + 42.0, 94.0], "small", text);
        x += 132.0;
    }
    for (class, text) in [
        ("start", "start"),
        ("goal", "goal"),
        ("obstacle", "obstacle"),
    ] {
        svg.outline(
            &[[x, 83.0], [x + 22.0, 83.0], [x + 22.0, 97.0], [x, 97.0]],
            class,
            text,
        );
        svg.label([x + 30.0, 94.0], "small", text);
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
    svg.label(
        [20.0, 30.0],
        "name",
        &format!("Planner {}: {}", row.planner, row.problem),
    );
    let right = width - 20.0;
    match &row.error {
        None if row.proved => svg.label([right, 30.0], "proved", "✓ proved"),
        None => svg.label(
            [right, 30.0],
            "failed",
            &format!("not proved: {}", row.code),
        ),
        Some(error) => svg.label([right, 30.0], "failed", error),
    }
    svg.label([20.0, 52.0], "small", &figures(row));
    svg.label(
        [right, 52.0],
        "small right",
        &format!("{}, seed {}", row.robot, row.seed),
    );
    let scene = Panel::new(world, &row.before, &row.after);
    let views: &[View] = if scene.is_flat() {
        &[View::TOP]
    } else {
        &[View::SIDE, View::TOP]
    };
    let gap = 12.0;
    let wide = (width - 40.0 - gap * (views.len() - 1) as f64) / views.len() as f64;
    for (index, view) in views.iter().enumerate() {
        scene.draw(
            svg,
            *view,
            [20.0 + index as f64 * (wide + gap), 66.0],
            [wide, height - 102.0],
        );
    }
}

fn figures(row: &Row) -> String {
    let (Some(before), Some(after)) = (row.length_before, row.length_after) else {
        return String::new();
    };
    let percent = row.saved_percent().unwrap_or(0.0);
    let clearance = row.clearance_m.map_or("nothing near".to_owned(), |m| {
        format!("clearance ≥ {}", report::length(m))
    });
    let time = row.time_s.map_or(String::new(), report::time);
    format!("length {before:.2} → {after:.2} (−{percent:.1} %)  ·  {clearance}  ·  {time}")
}

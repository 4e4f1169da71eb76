//! The elements that a picture of the demo is drawn of.

use crate::cli::svg::{Point, Svg, joined, number};

/// An upright rectangle at the origin.
pub(super) fn rectangle(svg: &mut Svg, class: &str, [width, height]: [f64; 2]) {
    svg.element(
        "rect",
        &[("class", &class), ("width", &width), ("height", &height)],
    );
}

/// A closed outline, with a name that a pointer over it shows.
pub(super) fn outline(svg: &mut Svg, points: &[Point], class: &str, title: &str) {
    let points = joined(points);
    svg.titled("polygon", &[("class", &class), ("points", &points)], title);
}

/// A dot.
pub(super) fn dot(svg: &mut Svg, [x, y]: Point, radius: f64, class: &str) {
    svg.element(
        "circle",
        &[
            ("class", &class),
            ("cx", &number(x)),
            ("cy", &number(y)),
            ("r", &radius),
        ],
    );
}

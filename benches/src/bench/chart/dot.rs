//! A dot of the chart.

use std::fmt::Display;

use crate::svg::{Point, Svg, number};

/// A dot filled with so much of its colour, with a name that a pointer over it shows.
pub(super) struct Dot<'a> {
    pub(super) at: Point,
    pub(super) radius: f64,
    pub(super) class: &'a str,
    /// In [0, 1].
    pub(super) opacity: f64,
    pub(super) title: &'a str,
}

impl Dot<'_> {
    pub(super) fn draw(&self, svg: &mut Svg) {
        let [x, y] = self.at;
        let attributes: [(&str, &dyn Display); 5] = [
            ("class", &self.class),
            ("cx", &number(x)),
            ("cy", &number(y)),
            ("r", &self.radius),
            ("fill-opacity", &format!("{:.2}", self.opacity)),
        ];
        svg.titled("circle", &attributes, self.title);
    }
}

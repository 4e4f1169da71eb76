//! Time to the right, by its logarithm, and remaining length upwards.

use std::fmt::Display;

use crate::svg::{Point, Svg};

/// From times and lengths to pixels of a rectangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    /// Left, top, right and bottom edges (px).
    pub edges: [f64; 4],
    /// Logarithms of the first and the last time (s), whole decades.
    decades: [i32; 2],
    /// Lengths at the bottom and at the top.
    lengths: [f64; 2],
}

impl Axes {
    /// Around all of these times and lengths.
    pub(super) fn around(edges: [f64; 4], times: &[f64], lengths: &[f64]) -> Self {
        let times: Vec<f64> = finite(times)
            .filter(|time| *time > 0.0)
            .collect();
        let first = times.iter().copied().fold(1e-3, f64::min);
        let last = times.iter().copied().fold(1e-2, f64::max);
        let low = lengths.iter().copied().fold(1.0, f64::min);
        let high = finite(lengths).fold(1.0, f64::max);
        let room = 0.06 * (high - low).max(0.01);
        Self {
            edges,
            decades: [first.log10().floor() as i32, last.log10().ceil() as i32],
            lengths: [low - room, high + room],
        }
    }

    /// Pixels of a time.
    pub(super) fn x(&self, time_s: f64) -> f64 {
        let [left, _, right, _] = self.edges;
        let [first, last] = self.decades.map(f64::from);
        let part = (time_s.log10() - first) / (last - first);
        left + part.clamp(0.0, 1.0) * (right - left)
    }

    /// Pixels of a length.
    pub(super) fn y(&self, length: f64) -> f64 {
        let [_, top, _, bottom] = self.edges;
        let [low, high] = self.lengths;
        bottom - ((length - low) / (high - low)).clamp(0.0, 1.0) * (bottom - top)
    }

    /// Pixels of both.
    pub(super) fn point(&self, time_s: f64, length: f64) -> Point {
        [self.x(time_s), self.y(length)]
    }

    /// The time at a pixel (s).
    pub(super) fn time_s(&self, x: f64) -> f64 {
        let [left, _, right, _] = self.edges;
        let [first, last] = self.decades.map(f64::from);
        10_f64.powf(first + (x - left) / (right - left) * (last - first))
    }

    /// Draws grid, figures and names.
    pub(super) fn draw(&self, svg: &mut Svg) {
        let [left, top, right, bottom] = self.edges;
        self.plot(svg);
        self.decades(svg);
        self.ticks(svg);
        rule(svg, "axis", [left, top], [left, bottom]);
        rule(svg, "axis", [left, bottom], [right, bottom]);
        let middle = [(left + right) / 2.0, bottom + 36.0];
        svg.label(middle, "small middle", "time on the clock; of peers, CPU");
    }

    fn plot(&self, svg: &mut Svg) {
        let [left, top, right, bottom] = self.edges;
        let attributes: [(&str, &dyn Display); 5] = [
            ("class", &"plot"),
            ("x", &left),
            ("y", &top),
            ("width", &(right - left)),
            ("height", &(bottom - top)),
        ];
        svg.element("rect", &attributes);
    }

    fn decades(&self, svg: &mut Svg) {
        let [_, top, _, bottom] = self.edges;
        for decade in self.decades[0]..=self.decades[1] {
            let x = self.x(10_f64.powi(decade));
            rule(svg, "grid", [x, top], [x, bottom]);
            svg.label([x, bottom + 17.0], "small middle", &decade_name(decade));
        }
    }

    fn ticks(&self, svg: &mut Svg) {
        let [left, _, right, _] = self.edges;
        for length in self.round_lengths() {
            let y = self.y(length);
            rule(svg, "grid", [left, y], [right, y]);
            let place = [left - 8.0, y + 4.0];
            svg.label(place, "small right", &format!("{length:.2}"));
        }
    }

    /// Where lines of the grid stand.
    fn round_lengths(&self) -> impl Iterator<Item = f64> {
        let [low, high] = self.lengths;
        let step = step(high - low);
        let ticks = (low / step).ceil() as i64..=(high / step).floor() as i64;
        ticks.map(move |tick| tick as f64 * step)
    }
}

fn finite(values: &[f64]) -> impl Iterator<Item = f64> {
    values
        .iter()
        .copied()
        .filter(|value| value.is_finite())
}

fn rule(svg: &mut Svg, class: &str, from: Point, to: Point) {
    svg.element(
        "line",
        &[
            ("class", &class),
            ("x1", &from[0]),
            ("y1", &from[1]),
            ("x2", &to[0]),
            ("y2", &to[1]),
        ],
    );
}

/// Distance of the lines of a grid: 1, 2, 2.5 or 5 of a power of ten, some five of them.
fn step(range: f64) -> f64 {
    let rough = range / 5.0;
    let power = 10_f64.powf(rough.log10().floor());
    let round = [1.0, 2.0, 2.5, 5.0, 10.0]
        .into_iter()
        .find(|round| round * power >= rough)
        .unwrap_or(10.0);
    round * power
}

fn decade_name(decade: i32) -> String {
    match decade {
        ..-6 => format!("10^{decade} s"),
        -6 => "1 µs".to_owned(),
        -5 => "10 µs".to_owned(),
        -4 => "0.1 ms".to_owned(),
        -3 => "1 ms".to_owned(),
        -2 => "10 ms".to_owned(),
        -1 => "0.1 s".to_owned(),
        0.. => format!("{} s", 10_f64.powi(decade)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_equally_far_apart_and_pixels_lead_back_to_times() {
        let axes = Axes::around([100.0, 0.0, 400.0, 200.0], &[2e-5, 3e-3], &[0.5]);
        assert_eq!(
            [1e-5, 1e-4, 1e-3, 1e-2].map(|time| axes.x(time).round()),
            [100.0, 200.0, 300.0, 400.0]
        );
        assert!((axes.time_s(axes.x(3e-4)) - 3e-4).abs() < 1e-12);
        assert!(axes.y(1.0) > 0.0 && axes.y(0.5) < 200.0 && axes.y(0.5) > axes.y(1.0));
    }

    #[test]
    fn grid_lines_stand_at_round_lengths() {
        assert_eq!(
            [0.5, 0.9, 0.04].map(|range| (step(range) * 1e3).round()),
            [100.0, 200.0, 10.0]
        );
    }
}

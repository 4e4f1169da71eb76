//! A writer of SVG: elements, escaped text, nothing else. `taut-bench` has this file too.

use std::fmt::{Display, Write};

/// A point of the picture (px), y downwards.
pub(super) type Point = [f64; 2];

/// A picture being written.
pub(super) struct Svg {
    text: String,
    open: Vec<&'static str>,
}

impl Svg {
    /// An empty picture of this size with a style sheet.
    pub(super) fn new(width: f64, height: f64, style: &str) -> Self {
        let mut svg = Self {
            text: String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"),
            open: Vec::new(),
        };
        svg.begin(
            "svg",
            &[
                ("xmlns", &"http://www.w3.org/2000/svg"),
                ("width", &width),
                ("height", &height),
                ("viewBox", &format!("0 0 {width} {height}")),
            ],
        );
        svg.style(style);
        svg
    }

    fn style(&mut self, style: &str) {
        self.begin("style", &[]);
        self.text.push_str(&escaped(style));
        self.end();
    }

    /// Opens an element.
    pub(super) fn begin(&mut self, tag: &'static str, attributes: &[(&str, &dyn Display)]) {
        self.start(tag, attributes);
        self.text.push_str(">\n");
        self.open.push(tag);
    }

    /// Closes the element opened last.
    pub(super) fn end(&mut self) {
        if let Some(tag) = self.open.pop() {
            // Writing to a string cannot fail.
            let _ = writeln!(self.text, "</{tag}>");
        }
    }

    /// An element without content.
    pub(super) fn element(&mut self, tag: &'static str, attributes: &[(&str, &dyn Display)]) {
        self.start(tag, attributes);
        self.text.push_str("/>\n");
    }

    /// A line of text that starts, or with another anchor ends, at a point.
    pub(super) fn label(&mut self, [x, y]: Point, class: &str, text: &str) {
        self.start(
            "text",
            &[("x", &number(x)), ("y", &number(y)), ("class", &class)],
        );
        let _ = writeln!(self.text, ">{}</text>", escaped(text));
    }

    /// An open line through points, with a name that a pointer over it shows.
    pub(super) fn line(&mut self, points: &[Point], class: &str, title: &str) {
        let points = joined(points);
        self.titled("polyline", &[("class", &class), ("points", &points)], title);
    }

    /// An element with a name that a pointer over it shows.
    pub(super) fn titled(&mut self, tag: &str, attributes: &[(&str, &dyn Display)], title: &str) {
        self.start(tag, attributes);
        let title = escaped(title);
        let _ = writeln!(self.text, "><title>{title}</title></{tag}>");
    }

    /// The whole picture.
    pub(super) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.end();
        }
        self.text
    }

    fn start(&mut self, tag: &str, attributes: &[(&str, &dyn Display)]) {
        let _ = write!(self.text, "<{tag}");
        for (name, value) in attributes {
            let _ = write!(self.text, " {name}=\"{}\"", escaped(&value.to_string()));
        }
    }
}

/// A coordinate: a tenth of a pixel is fine enough and keeps the file small.
pub(super) fn number(value: f64) -> String {
    format!("{value:.1}")
}

pub(super) fn joined(points: &[Point]) -> String {
    let mut pairs: Vec<String> = points.iter().map(pair).collect();
    pairs.dedup();
    pairs.join(" ")
}

fn pair([x, y]: &Point) -> String {
    format!("{},{}", number(*x), number(*y))
}

/// Text as XML has it, in content and in attributes; characters that XML cannot have are left out.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&apos;"),
            '\t' | '\n' => out.push(character),
            '\u{fffe}' | '\u{ffff}' => {}
            character if character.is_control() => {}
            character => out.push(character),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_the_text_the_picture_is_well_formed_and_says_it() {
        let mut svg = Svg::new(10.0, 10.0, ".a > b { fill: red }");
        svg.begin("g", &[("id", &"a \"quoted\" <id> & 'more'")]);
        svg.label([1.0, 2.0], "a", "<script> & \"x\" \u{0}\u{ffff}é");
        svg.line(&[[0.0, 0.0], [1.0, 1.0]], "before", "]]> & <");
        let text = svg.finish();
        let document = roxmltree::Document::parse(&text).unwrap();
        let label = document
            .descendants()
            .find(|node| node.has_tag_name("text"))
            .unwrap();
        assert_eq!(label.text(), Some("<script> & \"x\" é"));
        let group = document
            .descendants()
            .find(|node| node.has_tag_name("g"))
            .unwrap();
        assert_eq!(group.attribute("id"), Some("a \"quoted\" <id> & 'more'"));
    }
}

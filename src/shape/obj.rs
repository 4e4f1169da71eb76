//! Wavefront OBJ: its polygons.
//!
//! Our own reader: of the crates for it none reads `\` at a line's end and `#` within a line, and
//! all pass over what they do not know, which may be half of the shape. Here a word that would add
//! a surface is refused by name.

use super::surface::{Surface, number};
use crate::math::Vec3;

/// Words that say nothing about the shape: names, groups, materials, normals, how it is shown.
const PASSED_OVER: [&str; 22] = [
    "vt",
    "vn",
    "vp",
    "g",
    "o",
    "s",
    "mg",
    "usemtl",
    "mtllib",
    "usemap",
    "maplib",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "shadow_obj",
    "trace_obj",
    "cstype",
    "deg",
    "bmat",
    "step",
    "end",
];
/// Words of surfaces and curves that are no polygons, and of other files.
const REFUSED: [&str; 16] = [
    "curv", "curv2", "surf", "parm", "trim", "hole", "scrv", "sp", "con", "ctech", "stech", "bsp",
    "bzp", "cdc", "cdp", "call",
];

/// Decodes an OBJ.
pub(super) fn read(bytes: &[u8]) -> Result<Surface, String> {
    if bytes.contains(&0) {
        return Err("not an OBJ file: it is no text in UTF-8".to_owned());
    }
    // Names may be in any encoding, and say nothing.
    let text = String::from_utf8_lossy(bytes);
    let mut reader = Reader::default();
    for (number, line) in logical_lines(text.trim_start_matches('\u{feff}')) {
        reader
            .line(&line)
            .map_err(|reason| format!("not an OBJ file: line {number}: {reason}"))?;
    }
    reader.finish()
}

/// Lines without their comments, those that end in `\` joined with the next, and the number of the
/// first of each.
fn logical_lines(text: &str) -> Vec<(usize, String)> {
    let mut lines = vec![(1, String::new())];
    for (index, line) in text.lines().enumerate() {
        let (line, goes_on) = content(line);
        if let Some((_, joined)) = lines.last_mut() {
            joined.push_str(line);
            joined.push_str(if goes_on { " " } else { "" });
        }
        if !goes_on {
            lines.push((index + 2, String::new()));
        }
    }
    lines
}

/// What a line says, and whether the next one goes on with it.
fn content(line: &str) -> (&str, bool) {
    // A comment ends with its line, so that no path in one takes the next line with it.
    if let Some((before, _)) = line.split_once('#') {
        return (before, false);
    }
    let line = line.trim_end();
    match line.strip_suffix('\\') {
        Some(begun) => (begun, true),
        None => (line, false),
    }
}

#[derive(Default)]
struct Reader {
    surface: Surface,
    /// Corners of all polygons, and where each ends: some files have their faces before their
    /// vertices.
    corners: Vec<u32>,
    ends: Vec<usize>,
    /// The highest vertex that a face names, from 1.
    highest: u32,
}

impl Reader {
    fn line(&mut self, line: &str) -> Result<(), String> {
        let mut words = line.split_whitespace();
        match words.next() {
            None => {}
            Some("v") => self.vertex(words)?,
            Some("f" | "fo") => self.face(words)?,
            Some("l") => self.surface.leave_out("lines"),
            Some("p") => self.surface.leave_out("points"),
            Some(word) => check_passed_over(word)?,
        }
        Ok(())
    }

    fn face<'t>(&mut self, words: impl Iterator<Item = &'t str>) -> Result<(), String> {
        for word in words {
            let corner = self.corner(word)?;
            self.highest = self.highest.max(corner + 1);
            self.corners.push(corner);
        }
        self.ends.push(self.corners.len());
        Ok(())
    }

    fn vertex<'t>(&mut self, words: impl Iterator<Item = &'t str>) -> Result<(), String> {
        let values = words
            .map(number)
            .collect::<Result<Vec<f64>, _>>()?;
        self.surface.vertices.push(position(&values)?);
        Ok(())
    }

    /// The vertex of a face's corner, from 0: `7`, `7/1`, `7//3` or `7/1/3`; -1 is the last one so
    /// far.
    fn corner(&self, word: &str) -> Result<u32, String> {
        let so_far = self.surface.vertices.len();
        let index: Option<i64> = word
            .split('/')
            .next()
            .and_then(|index| index.parse().ok());
        let place = index.and_then(|index| place(index, so_far));
        place.ok_or_else(|| {
            format!(
                "a face names vertex {word:?}; valid: 1, 2, … or −1 … −{so_far} from the last one back"
            )
        })
    }

    fn finish(mut self) -> Result<Surface, String> {
        let highest = self.highest;
        let there = self.surface.vertices.len();
        if highest as usize > there {
            return Err(format!(
                "not an OBJ file: a face names vertex {highest}; there are {there}"
            ));
        }
        let mut first = 0;
        for end in self.ends {
            self.surface
                .add_polygon(&self.corners[first..end])?;
            first = end;
        }
        Ok(self.surface)
    }
}

/// Refuses a word that may add to the shape.
fn check_passed_over(word: &str) -> Result<(), String> {
    if PASSED_OVER.contains(&word) {
        return Ok(());
    }
    if REFUSED.contains(&word) {
        let text = "is of a free-form surface or another file, which is not read";
        return Err(format!(
            "{word:?} {text}; export the mesh as triangles in one file"
        ));
    }
    Err(format!(
        "{word:?} is no word of an OBJ file; shapes are made of v and f"
    ))
}

/// Where the numbers of a vertex are.
fn position(values: &[f64]) -> Result<Vec3, String> {
    match *values {
        // Readers differ: some divide by a weight, some pass over it.
        [_, _, _, weight] if weight != 1.0 => Err(format!(
            "a vertex of weight {weight}; only weight 1 is read, as coordinates are"
        )),
        // Further numbers are a colour.
        [x, y, z, ..] => Ok(Vec3::new(x, y, z)),
        _ => Err(format!(
            "a vertex of {} numbers; it must have x, y and z",
            values.len()
        )),
    }
}

/// The place, from 0, of a vertex that is counted from 1, or back from those there are so far.
fn place(index: i64, so_far: usize) -> Option<u32> {
    let place = match index {
        0 => None,
        1.. => Some(index - 1),
        _ => Some(so_far as i64 + index),
    };
    place
        .and_then(|place| u32::try_from(place).ok())
        .filter(|place| *place < u32::MAX)
}

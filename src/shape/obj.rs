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
    let mut joined = String::new();
    let mut first = 1;
    for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        // A comment ends with its line, so that no path in one takes the next line with it.
        let (line, is_cut) = line
            .split_once('#')
            .map_or((line.trim_end(), false), |(before, _)| (before, true));
        if let Some(begun) = line.strip_suffix('\\').filter(|_| !is_cut) {
            joined.push_str(begun);
            joined.push(' ');
            continue;
        }
        joined.push_str(line);
        reader
            .line(&joined)
            .map_err(|reason| format!("not an OBJ file: line {first}: {reason}"))?;
        joined.clear();
        first = index + 2;
    }
    reader
        .line(&joined)
        .map_err(|reason| format!("not an OBJ file: line {first}: {reason}"))?;
    reader.finish()
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
            Some("f" | "fo") => {
                for word in words {
                    let corner = self.corner(word)?;
                    self.highest = self.highest.max(corner + 1);
                    self.corners.push(corner);
                }
                self.ends.push(self.corners.len());
            }
            Some("l") => self.surface.leave_out("lines"),
            Some("p") => self.surface.leave_out("points"),
            Some(word) if PASSED_OVER.contains(&word) => {}
            Some(word) if REFUSED.contains(&word) => {
                let text = "is of a free-form surface or another file, which is not read";
                return Err(format!(
                    "{word:?} {text}; export the mesh as triangles in one file"
                ));
            }
            Some(word) => {
                return Err(format!(
                    "{word:?} is no word of an OBJ file; shapes are made of v and f"
                ));
            }
        }
        Ok(())
    }

    fn vertex<'t>(&mut self, words: impl Iterator<Item = &'t str>) -> Result<(), String> {
        let values = words.map(number).collect::<Result<Vec<f64>, _>>()?;
        match values[..] {
            // Readers differ: some divide by a weight, some pass over it.
            [_, _, _, weight] if weight != 1.0 => Err(format!(
                "a vertex of weight {weight}; only weight 1 is read, as coordinates are"
            )),
            // Further numbers are a colour.
            [x, y, z, ..] => {
                self.surface.vertices.push(Vec3::new(x, y, z));
                Ok(())
            }
            _ => Err(format!(
                "a vertex of {} numbers; it must have x, y and z",
                values.len()
            )),
        }
    }

    /// The vertex of a face's corner, from 0: `7`, `7/1`, `7//3` or `7/1/3`; -1 is the last one so
    /// far.
    fn corner(&self, word: &str) -> Result<u32, String> {
        let so_far = self.surface.vertices.len();
        let index: Option<i64> = word.split('/').next().and_then(|index| index.parse().ok());
        let place = match index {
            Some(index) if index > 0 => Some(index - 1),
            Some(index) if index < 0 => Some(so_far as i64 + index).filter(|place| *place >= 0),
            _ => None,
        };
        let refuse = || {
            format!(
                "a face names vertex {word:?}; valid: 1, 2, … or −1 … −{so_far} from the last one back"
            )
        };
        place
            .and_then(|place| u32::try_from(place).ok())
            .filter(|place| *place < u32::MAX)
            .ok_or_else(refuse)
    }

    fn finish(self) -> Result<Surface, String> {
        let Self {
            mut surface,
            corners,
            ends,
            highest,
        } = self;
        let there = surface.vertices.len();
        if highest as usize > there {
            return Err(format!(
                "not an OBJ file: a face names vertex {highest}; there are {there}"
            ));
        }
        let mut first = 0;
        for end in ends {
            surface.add_polygon(&corners[first..end])?;
            first = end;
        }
        Ok(surface)
    }
}

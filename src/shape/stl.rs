//! STL, text and binary.
//!
//! Our own reader: the crates for it read coordinates as f32, which is what a binary file has and a
//! text file has not. Of text, every dialect that other readers take is read: any case, any line
//! breaks, names or none, several solids, and loops of more than three corners.

use super::surface::Surface;
use crate::math::Vec3;

/// Bytes of a binary STL before its first triangle, and of each triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Decodes an STL. The size decides between binary and text: many binary headers start with
/// `solid `.
pub(super) fn read(bytes: &[u8]) -> Result<Surface, String> {
    let announced = bytes
        .get(80..HEADER)
        .map(|n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]) as usize);
    let size = announced.map(|count| HEADER + TRIANGLE * count);
    if size != Some(bytes.len()) && looks_like_text(bytes) {
        // Some writers fill the last block of a file.
        let end = bytes
            .iter()
            .rposition(|byte| *byte != 0)
            .map_or(0, |last| last + 1);
        return text(&String::from_utf8_lossy(&bytes[..end]))
            .map_err(|reason| format!("not a text STL: {reason}"));
    }
    match (announced, size) {
        // Up to a triangle's worth of stray bytes (a line end) is harmless; more would be triangles
        // lost.
        (Some(_), Some(size)) if (size..size + TRIANGLE).contains(&bytes.len()) => {
            Ok(binary(&bytes[HEADER..size]))
        }
        (Some(count), Some(size)) => {
            let what = if bytes.len() < size {
                "cut short"
            } else {
                "longer than it says"
            };
            Err(format!(
                "{what}: {count} triangles need {size} bytes, the file has {}",
                bytes.len()
            ))
        }
        _ => Err(format!(
            "cut short: an STL has at least {HEADER} bytes, the file has {}",
            bytes.len()
        )),
    }
}

fn looks_like_text(bytes: &[u8]) -> bool {
    let start = bytes
        .strip_prefix(b"\xef\xbb\xbf")
        .unwrap_or(bytes)
        .trim_ascii_start();
    let starts = |word: &[u8]| {
        start
            .get(..word.len())
            .is_some_and(|bytes| bytes.eq_ignore_ascii_case(word))
    };
    let last = bytes
        .iter()
        .rposition(|byte| *byte != 0)
        .unwrap_or_default();
    (starts(b"solid") || starts(b"facet")) && !bytes[..last].contains(&0)
}

/// Triangles of a binary STL: each a normal, which says nothing new, three corners, and two bytes
/// of anything.
fn binary(triangles: &[u8]) -> Surface {
    let number = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let corner = |b: &[u8]| Vec3::new(number(b), number(&b[4..]), number(&b[8..]));
    let each = triangles.chunks_exact(TRIANGLE);
    let faces = (0..each.len() as u32)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    let vertices = each
        .flat_map(|triangle| triangle[12..48].chunks_exact(12))
        .map(corner)
        .collect();
    Surface {
        vertices,
        triangles: faces,
        ..Surface::default()
    }
}

fn text(text: &str) -> Result<Surface, String> {
    let mut reader = TextReader::default();
    for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        reader
            .line(line)
            .map_err(|reason| format!("line {}: {reason}", index + 1))?;
    }
    if reader.in_solid || !reader.corners.is_empty() || !reader.coordinates.is_empty() {
        return Err(
            "cut short: it ends before `endsolid`; if nothing is missing, add that line".to_owned(),
        );
    }
    Ok(reader.surface)
}

/// What was read so far.
#[derive(Default)]
struct TextReader {
    surface: Surface,
    in_solid: bool,
    /// Corners of the loop that is being read.
    corners: Vec<Vec3>,
    /// Coordinates of the corner that is being read.
    coordinates: Vec<f64>,
    in_vertex: bool,
    /// Words after `normal`; normals say nothing new, and some are no numbers.
    normal_left: usize,
}

impl TextReader {
    fn line(&mut self, line: &str) -> Result<(), String> {
        let mut words: &[&str] = &line.split_whitespace().collect::<Vec<_>>();
        while let Some((word, rest)) = words.split_first() {
            words = rest;
            let lower = word.to_ascii_lowercase();
            match lower.as_str() {
                _ if self.in_vertex => self.coordinate(word)?,
                "solid" | "endsolid" => {
                    self.end_loop()?;
                    self.in_solid = lower == "solid";
                    words = after_name(rest);
                }
                "facet" | "outer" | "loop" | "endloop" | "endfacet" => self.end_loop()?,
                "normal" => self.normal_left = 3,
                "vertex" => (self.in_vertex, self.normal_left) = (true, 0),
                _ if self.normal_left > 0 => self.normal_left -= 1,
                _ => return Err(format!("{word:?} is no word of an STL; valid: {WORDS}")),
            }
        }
        Ok(())
    }

    fn coordinate(&mut self, word: &str) -> Result<(), String> {
        self.coordinates.push(super::surface::number(word)?);
        if let [x, y, z] = self.coordinates[..] {
            self.corners.push(Vec3::new(x, y, z));
            self.coordinates.clear();
            self.in_vertex = false;
        }
        Ok(())
    }

    /// Ends the loop that is being read, if there is one.
    fn end_loop(&mut self) -> Result<(), String> {
        self.normal_left = 0;
        match self.corners.len() {
            0 => return Ok(()),
            count @ 1..3 => {
                return Err(format!("a facet of {count} corners; is a vertex missing?"));
            }
            _ => self.surface.add_corners(&self.corners)?,
        }
        self.corners.clear();
        Ok(())
    }
}

const WORDS: &str = "solid, facet, normal, outer, loop, vertex, endloop, endfacet, endsolid";

/// What follows the name of a solid on its line: nothing, or its facets in a file without line
/// breaks.
fn after_name<'w, 't>(words: &'w [&'t str]) -> &'w [&'t str] {
    let is = |word: &str, wanted: &str| word.eq_ignore_ascii_case(wanted);
    let facet = words
        .windows(2)
        .position(|pair| is(pair[0], "facet") && is(pair[1], "normal"));
    let solid = words.iter().position(|word| is(word, "endsolid"));
    &words[facet.or(solid).unwrap_or(words.len())..]
}

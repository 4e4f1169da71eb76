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
    let count = announced(bytes);
    let size = count.map(|count| HEADER + TRIANGLE * count);
    if size != Some(bytes.len()) && looks_like_text(bytes) {
        return text(&String::from_utf8_lossy(without_fill(bytes)))
            .map_err(|reason| format!("not a text STL: {reason}"));
    }
    let Some(size) = size else {
        return Err(format!(
            "cut short: an STL has at least {HEADER} bytes, the file has {}",
            bytes.len()
        ));
    };
    check_size(bytes.len(), size)?;
    Ok(binary(&bytes[HEADER..size]))
}

/// How many triangles the header of a binary file says.
fn announced(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..HEADER)?;
    Some(u32::from_le_bytes(count.try_into().ok()?) as usize)
}

/// The bytes up to the last that is not 0: some writers fill the last block of a file.
fn without_fill(bytes: &[u8]) -> &[u8] {
    let last = bytes.iter().rposition(|byte| *byte != 0);
    &bytes[..last.map_or(0, |last| last + 1)]
}

/// Refuses a binary file of another size than its triangles need.
fn check_size(bytes: usize, size: usize) -> Result<(), String> {
    // Up to a triangle's worth of stray bytes (a line end) is harmless; more would be triangles
    // lost.
    let what = match bytes {
        _ if bytes < size => "cut short",
        _ if bytes < size + TRIANGLE => return Ok(()),
        _ => "longer than it says",
    };
    let count = (size - HEADER) / TRIANGLE;
    Err(format!(
        "{what}: {count} triangles need {size} bytes, the file has {bytes}"
    ))
}

fn looks_like_text(bytes: &[u8]) -> bool {
    let marked = bytes.strip_prefix(b"\xef\xbb\xbf");
    let start = marked.unwrap_or(bytes).trim_ascii_start();
    let begins = starts_with(start, b"solid") || starts_with(start, b"facet");
    let last = bytes.iter().rposition(|byte| *byte != 0);
    begins && !bytes[..last.unwrap_or_default()].contains(&0)
}

fn starts_with(text: &[u8], word: &[u8]) -> bool {
    text.get(..word.len())
        .is_some_and(|start| start.eq_ignore_ascii_case(word))
}

/// Triangles of a binary STL: each a normal, which says nothing new, three corners, and two bytes
/// of anything.
fn binary(triangles: &[u8]) -> Surface {
    let each = triangles.chunks_exact(TRIANGLE);
    Surface {
        triangles: (0..each.len() as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect(),
        vertices: each.flat_map(corners).collect(),
        ..Surface::default()
    }
}

fn corners(triangle: &[u8]) -> impl Iterator<Item = Vec3> {
    let number = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let corners = triangle[12..48].chunks_exact(12);
    corners.map(move |b| Vec3::new(number(b), number(&b[4..]), number(&b[8..])))
}

fn text(text: &str) -> Result<Surface, String> {
    let mut reader = TextReader::default();
    for (index, line) in text
        .trim_start_matches('\u{feff}')
        .lines()
        .enumerate()
    {
        reader
            .line(line)
            .map_err(|reason| format!("line {}: {reason}", index + 1))?;
    }
    reader.finish()
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
            let is_name_next = self.word(word)?;
            words = if is_name_next { after_name(rest) } else { rest };
        }
        Ok(())
    }

    /// Reads a word; whether the name of a solid may follow it.
    fn word(&mut self, word: &str) -> Result<bool, String> {
        if self.in_vertex {
            self.coordinate(word)?;
            return Ok(false);
        }
        let lower = word.to_ascii_lowercase();
        let is_name_next = matches!(lower.as_str(), "solid" | "endsolid");
        if is_name_next {
            self.end_loop()?;
            self.in_solid = lower == "solid";
        } else {
            self.word_of_facet(word, &lower)?;
        }
        Ok(is_name_next)
    }

    fn word_of_facet(&mut self, word: &str, lower: &str) -> Result<(), String> {
        match lower {
            "facet" | "outer" | "loop" | "endloop" | "endfacet" => self.end_loop()?,
            "normal" => self.normal_left = 3,
            "vertex" => (self.in_vertex, self.normal_left) = (true, 0),
            _ if self.normal_left > 0 => self.normal_left -= 1,
            _ => return Err(format!("{word:?} is no word of an STL; valid: {WORDS}")),
        }
        Ok(())
    }

    fn finish(self) -> Result<Surface, String> {
        if self.in_solid || !self.corners.is_empty() || !self.coordinates.is_empty() {
            let text = "cut short: it ends before `endsolid`; if nothing is missing, add that line";
            return Err(text.to_owned());
        }
        Ok(self.surface)
    }

    fn coordinate(&mut self, word: &str) -> Result<(), String> {
        self.coordinates
            .push(super::surface::number(word)?);
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
    let facet = words
        .windows(2)
        .position(|pair| is_word(pair[0], "facet") && is_word(pair[1], "normal"));
    let solid = || {
        words
            .iter()
            .position(|word| is_word(word, "endsolid"))
    };
    &words[facet.or_else(solid).unwrap_or(words.len())..]
}

fn is_word(word: &str, wanted: &str) -> bool {
    word.eq_ignore_ascii_case(wanted)
}

//! Bare points as text: x, y and z on a line, divided by spaces or commas; what follows on the line
//! (colours, intensities) is not read.

use super::bytes::point_of_words;
use super::scan::{Scan, check_count};
use crate::math::Vec3;

pub(super) fn read(bytes: &[u8]) -> Result<Scan, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "it is no text in UTF-8")?;
    let mut slots = Vec::new();
    for (index, line) in text
        .trim_start_matches('\u{feff}')
        .lines()
        .enumerate()
    {
        let at_line = |reason| format!("line {}: {reason}", index + 1);
        slots.extend(point(line).map_err(at_line)?);
        check_count(slots.len())?;
    }
    let mut scan = Scan::with_slots(slots.len())?;
    scan.extend(slots);
    Ok(scan)
}

/// The point of a line; none on an empty line or a comment (`#` or `//`).
fn point(line: &str) -> Result<Option<Vec3>, String> {
    let content = line.split(['#']).next().unwrap_or_default();
    if content.starts_with("//") {
        return Ok(None);
    }
    let words: Vec<&str> = content
        .split(|letter: char| letter.is_whitespace() || ",;".contains(letter))
        .filter(|word| !word.is_empty())
        .collect();
    match words[..] {
        [] => Ok(None),
        [x, y, z, ..] => point_of_words([x, y, z]).map(Some),
        _ => Err(format!("{} numbers; a point has x, y and z", words.len())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_points_with_all_their_digits() {
        let text = b"\xef\xbb\xbf// hall\n# x y z intensity\n400321.652 5812345.789 12.5 0.7\r\n\n1,2, 3 # corner\n";
        let scan = read(text).unwrap();
        let wanted = [
            Vec3::new(400321.652, 5812345.789, 12.5),
            Vec3::new(1.0, 2.0, 3.0),
        ];
        assert_eq!(scan.points, wanted);
    }

    #[test]
    fn what_is_no_point_is_refused_with_its_line() {
        for (text, part) in [
            ("0 0 0\n1 2\n", "line 2: 2 numbers"),
            ("x y z\n", "line 1: \"x\" is no number"),
        ] {
            let refusal = read(text.as_bytes()).unwrap_err();
            assert!(refusal.contains(part), "{refusal}");
        }
    }
}

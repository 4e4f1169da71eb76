//! numpy's `.npy`: an array of f4 or f8, a row a point, whose first three columns are x, y and z.
//! An image of points (rows × columns × 3) is as many of them.

use super::bytes::{Column, Floats, check_size, points};
use super::scan::Scan;

const MAGIC: &[u8] = b"\x93NUMPY";
/// Most columns of a row: an array of more is one whose columns are the points.
const MOST_COLUMNS: usize = 32;

pub(super) fn read(bytes: &[u8]) -> Result<Scan, String> {
    let (header, data) = split(bytes)?;
    let floats = floats(value(header, "descr")?)?;
    let shape = Shape::read(value(header, "shape")?)?;
    let is_fortran = value(header, "fortran_order")?.starts_with("True");
    let mut scan = Scan::with_slots(shape.rows)?;
    check_size(data.len(), shape.rows * shape.columns * floats.size, 0)?;
    let columns = shape.first_columns(floats, is_fortran);
    scan.extend(points(data, &columns, shape.rows));
    Ok(scan)
}

/// Header text, and what follows it.
fn split(bytes: &[u8]) -> Result<(&str, &[u8]), String> {
    let cut_short = || "cut short: it ends within its header".to_owned();
    let rest = bytes
        .strip_prefix(MAGIC)
        .ok_or("it is no npy file: it does not begin with \\x93NUMPY")?;
    let (version, rest) = rest
        .split_first_chunk::<2>()
        .ok_or_else(cut_short)?;
    let (length, rest) = match version[0] {
        1 => {
            let (size, rest) = rest.split_first_chunk().ok_or_else(cut_short)?;
            (usize::from(u16::from_le_bytes(*size)), rest)
        }
        2 | 3 => {
            let (size, rest) = rest.split_first_chunk().ok_or_else(cut_short)?;
            (u32::from_le_bytes(*size) as usize, rest)
        }
        other => return Err(format!("it is npy of version {other}; valid: 1, 2, 3")),
    };
    let (header, data) = rest
        .split_at_checked(length)
        .ok_or_else(cut_short)?;
    let header = std::str::from_utf8(header).map_err(|_| "its header is no text")?;
    Ok((header, data))
}

/// What stands behind a name in the header, a dictionary of Python's, to its end.
fn value<'a>(header: &'a str, name: &str) -> Result<&'a str, String> {
    let found = header
        .split_once(&format!("'{name}'"))
        .and_then(|(_, rest)| rest.trim_start().strip_prefix(':'));
    found
        .map(str::trim_start)
        .ok_or_else(|| format!("its header has no {name:?}"))
}

fn floats(descr: &str) -> Result<Floats, String> {
    let kind = descr
        .strip_prefix('\'')
        .and_then(|rest| rest.split_once('\''))
        .map(|(kind, _)| kind);
    let (is_big_endian, size) = match kind {
        Some("<f4") => (false, 4),
        Some("<f8") => (false, 8),
        Some(">f4") => (true, 4),
        Some(">f8") => (true, 8),
        _ => {
            let said = kind.map_or("a structured type".to_owned(), |kind| format!("{kind:?}"));
            return Err(format!(
                "its numbers are {said}; valid: f4 and f8, as in array.astype('<f8')"
            ));
        }
    };
    Ok(Floats {
        size,
        is_big_endian,
    })
}

/// Points, and numbers of each.
struct Shape {
    rows: usize,
    columns: usize,
}

impl Shape {
    fn read(text: &str) -> Result<Self, String> {
        let said = text
            .strip_prefix('(')
            .and_then(|rest| rest.split_once(')'))
            .map(|(inside, _)| inside)
            .unwrap_or_default();
        let parts = said
            .split(',')
            .map(str::trim)
            .filter(|part| !part.is_empty());
        let sizes: Option<Vec<usize>> = parts.map(|part| part.parse().ok()).collect();
        match sizes.as_deref() {
            Some([rows @ .., columns])
                if !rows.is_empty() && (3..=MOST_COLUMNS).contains(columns) =>
            {
                let rows = rows
                    .iter()
                    .fold(1, |product: usize, size| product.saturating_mul(*size));
                Ok(Self {
                    rows,
                    columns: *columns,
                })
            }
            _ => Err(format!(
                "its shape is ({said}); valid: (points, 3), or up to {MOST_COLUMNS} columns that begin with x, y, z"
            )),
        }
    }

    /// Where x, y and z are. In Fortran's order a column's numbers lie side by side (those of an
    /// image in another order, which makes no other cloud).
    fn first_columns(&self, floats: Floats, is_fortran: bool) -> [Column; 3] {
        let (of_row, of_column) = if is_fortran {
            (1, self.rows)
        } else {
            (self.columns, 1)
        };
        [0, 1, 2].map(|column| Column {
            floats,
            first: column * of_column * floats.size,
            step: of_row * floats.size,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    fn file(descr: &str, order: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let header = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    fn little(numbers: &[f64]) -> Vec<u8> {
        numbers
            .iter()
            .flat_map(|number| number.to_le_bytes())
            .collect()
    }

    #[test]
    fn every_order_of_bytes_and_numbers_gives_the_same_points() {
        let numbers = [400321.652, 2.0, 3.0, 9.0, 4.0, 5.0, 6.0, 9.0];
        let wanted = [Vec3::new(400321.652, 2.0, 3.0), Vec3::new(4.0, 5.0, 6.0)];
        let turned: Vec<f64> = (0..8)
            .map(|i| numbers[i / 2 + 4 * (i % 2)])
            .collect();
        let big: Vec<u8> = numbers
            .iter()
            .flat_map(|number| number.to_be_bytes())
            .collect();
        for bytes in [
            file("'<f8'", "False", "(2, 4)", &little(&numbers)),
            file("'>f8'", "False", "(2, 4)", &big),
            file("'<f8'", "True", "(2, 4)", &little(&turned)),
            file("'<f8'", "False", "(1, 2, 4)", &little(&numbers)),
        ] {
            assert_eq!(read(&bytes).unwrap().points, wanted);
        }
        let small: Vec<u8> = [1.5f32, 2.0, f32::NAN]
            .iter()
            .chain(&[1.5, 2.5, 3.5])
            .flat_map(|number| number.to_be_bytes())
            .collect();
        let scan = read(&file("'>f4'", "False", "(2, 3)", &small)).unwrap();
        assert_eq!(scan.points, [Vec3::new(1.5, 2.5, 3.5)]);
        assert_eq!(scan.slots, 2);
    }

    #[test]
    fn what_is_no_array_of_points_is_refused() {
        let data = little(&[0.0; 6]);
        for (bytes, part) in [
            (b"PK\x03\x04".to_vec(), "no npy file"),
            (
                file("'<f8'", "False", "(2, 3)", &data)[..40].to_vec(),
                "cut short",
            ),
            (
                file("'<f8'", "False", "(2, 3)", &data[..47]),
                "need 48 bytes after the header, the file has 47",
            ),
            (
                file("'<i4'", "False", "(2, 3)", &data),
                "\"<i4\"; valid: f4 and f8",
            ),
            (
                file("[('x', '<f4')]", "False", "(2,)", &data),
                "a structured type",
            ),
            (
                file("'<f8'", "False", "(3, 640)", &data),
                "(3, 640); valid: (points, 3)",
            ),
            (file("'<f8'", "False", "(3, 2)", &data), "(3, 2)"),
            (file("'<f8'", "False", "(6,)", &data), "(6,)"),
            (
                file("'<f8'", "False", "(100000000, 3)", &[]),
                "100 000 000 points",
            ),
        ] {
            let text = read(&bytes).unwrap_err();
            assert!(text.contains(part), "{text}");
        }
    }
}

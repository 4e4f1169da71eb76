//! Point Cloud Library's PCD, version 0.7 and before: ascii, binary, and binary compressed by LZF,
//! whose columns then lie one after the other.
//!
//! x, y and z are floats of 4 or 8 bytes, wherever they stand among the fields; others are passed
//! over. The points are taken as they stand: where the sensor was (VIEWPOINT) moves none.

use super::bytes::{Column, Floats, check_size, point_of_words, points};
use super::lzf;
use super::scan::Scan;
use crate::warning::Warning;

/// Bytes before the compressed part: its sizes, packed and unpacked.
const SIZES: usize = 8;

pub(super) fn read(bytes: &[u8]) -> Result<Scan, String> {
    let (header, data) = Header::read(bytes)?;
    let mut scan = Scan::with_slots(header.points)?;
    scan.warnings.extend(header.viewpoint_warning());
    match header.data {
        Data::Ascii => header.read_text(data, &mut scan)?,
        Data::Binary => {
            let step = header.row_size();
            let columns = header.columns(|before, _| (before, step))?;
            check_size(data.len(), header.points * step, step - 1)?;
            scan.extend(points(data, &columns, header.points));
        }
        Data::Compressed => {
            let columns = header.columns(|before, size| (before * header.points, size))?;
            let data = header.unpacked(data)?;
            scan.extend(points(&data, &columns, header.points));
        }
    }
    Ok(scan)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Data {
    Ascii,
    Binary,
    Compressed,
}

/// A field of each point.
#[derive(Clone, Debug)]
struct Field {
    name: String,
    /// Bytes of one number.
    size: usize,
    /// F, I or U.
    kind: String,
    /// Numbers of it.
    count: usize,
}

impl Field {
    fn bytes(&self) -> usize {
        self.size * self.count
    }
}

struct Header {
    fields: Vec<Field>,
    points: usize,
    viewpoint: String,
    data: Data,
    /// Lines of the header.
    lines: usize,
}

/// Words of the header's lines, by their first.
#[derive(Default)]
struct Entries<'a>(Vec<(&'a str, Vec<&'a str>)>);

const WORDS: [&str; 9] = [
    "VERSION",
    "FIELDS",
    "SIZE",
    "TYPE",
    "COUNT",
    "WIDTH",
    "HEIGHT",
    "VIEWPOINT",
    "POINTS",
];

impl<'a> Entries<'a> {
    fn take(&mut self, line: &'a str) -> Result<(), String> {
        let mut words = line.split_whitespace();
        // Files of version 0.5 call fields columns.
        let first = match words.next() {
            None => return Ok(()),
            Some("COLUMNS") => "FIELDS",
            Some(word) => word,
        };
        if !WORDS.contains(&first) {
            return Err(format!(
                "{first:?} is no word of a PCD header; valid: {}, DATA",
                WORDS.join(", ")
            ));
        }
        self.0.push((first, words.collect()));
        Ok(())
    }

    fn find(&self, word: &str) -> Option<&[&'a str]> {
        let entry = self.0.iter().find(|entry| entry.0 == word);
        entry.map(|(_, words)| words.as_slice())
    }

    fn needed(&self, word: &str) -> Result<&[&'a str], String> {
        self.find(word)
            .ok_or_else(|| format!("its header has no line {word}"))
    }

    fn numbers(&self, word: &str) -> Result<Vec<usize>, String> {
        let words = self.needed(word)?.iter();
        let number = |text: &&str| {
            text.parse()
                .map_err(|_| format!("{word} is {text:?}, it must be a whole number"))
        };
        words.map(number).collect()
    }

    fn number(&self, word: &str) -> Result<usize, String> {
        match self.numbers(word)?[..] {
            [number] => Ok(number),
            _ => Err(format!("{word} must be one number")),
        }
    }

    fn fields(&self) -> Result<Vec<Field>, String> {
        let names = self.needed("FIELDS")?;
        let sizes = self.numbers("SIZE")?;
        let kinds = self.needed("TYPE")?;
        let counts = match self.find("COUNT") {
            Some(_) => self.numbers("COUNT")?,
            None => vec![1; names.len()],
        };
        for (word, length) in [
            ("SIZE", sizes.len()),
            ("TYPE", kinds.len()),
            ("COUNT", counts.len()),
        ] {
            if length != names.len() {
                return Err(format!(
                    "{word} has {length} entries for {} fields",
                    names.len()
                ));
            }
        }
        let field = |i: usize| Field {
            name: names[i].to_owned(),
            size: sizes[i],
            kind: kinds[i].to_owned(),
            count: counts[i],
        };
        let fields: Vec<Field> = (0..names.len()).map(field).collect();
        check_fields(&fields)?;
        Ok(fields)
    }

    fn points(&self) -> Result<usize, String> {
        let width = self.number("WIDTH")?;
        let height = self.number("HEIGHT")?;
        let slots = width.saturating_mul(height);
        match self.find("POINTS") {
            Some(_) if self.number("POINTS")? != slots => Err(format!(
                "POINTS is {}, WIDTH × HEIGHT is {slots}",
                self.number("POINTS")?
            )),
            _ => Ok(slots),
        }
    }
}

/// Refuses sizes that no machine number has: so many numbers of a point cannot be.
fn check_fields(fields: &[Field]) -> Result<(), String> {
    let is_odd = |field: &&Field| ![1, 2, 4, 8].contains(&field.size) || field.count > 1 << 16;
    match fields.iter().find(is_odd) {
        None => Ok(()),
        Some(field) => Err(format!(
            "field {:?} is {} numbers of {} bytes; valid sizes: 1, 2, 4, 8, counts up to 65 536",
            field.name, field.count, field.size
        )),
    }
}

fn data_of(words: &[&str]) -> Result<Data, String> {
    match words {
        ["ascii"] => Ok(Data::Ascii),
        ["binary"] => Ok(Data::Binary),
        ["binary_compressed"] => Ok(Data::Compressed),
        _ => Err(format!(
            "DATA is {:?}; valid: ascii, binary, binary_compressed",
            words.join(" ")
        )),
    }
}

impl Header {
    /// The header, and the bytes after it.
    fn read(bytes: &[u8]) -> Result<(Self, &[u8]), String> {
        let mut entries = Entries::default();
        let mut rest = bytes;
        let mut lines = 0;
        loop {
            lines += 1;
            let Some(end) = rest.iter().position(|byte| *byte == b'\n') else {
                return Err(format!(
                    "cut short: its header ends in line {lines}, before a line DATA"
                ));
            };
            let at_line = |reason| format!("line {lines}: {reason}");
            let line = std::str::from_utf8(&rest[..end])
                .map_err(|_| at_line("it is no text".to_owned()))?;
            rest = &rest[end + 1..];
            let content = line.split('#').next().unwrap_or_default();
            let words: Vec<&str> = content.split_whitespace().collect();
            if let ["DATA", kind @ ..] = &words[..] {
                let data = data_of(kind).map_err(at_line)?;
                return Ok((Self::of(&entries, data, lines)?, rest));
            }
            entries.take(content).map_err(at_line)?;
        }
    }

    fn of(entries: &Entries, data: Data, lines: usize) -> Result<Self, String> {
        Ok(Self {
            fields: entries.fields()?,
            points: entries.points()?,
            viewpoint: entries
                .find("VIEWPOINT")
                .unwrap_or_default()
                .join(" "),
            data,
            lines,
        })
    }

    /// Bytes of a point.
    fn row_size(&self) -> usize {
        self.fields.iter().map(Field::bytes).sum()
    }

    /// Numbers of a point before that of a coordinate, and its field.
    fn coordinate(&self, name: &str) -> Result<(usize, &Field), String> {
        let names = || {
            let names = self
                .fields
                .iter()
                .map(|field| field.name.as_str());
            names.collect::<Vec<_>>().join(", ")
        };
        let index = self
            .fields
            .iter()
            .position(|field| field.name == name)
            .ok_or_else(|| format!("it has no field {name:?}; its fields: {}", names()))?;
        let field = &self.fields[index];
        match (field.kind.as_str(), field.size, field.count) {
            ("F", 4 | 8, 1) => Ok((index, field)),
            (kind, size, count) => Err(format!(
                "its field {name:?} is {count} × {kind}{size}; valid: one F4 or F8"
            )),
        }
    }

    /// Where the coordinates are: `place` gives offset and step of a field from the bytes of a
    /// point before it and its own.
    fn columns(
        &self,
        place: impl Fn(usize, usize) -> (usize, usize),
    ) -> Result<[Column; 3], String> {
        let column = |name| {
            let (index, field) = self.coordinate(name)?;
            let before = self.fields[..index]
                .iter()
                .map(Field::bytes)
                .sum();
            let (first, step) = place(before, field.size);
            let floats = Floats {
                size: field.size,
                is_big_endian: false,
            };
            Ok::<_, String>(Column {
                floats,
                first,
                step,
            })
        };
        Ok([column("x")?, column("y")?, column("z")?])
    }

    fn read_text(&self, data: &[u8], scan: &mut Scan) -> Result<(), String> {
        let word_of = |name| {
            let (index, _) = self.coordinate(name)?;
            let before = self.fields[..index].iter();
            Ok::<_, String>(before.map(|field| field.count).sum::<usize>())
        };
        let places: [usize; 3] = [word_of("x")?, word_of("y")?, word_of("z")?];
        let words: usize = self
            .fields
            .iter()
            .map(|field| field.count)
            .sum();
        let text = std::str::from_utf8(data).map_err(|_| "its points are no text")?;
        let mut read = 0;
        for (index, line) in text.lines().enumerate() {
            let at_line = |reason| format!("line {}: {reason}", self.lines + index + 1);
            let found: Vec<&str> = line.split_whitespace().collect();
            match found.len() {
                0 => continue,
                count if count == words && read < self.points => {}
                count if count == words => {
                    return Err(at_line(format!("a point more than its {}", self.points)));
                }
                count => return Err(at_line(format!("{count} numbers; a point has {words}"))),
            }
            let point = point_of_words(places.map(|place| found[place])).map_err(at_line)?;
            scan.extend([point]);
            read += 1;
        }
        match read == self.points {
            true => Ok(()),
            false => Err(format!(
                "cut short: it has {read} of its {} points",
                self.points
            )),
        }
    }

    fn unpacked(&self, data: &[u8]) -> Result<Vec<u8>, String> {
        let needed = self.points * self.row_size();
        let size = |at: usize| {
            let bytes = data.get(at..at + 4)?.try_into().ok()?;
            Some(u32::from_le_bytes(bytes) as usize)
        };
        let (Some(packed), Some(unpacked)) = (size(0), size(4)) else {
            return Err("cut short: it ends before the sizes of its compressed part".into());
        };
        if unpacked != needed {
            return Err(format!(
                "its points need {needed} bytes, its compressed part stands for {unpacked}"
            ));
        }
        let given = data.len() - SIZES;
        let part = data.get(SIZES..SIZES + packed).ok_or_else(|| {
            format!("cut short: its compressed part has {packed} bytes, the file {given} of them")
        })?;
        lzf::unpack(part, unpacked)
    }

    /// That the sensor did not stand where the points are measured from.
    fn viewpoint_warning(&self) -> Option<Warning> {
        let numbers: Vec<f64> = self
            .viewpoint
            .split_whitespace()
            .filter_map(|word| word.parse().ok())
            .collect();
        let stands = matches!(numbers[..], [] | [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        (!stands).then(|| {
            Warning::uncovered(format!(
                "its VIEWPOINT is {}, which moves no point: they are taken as they stand, in the object's frame",
                self.viewpoint
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    /// Two points and one that is none; fields before, between and after the coordinates.
    const ROWS: [(u32, f64, f32, f32, u8); 3] = [
        (7, 400321.652, 2.0, 3.0, 1),
        (8, f64::NAN, f32::NAN, f32::NAN, 2),
        (9, 4.0, 5.0, 6.0, 3),
    ];

    fn header(data: &str) -> String {
        format!(
            "# .PCD v0.7\nVERSION 0.7\nFIELDS label x y _ z\nSIZE 4 8 4 1 4\nTYPE U F F U F\nCOUNT 1 1 1 2 1\n\
             WIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA {data}\n"
        )
    }

    fn binary() -> Vec<u8> {
        let row = |&(label, x, y, z, pad): &(u32, f64, f32, f32, u8)| {
            let mut row = label.to_le_bytes().to_vec();
            row.extend(x.to_le_bytes());
            row.extend(y.to_le_bytes());
            row.extend([pad, pad]);
            row.extend(z.to_le_bytes());
            row
        };
        let mut bytes = header("binary").into_bytes();
        bytes.extend(ROWS.iter().flat_map(row));
        bytes
    }

    /// Columns one after the other, in literal runs.
    fn compressed() -> Vec<u8> {
        let mut columns: Vec<u8> = ROWS
            .iter()
            .flat_map(|row| row.0.to_le_bytes())
            .collect();
        columns.extend(ROWS.iter().flat_map(|row| row.1.to_le_bytes()));
        columns.extend(ROWS.iter().flat_map(|row| row.2.to_le_bytes()));
        columns.extend(ROWS.iter().flat_map(|row| [row.4, row.4]));
        columns.extend(ROWS.iter().flat_map(|row| row.3.to_le_bytes()));
        let runs = columns.chunks(32);
        let packed: Vec<u8> = runs
            .flat_map(|run| [&[run.len() as u8 - 1], run].concat())
            .collect();
        let mut bytes = header("binary_compressed").into_bytes();
        bytes.extend((packed.len() as u32).to_le_bytes());
        bytes.extend((columns.len() as u32).to_le_bytes());
        bytes.extend(packed);
        bytes
    }

    fn ascii() -> Vec<u8> {
        let row = |row: &(u32, f64, f32, f32, u8)| {
            format!(
                "{} {} {} {} {} {}\n",
                row.0, row.1, row.2, row.4, row.4, row.3
            )
        };
        let rows: String = ROWS.iter().map(row).collect();
        (header("ascii") + &rows).into_bytes()
    }

    #[test]
    fn every_form_gives_the_same_points() {
        for bytes in [ascii(), binary(), compressed()] {
            let scan = read(&bytes).unwrap();
            let wanted = [Vec3::new(400321.652, 2.0, 3.0), Vec3::new(4.0, 5.0, 6.0)];
            assert_eq!((scan.points.as_slice(), scan.slots), (&wanted[..], 3));
            assert!(scan.warnings.is_empty());
        }
    }

    fn refusal(bytes: &[u8]) -> String {
        read(bytes).unwrap_err()
    }

    #[test]
    fn a_file_that_is_cut_short_is_refused() {
        let whole = ascii();
        let head = header("ascii").len();
        assert!(refusal(&whole[..head - 8]).contains("its header ends in line 11"));
        let lines: Vec<u8> = whole[..whole.len() - 3].to_vec();
        assert!(refusal(&lines).contains("line 14: 5 numbers; a point has 6"));
        assert!(refusal(&whole[..head]).contains("it has 0 of its 3 points"));
        let whole = binary();
        assert!(
            refusal(&whole[..whole.len() - 1])
                .contains("need 66 bytes after the header, the file has 65")
        );
        let whole = compressed();
        assert!(
            refusal(&whole[..whole.len() - 1])
                .contains("compressed part has 69 bytes, the file 68")
        );
        assert!(
            refusal(&whole[..header("binary_compressed").len() + 5]).contains("before the sizes")
        );
    }

    #[test]
    fn what_the_header_says_wrongly_is_refused_by_name() {
        for (from, to, part) in [
            (
                "x y _ z",
                "x y _ w",
                "no field \"z\"; its fields: label, x, y, _, w",
            ),
            (
                "U F F U F",
                "U I F U F",
                "\"x\" is 1 × I8; valid: one F4 or F8",
            ),
            ("POINTS 3", "POINTS 4", "POINTS is 4, WIDTH × HEIGHT is 3"),
            ("WIDTH 3", "WIDTH three", "WIDTH is \"three\""),
            ("WIDTH 3\n", "", "no line WIDTH"),
            (
                "DATA ascii",
                "DATA zip",
                "line 11: DATA is \"zip\"; valid: ascii",
            ),
            ("VERSION", "VERSOIN", "line 2: \"VERSOIN\" is no word"),
            ("SIZE 4 8", "SIZE 8", "SIZE has 4 entries for 5 fields"),
            (
                "SIZE 4 8",
                "SIZE 3 8",
                "field \"label\" is 1 numbers of 3 bytes",
            ),
            (
                "WIDTH 3\nHEIGHT 1",
                "WIDTH 10000\nHEIGHT 10000",
                "POINTS is 3",
            ),
            (
                "WIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3",
                "WIDTH 10000\nHEIGHT 10000",
                "100 000 000 points",
            ),
        ] {
            let text = String::from_utf8(ascii()).unwrap();
            let changed = text.replacen(from, to, 1);
            assert_ne!(changed, text);
            let refused = refusal(changed.as_bytes());
            assert!(refused.contains(part), "{refused}");
        }
    }

    #[test]
    fn a_sensor_that_stood_elsewhere_is_told() {
        let text = String::from_utf8(ascii()).unwrap();
        let moved = text.replace("VIEWPOINT 0 0 0", "VIEWPOINT 0 0 1.5");
        let scan = read(moved.as_bytes()).unwrap();
        assert!(scan.warnings[0].contains("VIEWPOINT is 0 0 1.5 1 0 0 0, which moves no point"));
    }
}

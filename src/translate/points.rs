//! Points as sensors lay them out in memory: ROS's `PointCloud2`.

use crate::math::Vec3;
use taut_ipc::control::{PointField, PointLayout, Refusal};
use taut_ipc::wire::Code;

/// Most points of a frame.
const MOST_POINTS: u64 = 1 << 22;

/// Where the points of a frame are, checked against the bytes that came.
#[derive(Debug)]
pub(super) struct Points<'a> {
    body: &'a [u8],
    layout: &'a PointLayout,
    /// Where each coordinate begins in a point.
    offsets: [usize; 3],
    number: Number,
}

/// How a coordinate is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Number {
    F32,
    F64,
    BigF32,
    BigF64,
}

impl Number {
    fn of(datatype: u8, is_bigendian: bool) -> Option<Self> {
        match (datatype, is_bigendian) {
            (PointField::FLOAT32, false) => Some(Self::F32),
            (PointField::FLOAT64, false) => Some(Self::F64),
            (PointField::FLOAT32, true) => Some(Self::BigF32),
            (PointField::FLOAT64, true) => Some(Self::BigF64),
            _ => None,
        }
    }

    fn size(self) -> usize {
        match self {
            Self::F32 | Self::BigF32 => 4,
            Self::F64 | Self::BigF64 => 8,
        }
    }
}

impl<'a> Points<'a> {
    /// Points of a body.
    ///
    /// # Errors
    /// A layout that is none, or that the body is too short for.
    pub fn new(layout: &'a PointLayout, body: &'a [u8]) -> Result<Self, Refusal> {
        let (offsets, number) = coordinates(layout)?;
        check_size(layout, body.len())?;
        Ok(Self {
            body,
            layout,
            offsets,
            number,
        })
    }

    /// How many there are, whatever they are worth.
    pub fn len(&self) -> usize {
        self.layout.height as usize * self.layout.width as usize
    }

    /// Has a look at each, in order; one that a sensor has no point for is not finite, or lies in
    /// its very origin. Every byte is read once: who sent them may still write.
    pub fn each(&self, look: impl FnMut(Vec3)) {
        match self.number {
            Number::F32 => self.read(|bytes| f32::from_le_bytes(bytes).into(), look),
            Number::F64 => self.read(f64::from_le_bytes, look),
            Number::BigF32 => self.read(|bytes| f32::from_be_bytes(bytes).into(), look),
            Number::BigF64 => self.read(f64::from_be_bytes, look),
        }
    }

    fn read<const SIZE: usize>(
        &self,
        number: impl Fn([u8; SIZE]) -> f64,
        mut look: impl FnMut(Vec3),
    ) {
        let step = self.layout.point_step as usize;
        let row_bytes = self.layout.width as usize * step;
        let rows = self
            .body
            .chunks(self.layout.row_step as usize)
            .take(self.layout.height as usize);
        for point in rows.flat_map(|row| row[..row_bytes].chunks_exact(step)) {
            let at = |offset: usize| number(array(&point[offset..offset + SIZE]));
            let [x, y, z] = self.offsets.map(at);
            look(Vec3::new(x, y, z));
        }
    }
}

fn array<const SIZE: usize>(bytes: &[u8]) -> [u8; SIZE] {
    bytes
        .try_into()
        .expect("as many as were asked for")
}

/// Where x, y and z are, and as what.
fn coordinates(layout: &PointLayout) -> Result<([usize; 3], Number), Refusal> {
    let fields = ["x", "y", "z"].map(|name| field(layout, name));
    let [x, y, z] = fields;
    let fields = [x?, y?, z?];
    let [first, ..] = fields;
    if let Some(other) = fields
        .iter()
        .find(|field| field.datatype != first.datatype)
    {
        return Err(malformed(format!(
            "field {:?} has datatype {} and field \"x\" {}; the three need one type",
            other.name, other.datatype, first.datatype
        )));
    }
    let number = Number::of(first.datatype, layout.is_bigendian).ok_or_else(|| {
        malformed(format!(
            "fields x, y, z have datatype {}; valid: {} (FLOAT32), {} (FLOAT64)",
            first.datatype,
            PointField::FLOAT32,
            PointField::FLOAT64
        ))
    })?;
    for field in fields {
        let end = u64::from(field.offset) + number.size() as u64;
        if end > layout.point_step.into() {
            return Err(malformed(format!(
                "field {:?} ends at byte {end} of a point of {} bytes (point_step)",
                field.name, layout.point_step
            )));
        }
    }
    Ok((fields.map(|field| field.offset as usize), number))
}

fn field<'a>(layout: &'a PointLayout, name: &str) -> Result<&'a PointField, Refusal> {
    let found = layout
        .fields
        .iter()
        .find(|field| field.name == name);
    found.ok_or_else(|| {
        let names = layout
            .fields
            .iter()
            .map(|field| field.name.as_str());
        malformed(format!(
            "the frame has no field {name:?}; it has: {}; needed: x, y, z",
            names.collect::<Vec<_>>().join(", ")
        ))
    })
}

fn check_size(layout: &PointLayout, found: usize) -> Result<(), Refusal> {
    let PointLayout {
        height,
        width,
        point_step,
        row_step,
        ..
    } = *layout;
    let points = u64::from(height) * u64::from(width);
    if points > MOST_POINTS {
        let text = format!(
            "{height} rows of {width} points are {points}; at most {MOST_POINTS}: send fewer"
        );
        return Err(Refusal::new(Code::ResourceExhausted, text));
    }
    let row_bytes = u64::from(width) * u64::from(point_step);
    if u64::from(row_step) < row_bytes || row_step == 0 && points > 0 {
        return Err(malformed(format!(
            "row_step {row_step} is less than width {width} times point_step {point_step}"
        )));
    }
    let needed = match points {
        0 => 0,
        _ => u64::from(height - 1) * u64::from(row_step) + row_bytes,
    };
    if needed > found as u64 {
        return Err(malformed(format!(
            "{height} rows of {width} points take {needed} bytes, and {found} came"
        )));
    }
    Ok(())
}

fn malformed(text: String) -> Refusal {
    Refusal::new(Code::MalformedRequest, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(layout: &PointLayout, body: &[u8]) -> Vec<[f64; 3]> {
        let mut read = Vec::new();
        Points::new(layout, body)
            .unwrap()
            .each(|point| read.push(point.to_array()));
        read
    }

    #[test]
    fn points_are_read_however_they_lie() {
        let expected = vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        let numbers = [1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0];
        let packed: Vec<u8> = numbers
            .iter()
            .flat_map(|n| n.to_le_bytes())
            .collect();
        let layout = PointLayout::packed(2, PointField::FLOAT32);
        assert_eq!(read(&layout, &packed), expected);

        let wide: Vec<u8> = numbers
            .iter()
            .flat_map(|n| f64::from(*n).to_be_bytes())
            .collect();
        let layout = PointLayout {
            is_bigendian: true,
            ..PointLayout::packed(2, PointField::FLOAT64)
        };
        assert_eq!(read(&layout, &wide), expected);

        // Two rows of one point each, z first, padded to 16 and 20 bytes.
        let mut body = Vec::new();
        for point in expected.iter() {
            for coordinate in [2, 1, 0] {
                body.extend((point[coordinate] as f32).to_be_bytes());
            }
            body.extend([0xff; 8]);
        }
        let field = |name: &str, offset| PointField {
            name: name.to_owned(),
            offset,
            datatype: PointField::FLOAT32,
            count: 1,
        };
        let layout = PointLayout {
            height: 2,
            width: 1,
            point_step: 16,
            row_step: 20,
            is_bigendian: true,
            fields: vec![field("z", 0), field("y", 4), field("x", 8)],
        };
        assert_eq!(read(&layout, &body), expected);
        // The last row need not be padded.
        assert_eq!(read(&layout, &body[..36]), expected);
    }

    #[test]
    fn a_layout_that_is_none_is_refused_by_name() {
        let good = PointLayout::packed(2, PointField::FLOAT32);
        let refused = |change: fn(&mut PointLayout), bytes: usize| {
            let mut layout = good.clone();
            change(&mut layout);
            let body = vec![0; bytes];
            Points::new(&layout, &body).unwrap_err().message
        };
        type Case = (fn(&mut PointLayout), usize, &'static str);
        let cases: [Case; 7] = [
            (|_| (), 23, "take 24 bytes, and 23 came"),
            (|layout| layout.row_step = 23, 24, "row_step 23"),
            (
                |layout| layout.point_step = 11,
                24,
                "field \"z\" ends at byte 12",
            ),
            (
                |layout| layout.fields[1].datatype = 8,
                24,
                "field \"y\" has datatype 8",
            ),
            (
                |layout| {
                    layout
                        .fields
                        .iter_mut()
                        .for_each(|field| field.datatype = 4)
                },
                24,
                "valid: 7 (FLOAT32), 8 (FLOAT64)",
            ),
            (
                |layout| layout.fields[2].name = "w".to_owned(),
                24,
                "no field \"z\"",
            ),
            (|layout| layout.height = u32::MAX, 24, "at most"),
        ];
        for (change, bytes, said) in cases {
            let message = refused(change, bytes);
            assert!(message.contains(said), "{message}");
        }
    }
}

//! The order of space: Morton's, of ten bits for each axis.

use crate::math::Vec3;

/// Bits of a coordinate.
const BITS: u32 = 10;
/// Bits that are sorted by at once.
const DIGIT: u32 = 10;

/// The least and the greatest coordinates.
pub(super) fn low_and_high(points: &[Vec3]) -> [Vec3; 2] {
    points.iter().fold(
        [Vec3::INFINITY, Vec3::NEG_INFINITY],
        |[low, high], point| [low.min(*point), high.max(*point)],
    )
}

/// The numbers of points, near ones together; equal ones stay as they were.
pub(super) fn in_order(points: &[Vec3], [low, high]: [Vec3; 2]) -> Vec<u32> {
    let widest = (high - low)
        .max_element()
        .max(f64::MIN_POSITIVE);
    let scale = f64::from(1 << BITS) / widest;
    let key = |(number, point): (usize, &Vec3)| Key {
        code: code((*point - low) * scale),
        number: number as u32,
    };
    let mut keys: Vec<_> = points.iter().enumerate().map(key).collect();
    let mut sorted = keys.clone();
    for digit in 0..3 * BITS / DIGIT {
        by_digit(&keys, &mut sorted, digit * DIGIT);
        std::mem::swap(&mut keys, &mut sorted);
    }
    keys.iter().map(|key| key.number).collect()
}

#[derive(Clone, Copy)]
struct Key {
    code: u32,
    number: u32,
}

/// Where a point lies along Morton's curve.
fn code(cell: Vec3) -> u32 {
    let most = (1 << BITS) - 1;
    let [x, y, z] = cell
        .to_array()
        .map(|value| spread((value as u32).min(most)));
    x | y << 1 | z << 2
}

/// Ten bits, each followed by two that are not set.
fn spread(bits: u32) -> u32 {
    let bits = (bits | bits << 16) & 0x0300_00ff;
    let bits = (bits | bits << 8) & 0x0300_f00f;
    let bits = (bits | bits << 4) & 0x030c_30c3;
    (bits | bits << 2) & 0x0924_9249
}

/// One round of a radix sort.
fn by_digit(keys: &[Key], sorted: &mut [Key], shift: u32) {
    let digit = |key: &Key| (key.code >> shift) as usize & ((1 << DIGIT) - 1);
    let mut places = [0_usize; 1 << DIGIT];
    keys.iter()
        .for_each(|key| places[digit(key)] += 1);
    let mut first = 0;
    for place in &mut places {
        (*place, first) = (first, first + *place);
    }
    for key in keys {
        let place = &mut places[digit(key)];
        sorted[*place] = *key;
        *place += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::vector;

    #[test]
    fn codes_put_the_bits_of_axes_in_turns() {
        for (cell, expected) in [
            ([1.0, 0.0, 0.0], 1),
            ([0.0, 1.0, 0.0], 2),
            ([0.0, 0.0, 2.5], 32),
            ([3.0, 5.0, 9.0], 0b100_010_001_111),
            ([1024.0; 3], (1 << 30) - 1),
        ] {
            assert_eq!(code(Vec3::from_array(cell)), expected, "{cell:?}");
        }
    }

    #[test]
    fn every_point_is_there_once_and_codes_rise() {
        let mut rng = fastrand::Rng::with_seed(5);
        for count in [1, 2, 7, 1000, 5000] {
            let points: Vec<_> = (0..count)
                .map(|_| vector(&mut rng, 3.0))
                .collect();
            let [low, high] = low_and_high(&points);
            let order = in_order(&points, [low, high]);
            let scale = 1024.0
                / (high - low)
                    .max_element()
                    .max(f64::MIN_POSITIVE);
            let codes = order
                .iter()
                .map(|&n| code((points[n as usize] - low) * scale));
            assert!(codes.is_sorted());
            let mut all = order;
            all.sort_unstable();
            assert!(all.iter().copied().eq(0..count));
        }
    }
}

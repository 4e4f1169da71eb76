//! What sensors saw, as their files have it: points (PCD, npy, xyz) and maps of space (OctoMap).
//!
//! Functions of bytes: no disk, no frame but the file's own. Coordinates are f64 from the file on,
//! so that those of a map grid (10⁶ m) keep their last digits. Own readers: the crates for PCD read
//! no compressed files, which is what real ones are, and there is none for OctoMap.

mod bytes;
mod draft;
mod lzf;
mod npy;
mod octomap;
mod pcd;
mod spacing;
mod thinned;
mod xyz;

use super::cloud::MOST_CELLS;
use crate::math::Vec3;
use crate::warning::{Warning, grouped};
pub use draft::{Draft, Seen};
pub use octomap::{Cell, Octomap, Stream};
pub use spacing::Spacing;
pub use thinned::Thinned;

/// Points as a file has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scan {
    /// Those that are finite (m), in the file's order.
    pub points: Vec<Vec3>,
    /// How many the file has room for: an organised scan has one for each pixel.
    pub slots: usize,
    /// What is odd about the file, a line each.
    pub warnings: Vec<Warning>,
}

/// Endings of the names of files with points.
const FORMATS: &str = "pcd, npy, xyz";

impl Scan {
    /// Reads a file of points. `name` is the file as messages call it; its ending says the format.
    ///
    /// Points with a coordinate that is not finite (a pixel without a depth) are left out and
    /// counted.
    ///
    /// # Errors
    /// Another format, a file that is cut short (with line or offset) or has no `x`, `y` and `z`, one
    /// without a finite point, one of more than [`MOST_CELLS`].
    pub fn read(name: &str, bytes: &[u8]) -> Result<Self, String> {
        let ending = name
            .rsplit_once('.')
            .map_or("", |(_, ending)| ending);
        let scan = match ending.to_ascii_lowercase().as_str() {
            "pcd" => pcd::read(bytes),
            "npy" => npy::read(bytes),
            "xyz" => xyz::read(bytes),
            other => Err(format!(
                "{other:?} is no format of clouds; valid formats: {FORMATS} (maps: bt, ot)"
            )),
        };
        scan.and_then(Self::checked)
            .map_err(|reason| format!("cloud {name}: {reason}"))
            .map(|scan| scan.named(name))
    }

    /// Of slots, which may hold points that are not finite.
    ///
    /// # Errors
    /// No slot, none with a finite point.
    pub fn of(slots: Vec<Vec3>) -> Result<Self, String> {
        let mut scan = Self::with_slots(slots.len())?;
        scan.extend(slots);
        scan.checked()
    }

    /// Room for the points of so many slots.
    fn with_slots(slots: usize) -> Result<Self, String> {
        check_count(slots)?;
        Ok(Self {
            slots,
            ..Self::default()
        })
    }

    /// Takes those points that are finite.
    fn extend(&mut self, points: impl IntoIterator<Item = Vec3>) {
        let finite = points
            .into_iter()
            .filter(|point| point.is_finite());
        self.points.extend(finite);
    }

    fn checked(self) -> Result<Self, String> {
        match (self.slots, self.points.len()) {
            (0, _) => Err("it holds no point; leave the object out where nothing is there".into()),
            (slots, 0) => Err(format!(
                "none of its {} points is finite; is the sensor covered, or too near?",
                grouped(slots)
            )),
            _ => Ok(self),
        }
    }

    fn named(mut self, name: &str) -> Self {
        let left_out = self.left_out();
        if left_out > 0 {
            let text = format!(
                "{} of {} points are not finite: left out",
                grouped(left_out),
                grouped(self.slots)
            );
            // Holes of a depth image are its rule, and nothing can be said of them.
            self.warnings
                .push(Warning::cosmetic("holes of clouds", text));
        }
        for warning in &mut self.warnings {
            *warning = warning.reworded(format!("cloud {name}: {warning}"));
        }
        self
    }

    /// How many points are not finite.
    pub fn left_out(&self) -> usize {
        self.slots - self.points.len()
    }
}

/// Refuses more points than a cloud may have, before any is read.
fn check_count(count: usize) -> Result<(), String> {
    if count <= MOST_CELLS {
        return Ok(());
    }
    Err(format!(
        "it has {} points, a cloud has at most {}; thin it before",
        grouped(count),
        grouped(MOST_CELLS)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_that_are_not_finite_are_left_out_and_counted() {
        let text = b"0 0 1\nnan nan nan\n1 2 inf\n";
        let scan = Scan::read("hall.xyz", text).unwrap();
        assert_eq!(scan.points, [Vec3::Z]);
        assert_eq!(
            scan.warnings,
            ["cloud hall.xyz: 2 of 3 points are not finite: left out"]
        );
    }

    #[test]
    fn what_holds_no_point_is_refused_by_name() {
        let refusal = |name: &str, bytes: &[u8]| Scan::read(name, bytes).unwrap_err();
        assert!(refusal("a.xyz", b"# nothing\n").contains("cloud a.xyz: it holds no point"));
        assert!(refusal("a.xyz", b"nan 0 0\n").contains("none of its 1 points is finite"));
        assert!(refusal("a.ply", b"ply").contains("valid formats: pcd, npy, xyz"));
        let many = Scan::with_slots(100_000_000).unwrap_err();
        assert!(
            many.contains("100 000 000 points, a cloud has at most 16 777 216"),
            "{many}"
        );
    }
}

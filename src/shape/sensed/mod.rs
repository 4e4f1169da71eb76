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
mod scan;
mod spacing;
mod thinned;
mod xyz;

#[cfg(test)]
use crate::math::Vec3;
pub use draft::{Draft, Seen};
pub use octomap::{Cell, Octomap, Stream};
pub use scan::Scan;
pub use spacing::Spacing;
pub use thinned::Thinned;

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
    /// without a finite point, one of more than [`MOST_CELLS`](super::cloud::MOST_CELLS).
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

//! From a file to a cloud, in steps between which others may leave cells out.

use super::{Cell, Octomap, Scan, Spacing, Thinned};
use crate::math::Vec3;
use crate::shape::Cloud;
use crate::shape::cloud::{Making, Provenance, Source, Unknown, Voxel};
use crate::warning::{Warning, grouped};

/// What a sensor saw at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Its middle, in the file's frame (m).
    pub center: Vec3,
    /// Half of its edge (m), 0 for a point.
    pub half: f64,
}

/// A cloud that is being made.
#[derive(Clone, Debug)]
pub struct Draft {
    source: Source,
    seen: Vec<Seen>,
    /// Those that nobody has seen.
    unknown: Vec<Seen>,
    is_whole: bool,
    warnings: Vec<Warning>,
}

impl Draft {
    /// Reads a file as its source says.
    ///
    /// # Errors
    /// A file that cannot be read as what it should be, a radius or an edge that is none.
    pub fn read(source: Source, bytes: &[u8]) -> Result<Self, String> {
        match source.making {
            Making::Points { radius, .. } => Self::of_scan(radius, source, bytes),
            Making::Map { unknown } => {
                let map = Octomap::read(&source.file, bytes)?;
                Self::of_map(source, &map, unknown)
            }
        }
    }

    fn of_scan(radius: f64, source: Source, bytes: &[u8]) -> Result<Self, String> {
        let scan = Scan::read(&source.file, bytes)?;
        let spacing = Spacing::of(&scan.points);
        check_radius(&source.file, radius, spacing)?;
        let warnings = scan
            .warnings
            .into_iter()
            .chain(gaps(&source.file, radius, spacing))
            .collect();
        let seen = |center| Seen { center, half: 0.0 };
        Ok(Self {
            source,
            seen: scan.points.into_iter().map(seen).collect(),
            unknown: Vec::new(),
            is_whole: true,
            warnings,
        })
    }

    /// Takes the cells of a map.
    ///
    /// # Errors
    /// One that has nothing to collide with.
    pub fn of_map(source: Source, map: &Octomap, unknown: Unknown) -> Result<Self, String> {
        let seen = |cells: Vec<Cell>| {
            let seen = |cell| Seen {
                center: map.center(cell),
                half: map.size(cell) / 2.0,
            };
            cells
                .into_iter()
                .map(seen)
                .collect::<Vec<Seen>>()
        };
        let name = &source.file;
        let occupied = seen(map.occupied());
        let (unknown, warning) = match unknown {
            Unknown::Free if occupied.is_empty() => {
                return Err(format!("octomap {name} has no occupied cell; leave it out"));
            }
            Unknown::Free => (Vec::new(), Some(taken_as_free(name, map))),
            Unknown::Obstacle => (seen(map.unknown()), None),
        };
        Ok(Self {
            source,
            seen: occupied,
            unknown,
            is_whole: true,
            warnings: Vec::from_iter(warning),
        })
    }

    /// Leaves out what `is_left_out` says, seen or not, and gives how much of each.
    pub fn leave_out(&mut self, mut is_left_out: impl FnMut(&Seen) -> bool) -> [usize; 2] {
        [&mut self.seen, &mut self.unknown].map(|cells| {
            let before = cells.len();
            cells.retain(|cell| !is_left_out(cell));
            let count = before - cells.len();
            self.is_whole &= count == 0;
            count
        })
    }

    /// The same of no file that would make it again.
    #[must_use]
    pub fn without_source(self) -> Self {
        Self {
            is_whole: false,
            ..self
        }
    }

    /// Says one thing more of the cloud.
    pub fn warn(&mut self, warning: Warning) {
        self.warnings.push(warning);
    }

    /// The cells that somebody has seen.
    pub fn seen(&self) -> &[Seen] {
        &self.seen
    }

    /// The cloud, thinned where its source says so.
    ///
    /// # Errors
    /// Nothing is left of it, or more than a cloud can have.
    pub fn cloud(mut self) -> Result<Cloud, String> {
        let name = self.source.file.clone();
        let made = match self.source.making {
            Making::Points { radius, thin } => self.points(radius, thin),
            Making::Map { .. } => self.voxels(),
        };
        let cloud = made.map_err(|reason| format!("cloud {name}: {reason}"))?;
        let has_unknown = !self.unknown.is_empty();
        Ok(cloud.with_provenance(Provenance {
            source: self.is_whole.then_some(self.source),
            unknown_from: has_unknown.then_some(self.seen.len()),
            warnings: self.warnings,
        }))
    }

    fn points(&mut self, radius: f64, thin: Option<f64>) -> Result<Cloud, String> {
        let points = self.seen.iter().map(|seen| seen.center);
        let Some(edge) = thin else {
            let points = points.map(|point| point.to_array());
            return Cloud::of_points(points, radius).map_err(|error| error.to_string());
        };
        let thinned = Thinned::of(&points.collect::<Vec<Vec3>>(), edge)?;
        let wider = radius + thinned.growth;
        let text = format!(
            "cloud {}: thinned by cells of {} from {} to {} points, whose radius grows from {} to {}: what was left out stays covered",
            self.source.file,
            mm(edge),
            grouped(self.seen.len()),
            grouped(thinned.points.len()),
            mm(radius),
            mm(wider)
        );
        self.warn(Warning::cosmetic("thinned clouds", text));
        let points = thinned
            .points
            .iter()
            .map(|point| point.to_array());
        Cloud::of_points(points, wider).map_err(|error| error.to_string())
    }

    fn voxels(&self) -> Result<Cloud, String> {
        let voxel = |seen: &Seen| Voxel {
            center: seen.center.to_array(),
            size: 2.0 * seen.half,
        };
        let cells = self.seen.iter().chain(&self.unknown);
        let voxels: Vec<Voxel> = cells.map(voxel).collect();
        Cloud::of_voxels(&voxels).map_err(|error| error.to_string())
    }
}

/// Refuses a radius that no ball has, with one that would close the surface.
fn check_radius(name: &str, radius: f64, spacing: Option<Spacing>) -> Result<(), String> {
    if radius.is_finite() && radius > 0.0 {
        return Ok(());
    }
    let advice = spacing.map_or(String::new(), |spacing| {
        format!(
            "; its points lie {} apart (median; 95 of 100 within {}), half of that closes most of the surface between them",
            mm(spacing.median),
            mm(spacing.most)
        )
    });
    let what = match radius.is_nan() {
        true => "it has no radius; give one that is greater than 0 (metres)".to_owned(),
        false => format!("its radius is {radius} m, it must be finite and greater than 0"),
    };
    Err(format!("cloud {name}: {what}{advice}"))
}

/// That a cloud's points do not close what they were seen on.
fn gaps(name: &str, radius: f64, spacing: Option<Spacing>) -> Option<Warning> {
    let Spacing { median, most } = spacing?;
    (radius < most / 2.0).then(|| {
        Warning::uncovered(format!(
            "cloud {name}: its points lie {} apart (median; 95 of 100 within {}) and have a radius of {}: what lies between them is not covered where the radius is below half of that",
            mm(median),
            mm(most),
            mm(radius)
        ))
    })
}

fn taken_as_free(name: &str, map: &Octomap) -> Warning {
    Warning::uncovered(format!(
        "octomap {name}: unknown space is taken as free: {} cells of {} m within its bounds, and all outside them",
        grouped(map.unknown_within() as usize),
        map.resolution()
    ))
}

/// A length for people.
fn mm(length: f64) -> String {
    format!("{:.2} mm", length * 1e3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::sensed::Stream;

    fn points(radius: f64, thin: Option<f64>) -> Source {
        Source {
            file: "scan.xyz".into(),
            making: Making::Points { radius, thin },
        }
    }

    /// A square metre in steps of a centimetre.
    fn plane() -> String {
        let line = |i: usize| {
            format!(
                "{} {} 0.5\n",
                0.01 * (i % 101) as f64,
                0.01 * (i / 101) as f64
            )
        };
        (0..101 * 101).map(line).collect()
    }

    #[test]
    fn a_radius_below_half_of_the_spacing_is_warned_of_by_figures() {
        let warnings = |radius| {
            let draft = Draft::read(points(radius, None), plane().as_bytes()).unwrap();
            let cloud = draft.cloud().unwrap();
            assert_eq!(cloud.len(), 101 * 101);
            cloud.provenance().warnings.clone()
        };
        assert!(warnings(0.005_001).is_empty());
        let warning = &warnings(0.004)[0];
        assert!(warning.is_uncovered());
        assert_eq!(
            warning.text(),
            "cloud scan.xyz: its points lie 10.00 mm apart (median; 95 of 100 within 10.00 mm) and have a radius of \
             4.00 mm: what lies between them is not covered where the radius is below half of that"
        );
    }

    #[test]
    fn a_radius_that_is_none_is_refused_with_the_spacing() {
        for radius in [0.0, -1.0, f64::NAN] {
            let refused = Draft::read(points(radius, None), plane().as_bytes());
            let text = refused.unwrap_err();
            assert!(text.contains("greater than 0"), "{text}");
            assert!(text.contains("; its points lie 10.00 mm apart"), "{text}");
        }
    }

    #[test]
    fn thinned_points_are_thicker_by_what_they_stand_for() {
        let draft = Draft::read(points(0.006, Some(0.05)), plane().as_bytes()).unwrap();
        let cloud = draft.cloud().unwrap();
        assert!(cloud.len() <= 21 * 21, "{}", cloud.len());
        assert!(cloud.radius() > 0.006 + 0.02 && cloud.radius() < 0.006 + 0.0434);
        let text = cloud.provenance().warnings[0].text();
        assert!(
            text.contains("from 10 201 to 4") && text.contains("grows from 6.00 mm to 4"),
            "{text}"
        );
    }

    fn map(unknown: Unknown) -> Draft {
        // The child of least coordinates is occupied, that of greatest is free.
        let map = Octomap::of_stream(Stream::Binary, "OcTree", 0.5, &[0b10, 0b0100_0000]).unwrap();
        let source = Source {
            file: "hall.bt".into(),
            making: Making::Map { unknown },
        };
        Draft::of_map(source, &map, unknown).unwrap()
    }

    #[test]
    fn unknown_cells_are_part_of_the_cloud_where_they_are_obstacles() {
        let free = map(Unknown::Free).cloud().unwrap();
        assert_eq!(free.len(), 1);
        assert!(!free.is_unknown(0));
        assert_eq!(free.words(0), "an occupied cell of 16384 m");
        let warning = &free.provenance().warnings[0];
        assert!(
            warning.contains("unknown space is taken as free: 211 106 232 532 992 cells of 0.5 m"),
            "{warning}"
        );
        let solid = map(Unknown::Obstacle).cloud().unwrap();
        assert_eq!(solid.len(), 7);
        let unknown = (0..7).filter(|place| solid.is_unknown(*place));
        assert_eq!(unknown.count(), 6);
        assert!(solid.provenance().warnings.is_empty());
    }

    #[test]
    fn what_is_left_out_is_counted_and_leaves_no_source() {
        let mut draft = map(Unknown::Obstacle);
        assert_eq!(draft.leave_out(|seen| seen.center.z > 0.0), [0, 3]);
        let cloud = draft.cloud().unwrap();
        assert_eq!((cloud.len(), &cloud.provenance().source), (4, &None));
        let mut all = map(Unknown::Free);
        assert_eq!(all.leave_out(|_| true), [1, 0]);
        assert!(
            all.cloud()
                .unwrap_err()
                .contains("cloud hall.bt: a cloud of 0 points")
        );
    }
}

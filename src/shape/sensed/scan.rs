//! Points as a file has them.

use crate::math::Vec3;
use crate::shape::cloud::MOST_CELLS;
use crate::warning::{Warning, grouped};

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

impl Scan {
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
    pub(super) fn with_slots(slots: usize) -> Result<Self, String> {
        check_count(slots)?;
        Ok(Self {
            slots,
            ..Self::default()
        })
    }

    /// Takes those points that are finite.
    pub(super) fn extend(&mut self, points: impl IntoIterator<Item = Vec3>) {
        let finite = points
            .into_iter()
            .filter(|point| point.is_finite());
        self.points.extend(finite);
    }

    pub(super) fn checked(self) -> Result<Self, String> {
        match (self.slots, self.points.len()) {
            (0, _) => Err("it holds no point; leave the object out where nothing is there".into()),
            (slots, 0) => Err(format!(
                "none of its {} points is finite; is the sensor covered, or too near?",
                grouped(slots)
            )),
            _ => Ok(self),
        }
    }

    pub(super) fn named(mut self, name: &str) -> Self {
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
pub(super) fn check_count(count: usize) -> Result<(), String> {
    if count <= MOST_CELLS {
        return Ok(());
    }
    Err(format!(
        "it has {} points, a cloud has at most {}; thin it before",
        grouped(count),
        grouped(MOST_CELLS)
    ))
}

//! Sections of a trajectory, in an answer that has one.

use super::layout::Section;
use super::section::{SliceOfOne, numbers, place, place_records, put, records};
use super::{HoldRecord, LoweredFloorRecord, TrajectoryRecord, WireError};
use crate::limits::{MAX_POINTS, MAX_RECORDS, MAX_TRAJECTORY_NUMBERS, MAX_VARIABLES};
#[cfg(feature = "iceoryx2")]
use iceoryx2::prelude::ZeroCopySend;

wire_type! {
    /// Where the sections of a trajectory lie.
    TrajectoryPlaces, size 72 {
        0 head: Section, "0 or 1 record";
        8 times: Section, "i64, nanoseconds from the start at which each point is passed";
        16 positions: Section, "f64, variables for each point";
        24 velocities: Section, "f64, variables for each point, per second; absent where a controller goes without";
        32 accelerations: Section, "f64, variables for each point, per second squared; absent where a controller goes without";
        40 limits: Section, "f64, for each variable the least and greatest velocity, the least and greatest acceleration";
        48 used: Section, "f64, for each variable the largest part of a limit of velocity and when (s), the same of acceleration";
        56 floors: Section, "records: what the trajectory is proved at lower floors";
        64 nearest: Section, "0 or 1 record, whose segment counts the ways from point to point: where the trajectory comes nearest to anything";
    }
}

/// When what is to be where; nothing where there are no times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrajectorySections<'a> {
    /// All of it but its points.
    pub head: Option<&'a TrajectoryRecord>,
    /// When each point is passed (ns from the start).
    pub times_ns: &'a [i64],
    /// As many as there are variables for each point.
    pub positions: &'a [f64],
    /// The same, per second; nothing where the controller goes without.
    pub velocities: &'a [f64],
    /// The same, per second squared; nothing where the controller goes without.
    pub accelerations: &'a [f64],
    /// For each variable the least and greatest velocity, the least and greatest acceleration.
    pub limits: &'a [f64],
    /// For each variable the largest part of a limit of velocity and when (s), the same of acceleration.
    pub used: &'a [f64],
    /// What it is proved at lower floors.
    pub lowered_floors: &'a [LoweredFloorRecord],
    /// Where it comes nearest to anything; the segment counts the ways from point to point.
    pub nearest: Option<&'a HoldRecord>,
}

impl<'a> TrajectorySections<'a> {
    /// Where they lie behind `end`, which moves.
    pub(super) fn lay_out(&self, end: &mut usize) -> TrajectoryPlaces {
        TrajectoryPlaces {
            head: place_records(end, self.head.as_slice_of_one()),
            times: place(end, self.times_ns.len(), 8),
            positions: place(end, self.positions.len(), 8),
            velocities: place(end, self.velocities.len(), 8),
            accelerations: place(end, self.accelerations.len(), 8),
            limits: place(end, self.limits.len(), 8),
            used: place(end, self.used.len(), 8),
            floors: place_records(end, self.lowered_floors),
            nearest: place_records(end, self.nearest.as_slice_of_one()),
        }
    }

    pub(super) fn write(&self, places: &TrajectoryPlaces, payload: &mut [u8]) {
        put(payload, places.head, self.head.as_slice_of_one());
        put(payload, places.times, self.times_ns);
        put(payload, places.positions, self.positions);
        put(payload, places.velocities, self.velocities);
        put(payload, places.accelerations, self.accelerations);
        put(payload, places.limits, self.limits);
        put(payload, places.used, self.used);
        put(payload, places.floors, self.lowered_floors);
        put(payload, places.nearest, self.nearest.as_slice_of_one());
    }

    /// Those of a payload; tables have so many columns and as many rows as there are points.
    pub(super) fn parse(
        places: &TrajectoryPlaces,
        columns: u32,
        payload: &'a [u8],
    ) -> Result<Self, WireError> {
        let times_ns: &[i64] = records(payload, "trajectory.times", places.times, MAX_POINTS)?;
        let expected = times_ns.len() * columns as usize;
        let table = |name, section| {
            let found = numbers(payload, name, section, MAX_TRAJECTORY_NUMBERS)?;
            of_points(name, found, expected)
        };
        let optional = |name, section: Section| match section.count {
            0 => Ok(&[][..]),
            _ => table(name, section),
        };
        let of_variables = |name, section| numbers(payload, name, section, 4 * MAX_VARIABLES);
        let floors = records(payload, "trajectory.floors", places.floors, MAX_RECORDS)?;
        Ok(Self {
            head: records(payload, "trajectory.head", places.head, 1)?.first(),
            times_ns,
            positions: table("trajectory.positions", places.positions)?,
            velocities: optional("trajectory.velocities", places.velocities)?,
            accelerations: optional("trajectory.accelerations", places.accelerations)?,
            limits: of_variables("trajectory.limits", places.limits)?,
            used: of_variables("trajectory.used", places.used)?,
            lowered_floors: floors,
            nearest: records(payload, "trajectory.nearest", places.nearest, 1)?.first(),
        })
    }
}

fn of_points<'a>(
    section: &'static str,
    found: &'a [f64],
    expected: usize,
) -> Result<&'a [f64], WireError> {
    match found.len() == expected {
        true => Ok(found),
        false => Err(WireError::SectionCount {
            section,
            found: found.len(),
            expected,
        }),
    }
}

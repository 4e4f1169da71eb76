//! Sections of a trajectory, in an answer that has one.

use super::body::{SliceOfOne, place, place_records, put};
use super::section::{numbers, records};
use super::{HoldRecord, LoweredFloorRecord, ResponseHeader, Section, TrajectoryRecord, WireError};
use crate::limits::{MAX_POINTS, MAX_RECORDS, MAX_TRAJECTORY_NUMBERS, MAX_VARIABLES};

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
    pub(super) fn lay_out(&self, header: &mut ResponseHeader, end: &mut usize) {
        header.trajectory = place_records(end, self.head.as_slice_of_one());
        header.trajectory_times = place(end, self.times_ns.len(), 8);
        header.trajectory_positions = place(end, self.positions.len(), 8);
        header.trajectory_velocities = place(end, self.velocities.len(), 8);
        header.trajectory_accelerations = place(end, self.accelerations.len(), 8);
        header.trajectory_limits = place(end, self.limits.len(), 8);
        header.trajectory_used = place(end, self.used.len(), 8);
        header.trajectory_floors = place_records(end, self.lowered_floors);
        header.trajectory_nearest = place_records(end, self.nearest.as_slice_of_one());
    }

    pub(super) fn write(&self, header: &ResponseHeader, payload: &mut [u8]) {
        put(payload, header.trajectory, self.head.as_slice_of_one());
        put(payload, header.trajectory_times, self.times_ns);
        put(payload, header.trajectory_positions, self.positions);
        put(payload, header.trajectory_velocities, self.velocities);
        put(payload, header.trajectory_accelerations, self.accelerations);
        put(payload, header.trajectory_limits, self.limits);
        put(payload, header.trajectory_used, self.used);
        put(payload, header.trajectory_floors, self.lowered_floors);
        put(
            payload,
            header.trajectory_nearest,
            self.nearest.as_slice_of_one(),
        );
    }

    /// Those of a payload, of which each has as many numbers as there are points.
    pub(super) fn parse(header: &ResponseHeader, payload: &'a [u8]) -> Result<Self, WireError> {
        let times = header.trajectory_times;
        let times_ns: &[i64] = records(payload, "trajectory_times", times, MAX_POINTS)?;
        let expected = times_ns.len() * header.variables as usize;
        let table = |name, section| {
            let found = numbers(payload, name, section, MAX_TRAJECTORY_NUMBERS)?;
            of_points(name, found, expected)
        };
        let optional = |name, section: Section| match section.count {
            0 => Ok(&[][..]),
            _ => table(name, section),
        };
        let of_variables = |name, section| numbers(payload, name, section, 4 * MAX_VARIABLES);
        let floors = header.trajectory_floors;
        let nearest = header.trajectory_nearest;
        Ok(Self {
            head: records(payload, "trajectory", header.trajectory, 1)?.first(),
            times_ns,
            positions: table("trajectory_positions", header.trajectory_positions)?,
            velocities: optional("trajectory_velocities", header.trajectory_velocities)?,
            accelerations: optional("trajectory_accelerations", header.trajectory_accelerations)?,
            limits: of_variables("trajectory_limits", header.trajectory_limits)?,
            used: of_variables("trajectory_used", header.trajectory_used)?,
            lowered_floors: records(payload, "trajectory_floors", floors, MAX_RECORDS)?,
            nearest: records(payload, "trajectory_nearest", nearest, 1)?.first(),
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

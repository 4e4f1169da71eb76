//! Sections of a payload: how they are laid out, written and read.

use super::section::{SliceOfOne, place, place_records, put};
use super::{
    CertificateHead, CertificateSegment, HoldRecord, KeptRecord, LoweredFloorRecord, RefusalRecord,
    RequestHeader, RequirementRecord, ResponseHeader, StageRecord, TrajectorySections,
    TurnedColumn, WarningRecord, WireError,
};
use crate::limits::{MAX_PAYLOAD, MAX_TEXT};

/// Optional sections of a request; an empty slice is an absent section.
#[derive(Clone, Copy, Debug, Default)]
pub struct RequestBody<'a> {
    /// Metric weights, one per velocity coordinate.
    pub weights: &'a [f64],
    /// A byte per waypoint, 1 = keep it bit-equal.
    pub fixed_waypoints: &'a [u8],
    /// A byte per variable, 1 = may move.
    pub group_mask: &'a [u8],
    /// Values of the held joints, in the order of `describe`.
    pub held_values: &'a [f64],
    /// What the path must keep besides clearance; at most 64 KiB.
    pub constraints: &'a str,
    /// What the trajectory is to be; at most 64 KiB.
    pub timing: &'a str,
}

impl RequestBody<'_> {
    /// Enters the sections into `header`, the path of `path_numbers` numbers first, and returns the
    /// bytes needed.
    pub(crate) fn lay_out(&self, header: &mut RequestHeader, path_numbers: usize) -> usize {
        let mut end = 0;
        header.path = place(&mut end, path_numbers, 8);
        header.weights = place(&mut end, self.weights.len(), 8);
        header.held_values = place(&mut end, self.held_values.len(), 8);
        header.fixed_waypoints = place(&mut end, self.fixed_waypoints.len(), 1);
        header.group_mask = place(&mut end, self.group_mask.len(), 1);
        header.constraints = place(&mut end, self.constraints.len(), 1);
        header.timing = place(&mut end, self.timing.len(), 1);
        end
    }

    /// Writes the sections to where `header` says; the path is the caller's.
    pub(crate) fn write(&self, header: &RequestHeader, payload: &mut [u8]) {
        put(payload, header.weights, self.weights);
        put(payload, header.held_values, self.held_values);
        put(payload, header.fixed_waypoints, self.fixed_waypoints);
        put(payload, header.group_mask, self.group_mask);
        put(payload, header.constraints, self.constraints.as_bytes());
        put(payload, header.timing, self.timing.as_bytes());
    }
}

/// Sections of a response; an empty slice is an absent section.
#[derive(Clone, Copy, Debug, Default)]
pub struct ResponseBody<'a> {
    /// `waypoints * variables` numbers, row by row.
    pub path: &'a [f64],
    /// What was proved of each segment.
    pub certificate: &'a [CertificateSegment],
    /// What is proved at a lower floor.
    pub lowered_floors: &'a [LoweredFloorRecord],
    /// The place of the smallest clearance, then those of what holds the path.
    pub holds: &'a [HoldRecord],
    /// What each stage of the method did.
    pub stages: &'a [StageRecord],
    /// What pinches the path.
    pub pinched: &'a [RequirementRecord],
    /// Where and why the input was refused.
    pub refusal: Option<&'a RefusalRecord>,
    /// What the certificate speaks about.
    pub certificate_head: Option<&'a CertificateHead>,
    /// Metres that bodies move at most, per unit of each velocity coordinate.
    pub reach: &'a [f64],
    /// Angle columns whose numbers are not the given ones but whole turns away.
    pub turned_columns: &'a [TurnedColumn],
    /// What the path keeps of each constraint.
    pub keeps: &'a [KeptRecord],
    /// What the certificate claims that the path keeps besides clearance; at most 64 KiB.
    pub constraints: &'a str,
    /// For each segment what is left of the tolerance of each constraint.
    pub constraint_claims: &'a [f64],
    /// When what is to be where; nothing where there are no times.
    pub trajectory: TrajectorySections<'a>,
    /// What a person should know beside the verdict.
    pub warnings: &'a [WarningRecord],
    /// The text that spans point into; cut at 64 KiB.
    pub names: &'a str,
    /// One line for people; cut at 64 KiB.
    pub message: &'a str,
}

impl ResponseBody<'_> {
    /// Enters the sections into `header` and returns the bytes needed.
    ///
    /// # Errors
    /// [`WireError::PayloadSize`] if they do not fit a payload.
    pub fn lay_out(&self, header: &mut ResponseHeader) -> Result<usize, WireError> {
        let mut end = 0;
        header.path = place(&mut end, self.path.len(), 8);
        header.certificate = place_records(&mut end, self.certificate);
        header.lowered_floors = place_records(&mut end, self.lowered_floors);
        header.holds = place_records(&mut end, self.holds);
        header.stages = place_records(&mut end, self.stages);
        header.pinched = place_records(&mut end, self.pinched);
        header.refusal = place_records(&mut end, self.refusal.as_slice_of_one());
        header.certificate_head = place_records(&mut end, self.certificate_head.as_slice_of_one());
        header.reach = place(&mut end, self.reach.len(), 8);
        header.turned_columns = place_records(&mut end, self.turned_columns);
        header.keeps = place_records(&mut end, self.keeps);
        header.constraints = place(&mut end, self.constraints.len(), 1);
        header.constraint_claims = place(&mut end, self.constraint_claims.len(), 8);
        header.trajectory = self.trajectory.lay_out(&mut end);
        header.warnings = place_records(&mut end, self.warnings);
        header.names = place(&mut end, cut(self.names).len(), 1);
        header.message = place(&mut end, cut(self.message).len(), 1);
        check_size(end)?;
        Ok(end)
    }

    /// Writes the sections to where `header` says, after [`Self::lay_out`].
    pub fn write(&self, header: &ResponseHeader, payload: &mut [u8]) {
        put(payload, header.path, self.path);
        put(payload, header.certificate, self.certificate);
        put(payload, header.lowered_floors, self.lowered_floors);
        put(payload, header.holds, self.holds);
        put(payload, header.stages, self.stages);
        put(payload, header.pinched, self.pinched);
        put(payload, header.refusal, self.refusal.as_slice_of_one());
        put(
            payload,
            header.certificate_head,
            self.certificate_head.as_slice_of_one(),
        );
        put(payload, header.reach, self.reach);
        put(payload, header.turned_columns, self.turned_columns);
        put(payload, header.keeps, self.keeps);
        put(payload, header.constraints, self.constraints.as_bytes());
        put(payload, header.constraint_claims, self.constraint_claims);
        self.trajectory
            .write(&header.trajectory, payload);
        put(payload, header.warnings, self.warnings);
        put(payload, header.names, cut(self.names).as_bytes());
        put(payload, header.message, cut(self.message).as_bytes());
    }
}

/// Checks that a payload of so many bytes fits.
pub(crate) fn check_size(found: usize) -> Result<(), WireError> {
    let limit = MAX_PAYLOAD;
    match found <= limit {
        true => Ok(()),
        false => Err(WireError::PayloadSize { found, limit }),
    }
}

/// The text, cut at a character's end to what a section holds.
fn cut(text: &str) -> &str {
    &text[..text.floor_char_boundary(MAX_TEXT)]
}

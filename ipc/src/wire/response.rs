//! Header of a response and its checked view.

use super::layout::Section;
use super::request::{check_version, path_numbers};
use super::{
    CertificateHead, CertificateSegment, Code, HoldRecord, KeptRecord, LoweredFloorRecord,
    RefusalRecord, RequirementRecord, ResponseFlags, Stage, StageRecord, Status, Termination,
    Times, TrajectoryPlaces, TrajectorySections, TurnedColumn, WarningRecord, WireError,
};
use crate::limits::{
    MAX_CLAIMS, MAX_RECORDS, MAX_STAGES, MAX_VARIABLES, MAX_WARNINGS, MAX_WAYPOINTS,
};
use crate::wire::section::{numbers, records, text};
#[cfg(feature = "iceoryx2")]
use iceoryx2::prelude::ZeroCopySend;

wire_type! {
    /// Header of a response on `taut/v1/optimize`.
    ResponseHeader, size 400 {
        0 wire_version: u32, "1";
        4 header_len: u32, "size of this header, 400";
        8 request_id: u64, "of the request answered";
        16 seq: u32, "counts the responses of this request from 0; a gap means dropped ones";
        20 status: u32, "see statuses";
        24 code: i32, "see codes";
        28 retry_after_ms: u32, "for retryable codes, when to try again, in milliseconds";
        32 boot_id: u64, "of the daemon";
        40 robot_hash: u64, "content of the robot it was computed with";
        48 scene_id: u64, "id of the scene's label";
        56 scene_hash: u64, "content of the scene it was proved against";
        64 scene_version: u64, "version of the scene it was proved against";
        72 termination: u32, "see terminations";
        76 refusal_reason: u32, "see refusal reasons";
        80 flags: u32, "see response flags";
        84 stage: u32, "see stages";
        88 waypoints: u32, "rows of the path, 0 = no path";
        92 variables: u32, "columns of the path";
        96 length_before: f64, "length of the input, in the request's metric";
        104 length_after: f64, "length of this path, same metric";
        112 lower_bound: f64, "no path is shorter than this, same metric";
        120 clearance_m: f64, "smallest clearance claimed, in metres";
        128 floor_m: f64, "lowest floor of any clearance, in metres";
        136 searched_m: f64, "how far what holds the path was looked for, in metres; 0 = not at all";
        144 iterations: u64, "iterations of the method";
        152 work: u64, "counted work";
        160 queue_ns: u64, "time the request waited";
        168 compute_ns: u64, "time it was worked on";
        176 path: Section, "waypoints x variables f64, row by row";
        184 certificate: Section, "records, one per segment";
        192 lowered_floors: Section, "records";
        200 holds: Section, "records: where a clearance is first, that is where the smallest is; the others are what holds the path";
        208 stages: Section, "records, in the order in which the stages first came";
        216 pinched: Section, "records";
        224 refusal: Section, "0 or 1 record";
        232 certificate_head: Section, "0 or 1 record";
        240 names: Section, "UTF-8 bytes that text spans point into";
        248 message: Section, "UTF-8 bytes, one line for people";
        256 reach: Section, "f64, metres that bodies move at most per unit of each velocity coordinate; with the flag corridor";
        264 pairs: u64, "pairs of bodies that were checked; 0 where the path was not looked at";
        272 warnings: Section, "records: first what the verdict does not cover";
        280 turned_columns: Section, "records, of the final response";
        288 keeps: Section, "records, one per constraint";
        296 constraints: Section, "UTF-8 bytes: what the certificate claims that the path keeps besides clearance, as JSON";
        304 constraint_claims: Section, "f64, for each segment what is left of the tolerance of each constraint, as it is asked";
        312 times: u32, "whether there is a trajectory, see times";
        316 reserved: u32, "0";
        320 trajectory: TrajectoryPlaces, "where the sections of the trajectory lie";
        392 world_age_ns: u64, "age, when this is sent, of the oldest frame among those that the scene is seen by; 0 = no sensor sees it";
    }
}

/// A response whose header and sections are checked, in place.
#[derive(Clone, Debug)]
pub struct ResponseView<'a> {
    /// The header, a copy.
    pub header: ResponseHeader,
    /// Whether more follow.
    pub status: Status,
    /// How it went.
    pub code: Code,
    /// How the work ended.
    pub termination: Termination,
    /// Which stage found the path.
    pub stage: Stage,
    /// `waypoints * variables` numbers, row by row; empty if there is no path.
    pub path: &'a [f64],
    /// What was proved of each segment.
    pub certificate: &'a [CertificateSegment],
    /// What is proved at a lower floor.
    pub lowered_floors: &'a [LoweredFloorRecord],
    /// Where the first is a clearance, that is the smallest one; then the places of what holds the
    /// path, in order along it, the first one again if it holds the path too. There is no clearance
    /// where no bodies are nearer than `searched_m`.
    pub holds: &'a [HoldRecord],
    /// What each stage of the method did.
    pub stages: &'a [StageRecord],
    /// What pinches the path: no step kept all its half-spaces.
    pub pinched: &'a [RequirementRecord],
    /// Where and why the input was refused.
    pub refusal: Option<&'a RefusalRecord>,
    /// What the certificate speaks about.
    pub certificate_head: Option<&'a CertificateHead>,
    /// Metres that bodies move at most against each other, per unit of each velocity coordinate;
    /// empty unless the request asked for the corridor.
    pub reach: &'a [f64],
    /// Angle columns whose numbers are not the given ones but whole turns away.
    pub turned_columns: &'a [TurnedColumn],
    /// What the path keeps of each constraint.
    pub keeps: &'a [KeptRecord],
    /// What the certificate claims that the path keeps besides clearance; empty for nothing.
    pub constraints: &'a str,
    /// For each segment what is left of the tolerance of each constraint.
    pub constraint_claims: &'a [f64],
    /// Whether there is a trajectory.
    pub times: Times,
    /// When what is to be where.
    pub trajectory: TrajectorySections<'a>,
    /// What a person should know beside the verdict, first what it does not cover.
    pub warnings: &'a [WarningRecord],
    /// The text that spans point into.
    pub names: &'a str,
    /// One line for people.
    pub message: &'a str,
}

impl<'a> ResponseView<'a> {
    /// Checks `header` and cuts `payload` into its sections.
    ///
    /// # Errors
    /// A [`WireError`] naming the field. Never panics, whatever the bytes.
    pub fn parse(header: ResponseHeader, payload: &'a [u8]) -> Result<Self, WireError> {
        check_version(
            header.wire_version,
            header.header_len,
            size_of::<ResponseHeader>(),
        )?;
        ResponseFlags::check(header.flags)?;
        Ok(Self {
            header,
            status: Status::try_from(header.status)?,
            code: Code::try_from(header.code)?,
            termination: Termination::try_from(header.termination)?,
            stage: Stage::try_from(header.stage)?,
            path: path(&header, payload)?,
            certificate: records(payload, "certificate", header.certificate, MAX_WAYPOINTS)?,
            lowered_floors: records(
                payload,
                "lowered_floors",
                header.lowered_floors,
                MAX_RECORDS,
            )?,
            holds: records(payload, "holds", header.holds, MAX_RECORDS)?,
            stages: records(payload, "stages", header.stages, MAX_STAGES)?,
            pinched: records(payload, "pinched", header.pinched, MAX_RECORDS)?,
            refusal: records(payload, "refusal", header.refusal, 1)?.first(),
            certificate_head: records(payload, "certificate_head", header.certificate_head, 1)?
                .first(),
            reach: numbers(payload, "reach", header.reach, 2 * MAX_VARIABLES)?,
            turned_columns: records(
                payload,
                "turned_columns",
                header.turned_columns,
                MAX_VARIABLES,
            )?,
            keeps: records(payload, "keeps", header.keeps, MAX_RECORDS)?,
            constraints: text(payload, "constraints", header.constraints)?,
            constraint_claims: numbers(
                payload,
                "constraint_claims",
                header.constraint_claims,
                MAX_CLAIMS,
            )?,
            times: Times::try_from(header.times)?,
            trajectory: TrajectorySections::parse(&header.trajectory, header.variables, payload)?,
            warnings: records(payload, "warnings", header.warnings, MAX_WARNINGS)?,
            names: text(payload, "names", header.names)?,
            message: text(payload, "message", header.message)?,
        })
    }

    /// Whether the path is proved at its floors.
    pub fn is_proved(&self) -> bool {
        self.header.flags & ResponseFlags::PROVED != 0
    }

    /// Whether the scene changed since the request was taken.
    pub fn is_superseded(&self) -> bool {
        self.header.flags & ResponseFlags::SUPERSEDED != 0
    }

    /// One waypoint, or `None` past the end.
    pub fn waypoint(&self, index: usize) -> Option<&'a [f64]> {
        self.path
            .chunks_exact((self.header.variables as usize).max(1))
            .nth(index)
    }
}

fn path<'a>(header: &ResponseHeader, payload: &'a [u8]) -> Result<&'a [f64], WireError> {
    let expected = match header.waypoints {
        0 => 0,
        rows => path_numbers(rows, header.variables)?,
    };
    let path = numbers(payload, "path", header.path, expected)?;
    if path.len() != expected {
        return Err(WireError::SectionCount {
            section: "path",
            found: path.len(),
            expected,
        });
    }
    Ok(path)
}

//! Headers that go to the daemon, and the checked view of a request.

use super::layout::Section;
use super::{Mode, RequestFlags, WireError};
use crate::limits::{MAX_PATH_NUMBERS, MAX_PAYLOAD, MAX_VARIABLES, MAX_WAYPOINTS, WIRE_VERSION};
use crate::wire::section::{numbers, section_bytes, text};
#[cfg(feature = "iceoryx2")]
use iceoryx2::prelude::ZeroCopySend;

wire_type! {
    /// Header of a request on `taut/v1/optimize`; the waypoints lie in the payload.
    RequestHeader, size 200 {
        0 wire_version: u32, "1";
        4 header_len: u32, "size of this header, 200";
        8 request_id: u64, "chosen by the client, unique among its requests; resending the same id is safe";
        16 listener_id: [u64; 2], "the client's listener to wake, low half first";
        32 robot_id: u64, "id of the robot's label";
        40 scene_id: u64, "id of the scene's label";
        48 robot_hash: u64, "content the client expects, 0 = what the label names now";
        56 scene_hash: u64, "content the client expects, 0 = what the label names now";
        64 scene_version: u64, "version the client expects, 0 = newest";
        72 layout_hash: u64, "hash of the variable layout, from describe";
        80 mode: u32, "see modes";
        84 flags: u32, "see request flags";
        88 priority: u32, "higher is served first";
        92 group: u32, "index in describe, 0xFFFFFFFF = none; a mask overrides it";
        96 seed: u64, "of the request's random numbers";
        104 deadline_ns: u64, "absolute CLOCK_MONOTONIC, 0 = none; across machines the remaining time";
        112 work_budget: u64, "counted work, 0 = default";
        120 clearance_m: f64, "clearance to prove in metres, 0 = the daemon's default (1 mm)";
        128 waypoints: u32, "rows of the path";
        132 variables: u32, "columns of the path";
        136 path: Section, "waypoints x variables f64, row by row";
        144 weights: Section, "f64, one per velocity coordinate";
        152 fixed_waypoints: Section, "a byte per waypoint, 1 = keep it bit-equal";
        160 group_mask: Section, "a byte per variable, 1 = may move";
        168 held_values: Section, "f64, one per held joint variable, order from describe";
        176 constraints: Section, "UTF-8 text: MoveIt's Constraints in JSON, a list of such, or few words";
        184 timing: Section, "UTF-8 text: MoveIt's joint_limits.yaml with our words beside it, or few words; absent: no times";
        192 max_age_ns: u64, "oldest that what sensors see of the scene may be when the request is let in, 0 = any";
    }
}

wire_type! {
    /// Header of a control request; its payload is a bincode message, behind the body where the
    /// message has one.
    ControlHeader, size 48 {
        0 wire_version: u32, "1";
        4 header_len: u32, "size of this header, 48";
        8 request_id: u64, "chosen by the client";
        16 listener_id: [u64; 2], "the client's listener to wake, low half first";
        32 message: Section, "the bincode message";
        40 body: Section, "bytes that the message speaks of, such as a sensor's frame";
    }
}

wire_type! {
    /// Header of a control reply; its payload is a bincode message.
    ControlReplyHeader, size 24 {
        0 wire_version: u32, "1";
        4 header_len: u32, "size of this header, 24";
        8 request_id: u64, "of the request answered";
        16 boot_id: u64, "of the daemon";
    }
}

/// A request whose header and section bounds are checked.
///
/// The numbers of the path are *not* checked here: they still lie in memory that the client can
/// write. Copy them first, then check the copy.
#[derive(Clone, Debug)]
pub struct RequestView<'a> {
    /// The header, a copy.
    pub header: RequestHeader,
    /// All sections, as they lie.
    pub payload: &'a [u8],
    /// What to do.
    pub mode: Mode,
    /// `waypoints * variables` numbers, row by row.
    pub path: &'a [f64],
    /// Metric weights, or empty.
    pub weights: &'a [f64],
    /// A byte per waypoint, or empty.
    pub fixed_waypoints: &'a [u8],
    /// A byte per variable, or empty.
    pub group_mask: &'a [u8],
    /// Values of the held joints, or empty.
    pub held_values: &'a [f64],
    /// What the path must keep besides clearance, or empty.
    pub constraints: &'a str,
    /// What the trajectory is to be, or empty where none is asked for.
    pub timing: &'a str,
}

impl<'a> RequestView<'a> {
    /// Checks `header` and cuts `payload` into its sections.
    ///
    /// # Errors
    /// A [`WireError`] naming the field; [`WireError::code`] is the answer's code. Never panics,
    /// whatever the bytes.
    pub fn parse(header: RequestHeader, payload: &'a [u8]) -> Result<Self, WireError> {
        check_version(
            header.wire_version,
            header.header_len,
            size_of::<RequestHeader>(),
        )?;
        if payload.len() > MAX_PAYLOAD {
            return Err(WireError::PayloadSize {
                found: payload.len(),
                limit: MAX_PAYLOAD,
            });
        }
        let mode = Mode::try_from(header.mode)?;
        RequestFlags::check(header.flags)?;
        check_option("clearance_m", header.clearance_m)?;
        let length = path_numbers(header.waypoints, header.variables)?;
        let rows = header.waypoints as usize;
        let columns = header.variables as usize;
        Ok(Self {
            header,
            payload,
            mode,
            path: exactly(
                "path",
                numbers(payload, "path", header.path, length)?,
                length,
            )?,
            weights: numbers(payload, "weights", header.weights, 2 * MAX_VARIABLES)?,
            fixed_waypoints: optional(payload, "fixed_waypoints", header.fixed_waypoints, rows)?,
            group_mask: optional(payload, "group_mask", header.group_mask, columns)?,
            held_values: numbers(payload, "held_values", header.held_values, MAX_VARIABLES)?,
            constraints: text(payload, "constraints", header.constraints)?,
            timing: text(payload, "timing", header.timing)?,
        })
    }
}

/// Checks version and length of a header.
pub(crate) fn check_version(version: u32, found: u32, expected: usize) -> Result<(), WireError> {
    if version != WIRE_VERSION {
        return Err(WireError::Version(version));
    }
    let expected = expected as u32;
    if found != expected {
        return Err(WireError::HeaderLength { found, expected });
    }
    Ok(())
}

/// How many numbers a path has.
///
/// # Errors
/// [`WireError::PathSize`] if it is empty or over the limits.
pub(crate) fn path_numbers(waypoints: u32, variables: u32) -> Result<usize, WireError> {
    let rows = waypoints as usize;
    let columns = variables as usize;
    let fits = (1..=MAX_WAYPOINTS).contains(&rows)
        && (1..=MAX_VARIABLES).contains(&columns)
        && rows * columns <= MAX_PATH_NUMBERS;
    if !fits {
        return Err(WireError::PathSize {
            waypoints,
            variables,
        });
    }
    Ok(rows * columns)
}

fn check_option(field: &'static str, value: f64) -> Result<(), WireError> {
    if !value.is_finite() || value < 0.0 {
        return Err(WireError::NotFinite { field, value });
    }
    Ok(())
}

fn exactly<'a, T>(
    section: &'static str,
    entries: &'a [T],
    expected: usize,
) -> Result<&'a [T], WireError> {
    if entries.len() != expected {
        return Err(WireError::SectionCount {
            section,
            found: entries.len(),
            expected,
        });
    }
    Ok(entries)
}

fn optional<'a>(
    payload: &'a [u8],
    name: &'static str,
    section: Section,
    expected: usize,
) -> Result<&'a [u8], WireError> {
    let mask = section_bytes(payload, name, section, 1, expected)?;
    if mask.is_empty() {
        Ok(mask)
    } else {
        exactly(name, mask, expected)
    }
}
macro_rules! flag_getters {
    (
        scalars { $($scalars:tt)* }
        flags { $(
            $(#[doc = $doc:literal])+
            $field:ident = $default:literal, $bit:literal $name:ident { $($row:tt)* };
        )* }
        sections { $($sections:tt)* }
    ) => {
        impl RequestHeader {
            $(
                $(#[doc = $doc])+
                pub fn $field(&self) -> bool {
                    (self.flags & RequestFlags::$name != 0) != $default
                }
            )*
        }
    };
}

option_table!(flag_getters);

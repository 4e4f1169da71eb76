//! Fixed records of the response sections.

use super::WireError;
use bytemuck::{Pod, Zeroable};
#[cfg(feature = "iceoryx2")]
use iceoryx2::prelude::ZeroCopySend;

/// A piece of the `names` section.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "iceoryx2", derive(ZeroCopySend))]
pub struct TextSpan {
    /// First byte in the `names` section.
    pub offset: u32,
    /// Length in bytes.
    pub len: u32,
}

impl TextSpan {
    /// The text it points at.
    ///
    /// # Errors
    /// [`WireError::Text`] if it does not lie in `names` or cuts a character.
    pub fn of(self, names: &str) -> Result<&str, WireError> {
        let start = self.offset as usize;
        start
            .checked_add(self.len as usize)
            .and_then(|end| names.get(start..end))
            .ok_or(WireError::Text("names"))
    }

    /// Appends `text` to `names` and returns where it lies.
    pub fn push(names: &mut String, text: &str) -> Self {
        let span = Self {
            offset: names.len() as u32,
            len: text.len() as u32,
        };
        names.push_str(text);
        span
    }
}

wire_type! {
    /// What the whole certificate speaks about (section `certificate_head`, 0 or 1 entries).
    CertificateHead, size 56 {
        0 path_hash: [u64; 4], "SHA-256 of the path, its bytes in order as four little-endian numbers";
        32 checker_version: u32, "version of the proof's rules";
        36 segments: u32, "segments proved";
        40 clearance_m: f64, "clearance promised, in metres";
        48 intervals: u64, "intervals of all segments together";
    }
}

wire_type! {
    /// What was proved about one segment (section `certificate`).
    CertificateSegment, size 16 {
        0 clearance_m: f64, "smallest clearance claimed on this segment, in metres";
        8 intervals: u32, "intervals the proof needed";
        12 reserved: u32, "0";
    }
}

wire_type! {
    /// What a path must keep (section `pinched`, and first in other records): a kind of thing, and
    /// what it is about.
    RequirementRecord, size 24 {
        0 kind: u32, "see requirement kinds, which say how its amounts are meant";
        4 unit: u32, "see units: what its amounts and its floor are counted in";
        8 names: [TextSpan; 2], "what it is about; an empty span is no name";
    }
}

impl RequirementRecord {
    /// What it is about.
    ///
    /// # Errors
    /// [`WireError::Text`] as of [`TextSpan::of`].
    pub fn names(&self, names: &str) -> Result<Vec<String>, WireError> {
        let spans = self.names.iter();
        spans
            .filter(|span| span.len > 0)
            .map(|span| span.of(names).map(str::to_owned))
            .collect()
    }
}

wire_type! {
    /// A requirement whose floor is lower than asked for (section `lowered_floors`).
    LoweredFloorRecord, size 32 {
        0 requirement: RequirementRecord, "whose floor it is";
        24 floor: f64, "the floor it is proved at, in its unit";
    }
}

wire_type! {
    /// A place where least of a requirement is kept on a stretch of the path (section `holds`).
    HoldRecord, size 120 {
        0 requirement: RequirementRecord, "what is kept";
        24 segment: u32, "segment, counted from 0";
        28 reserved: u32, "0";
        32 t: f64, "place on the segment, 0 to 1";
        40 amount: f64, "how much is kept there, in its unit";
        48 points: [[f64; 3]; 2], "where that is seen, world frame, in metres: of a clearance the closest points";
        96 normal: [f64; 3], "unit vector along which the first point moves for more to be kept, world frame: of a clearance from the second body to the first";
    }
}

wire_type! {
    /// What the path keeps of one constraint, of its tolerance as it is asked (section `keeps`).
    KeptRecord, size 136 {
        0 tightest: HoldRecord, "where least was found to be left: a look, no proof";
        120 left: f64, "what is proved to be left everywhere along the path, in its unit; below 0 where the tolerance is raised and that is needed";
        128 asked: f64, "the tolerance, where one number says it: what is read of the path is at most asked - left; else 0";
    }
}

wire_type! {
    /// An angle column whose numbers were written anew: a step of more than half a turn means the
    /// short way round (section `turned_columns`).
    TurnedColumn, size 8 {
        0 column: u32, "column of the path";
        4 turns: i32, "whole turns from the goal's given number to this path's; 0 = only numbers before it moved";
    }
}

wire_type! {
    /// What one stage of the method did (section `stages`).
    StageRecord, size 32 {
        0 stage: u32, "see stages";
        4 reserved: u32, "0";
        8 gain: f64, "by how much it shortened the path, in the request's metric";
        16 work: u64, "counted work";
        24 iterations: u64, "its trials";
    }
}

wire_type! {
    /// A trajectory but for its points (section `trajectory.head`, 0 or 1 entries).
    TrajectoryRecord, size 64 {
        0 stage: u32, "see stages of timing";
        4 controller: u32, "see controllers: what goes from point to point";
        8 rate_hz: f64, "points per second of a controller that goes straight, else 0";
        16 bound_s: f64, "no trajectory between the same ends within the same limits takes less, in seconds";
        24 stops_s: f64, "what the first one that was proved takes, which stops where it must, in seconds";
        32 clearance_m: f64, "smallest clearance claimed at any instant, in metres";
        40 work: u64, "counted work";
        48 intervals: u64, "intervals that its proof needed";
        56 decides: u32, "variable whose motor needs the time of the bound";
        60 reserved: u32, "0";
    }
}

wire_type! {
    /// What a person should know beside the verdict (section `warnings`).
    WarningRecord, size 16 {
        0 kind: u32, "see warning kinds";
        4 reserved: u32, "0";
        8 text: TextSpan, "one line";
    }
}

wire_type! {
    /// Where and why the input was refused (section `refusal`, 0 or 1 entries).
    RefusalRecord, size 136 {
        0 requirement: RequirementRecord, "what is not kept";
        24 segment: u32, "segment, counted from 0";
        28 proved_segments: u32, "segments before it that are proved";
        32 t: f64, "place on the segment, 0 to 1";
        40 proved_t: f64, "the segment after the proved ones is proved up to here";
        48 amount: f64, "how much is kept there, in its unit";
        56 allowed: f64, "the floor it was last tried at, in its unit";
        64 points: [[f64; 3]; 2], "where that is seen, world frame, in metres: of a clearance the closest or contact points";
        112 normal: [f64; 3], "unit vector along which the first point moves for more to be kept, world frame: of a clearance from the second body to the first";
    }
}

const _: () = assert!(
    size_of::<HoldRecord>()
        + size_of::<KeptRecord>()
        + size_of::<LoweredFloorRecord>()
        + size_of::<RequirementRecord>()
        == 312
);
const _: () = assert!(size_of::<CertificateSegment>() == 16);

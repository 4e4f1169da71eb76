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
    /// A body pair whose clearance floor is lower than asked for (section `lowered_pairs`).
    LoweredPair, size 24 {
        0 body_a: TextSpan, "name of the first body";
        8 body_b: TextSpan, "name of the second body";
        16 floor_m: f64, "the floor this pair is proved at, in metres";
    }
}

wire_type! {
    /// A place where two bodies are closest on a stretch of the path (section `active_contacts`).
    ActiveContact, size 112 {
        0 body_a: TextSpan, "name of the first body";
        8 body_b: TextSpan, "name of the second body";
        16 segment: u32, "segment, counted from 0";
        20 reserved: u32, "0";
        24 t: f64, "place on the segment, 0 to 1";
        32 distance_m: f64, "distance of the bodies there, in metres";
        40 point_a: [f64; 3], "closest point of the first body, world frame, in metres";
        64 point_b: [f64; 3], "closest point of the second body, world frame, in metres";
        88 normal: [f64; 3], "unit vector from the second body to the first, world frame";
    }
}

wire_type! {
    /// A body pair between which the path is pinched (section `pinched_pairs`).
    PinchedPair, size 16 {
        0 body_a: TextSpan, "name of the first body";
        8 body_b: TextSpan, "name of the second body";
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
    /// What a person should know beside the verdict (section `warnings`).
    WarningRecord, size 16 {
        0 kind: u32, "see warning kinds";
        4 reserved: u32, "0";
        8 text: TextSpan, "one line";
    }
}

wire_type! {
    /// Where and why the input was refused (section `refusal`, 0 or 1 entries).
    RefusalRecord, size 128 {
        0 body_a: TextSpan, "name of the first body";
        8 body_b: TextSpan, "name of the second body";
        16 segment: u32, "segment, counted from 0";
        20 proved_segments: u32, "segments before it that are proved";
        24 t: f64, "place on the segment, 0 to 1";
        32 proved_t: f64, "the segment after the proved ones is proved up to here";
        40 depth_m: f64, "penetration depth, in metres, from below unless both bodies are convex; negative = still this far apart";
        48 floor_m: f64, "the floor the pair was last tried at, in metres";
        56 point_a: [f64; 3], "contact point on the first body, world frame, in metres";
        80 point_b: [f64; 3], "contact point on the second body, world frame, in metres";
        104 normal: [f64; 3], "unit vector from the second body to the first, world frame";
    }
}

const _: () = assert!(
    size_of::<ActiveContact>() + size_of::<LoweredPair>() + size_of::<PinchedPair>() == 152
);
const _: () = assert!(size_of::<CertificateSegment>() == 16);

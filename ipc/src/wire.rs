//! What crosses the process boundary: headers, sections, records and codes.
//!
//! Every type here is `#[repr(C)]`, made of `u32`, `u64`, `i32` and `f64` only, without padding,
//! little endian. Fields that are enums in the program (mode, status, code, ...) are plain integers
//! on the wire, because an invalid bit pattern of an enum would be undefined behaviour; `try_from`
//! checks them. `WIRE.md` is written from these definitions.

pub(crate) mod body;
mod code;
pub mod document;
mod error;
mod flags;
#[macro_use]
mod layout;
mod envelope;
mod number;
mod record;
pub(crate) mod request;
mod response;
pub(crate) mod section;
mod status;
mod trajectory;

pub use body::{RequestBody, ResponseBody};
pub use code::Code;
pub use envelope::Envelope;
pub use error::WireError;
pub use flags::{RequestFlags, ResponseFlags};
pub use layout::{Field, Section};
pub use number::{
    Controller, EnvelopeKind, Mode, RefusalReason, RequirementKind, SceneEventKind, Stage, Status,
    Termination, Times, TimingStage, Unit, WarningKind,
};
pub use record::{
    CertificateHead, CertificateSegment, HoldRecord, KeptRecord, LoweredFloorRecord, RefusalRecord,
    RequirementRecord, StageRecord, TextSpan, TrajectoryRecord, TurnedColumn, WarningRecord,
};
pub use request::{ControlHeader, ControlReplyHeader, RequestHeader, RequestView};
pub use response::{ResponseHeader, ResponseView};
pub use status::{RobotEntry, SceneEntry, SceneEvent, StatusRecord};
pub use trajectory::{TrajectoryPlaces, TrajectorySections};

/// `group` of a request that names no group.
pub const NO_GROUP: u32 = 0xFFFF_FFFF;

/// The 64-bit id of a robot's or scene's label: FNV-1a over its UTF-8 bytes.
///
/// An id is a short name, not a proof: two labels with the same id are refused when the second is
/// loaded. `0` is never an id (the empty label's is the offset basis).
///
/// ```
/// assert_eq!(taut_ipc::wire::label_id("panda"), taut_ipc::wire::label_id("panda"));
/// assert_ne!(taut_ipc::wire::label_id("panda"), taut_ipc::wire::label_id("ur5"));
/// ```
pub const fn label_id(label: &str) -> u64 {
    let bytes = label.as_bytes();
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut i = 0;
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u64).wrapping_mul(0x0000_0100_0000_01b3);
        i += 1;
    }
    if hash == 0 { 1 } else { hash }
}

//! Modes, stages, kinds and units here and on the wire: two tables of the same names in the same order, or this
//! does not compile.

use crate::optimize::{Mode, Stage};
use crate::timing;
use crate::validation::{RequirementKind, Unit};
use taut_ipc::wire;

const fn is_same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut at = 0;
    while at < a.len() && at < b.len() && a[at] == b[at] {
        at += 1;
    }
    at == a.len() && at == b.len()
}

/// Asserts that a table of the core and one of the wire have the same names, each numbered by its
/// place.
macro_rules! same {
    ($here:ident) => {
        const _: () = {
            assert!($here::ALL.len() == wire::$here::ALL.len());
            let mut at = 0;
            while at < $here::ALL.len() {
                let here = $here::ALL[at];
                let there = wire::$here::ALL[at].0;
                assert!(is_same(here.name(), there.name()));
                assert!(here as usize == at && there as usize == at);
                at += 1;
            }
        };
    };
}

same!(Mode);
same!(Stage);
same!(RequirementKind);
same!(Unit);

/// The stage of timing on the wire.
pub(super) fn wire_timing_stage(stage: timing::Stage) -> wire::TimingStage {
    match stage {
        timing::Stage::Stops => wire::TimingStage::Stops,
        timing::Stage::Rounded => wire::TimingStage::Rounded,
        timing::Stage::Shortcuts => wire::TimingStage::Shortcuts,
    }
}

/// The controller on the wire.
pub(super) fn wire_controller(controller: timing::Controller) -> wire::Controller {
    match controller {
        timing::Controller::Cubic => wire::Controller::Cubic,
        timing::Controller::Quintic => wire::Controller::Quintic,
        timing::Controller::Linear { .. } => wire::Controller::Linear,
    }
}

/// The mode that the wire means.
pub(super) fn mode(mode: wire::Mode) -> Mode {
    Mode::ALL[mode as usize]
}

/// The stage that the wire means.
pub(super) fn stage(stage: wire::Stage) -> Stage {
    Stage::ALL[stage as usize]
}

/// The same stage on the wire.
pub(super) fn wire_stage(stage: Stage) -> wire::Stage {
    wire::Stage::ALL[stage as usize].0
}

/// The kind of requirement that the wire means.
pub(super) fn kind(kind: wire::RequirementKind) -> RequirementKind {
    RequirementKind::ALL[kind as usize]
}

/// The same kind on the wire.
pub(super) fn wire_kind(kind: RequirementKind) -> wire::RequirementKind {
    wire::RequirementKind::ALL[kind as usize].0
}

/// The unit that the wire means.
pub(super) fn unit(unit: wire::Unit) -> Unit {
    Unit::ALL[unit as usize]
}

/// The same unit on the wire.
pub(super) fn wire_unit(unit: Unit) -> wire::Unit {
    wire::Unit::ALL[unit as usize].0
}

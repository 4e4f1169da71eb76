//! `WIRE.md`, written from the definitions.

use super::{
    CertificateHead, CertificateSegment, Code, ControlHeader, ControlReplyHeader, Controller,
    Envelope, EnvelopeKind, Field, HoldRecord, KeptRecord, LoweredFloorRecord, Mode, RefusalReason,
    RefusalRecord, RequestFlags, RequestHeader, RequirementKind, RequirementRecord, ResponseHeader,
    SceneEvent, SceneEventKind, Stage, StageRecord, Status, StatusRecord, Termination, Times,
    TimingStage, TrajectoryPlaces, TrajectoryRecord, TurnedColumn, Unit, WarningKind,
    WarningRecord,
};
use crate::services;
use std::fmt::Write;

/// The text of `WIRE.md`.
pub fn document() -> String {
    let mut text = String::from(INTRODUCTION);
    service_table(&mut text);
    for (title, size, fields) in types() {
        type_table(&mut text, title, size, fields);
    }
    number_tables(&mut text);
    code_table(&mut text);
    text
}

const INTRODUCTION: &str = "\
# The wire, version 1

Written from the definitions in `src/wire`; a test keeps it so (`UPDATE_WIRE_MD=1 cargo test -p taut-ipc wire_md`).

Everything is little endian, `repr(C)`, without padding. Payloads are bytes aligned to 8. A `Section` is
`offset u32, count u32`: `count` entries from byte `offset` of the payload on, 8-aligned; count 0 = absent.
A `TextSpan` is `offset u32, len u32` into the section `names`; a `RequirementRecord` is a requirement, see below.
Lengths of paths are in the request's metric (by default metres moved per unit of joint motion).
";

const GENERATIONS: &str = "
The daemon's lock file, `daemon.lock` in the instance's root, holds one line: its process id, its boot id and the
generation of its services (both 16 hexadecimal digits), the wire version. Each name is followed by `/` and the
generation, 16 hexadecimal digits too: services that are made anew have others than those before.
";

type Described = (&'static str, usize, &'static [Field]);

fn types() -> [Described; 20] {
    macro_rules! described {
        ($($title:literal $name:ident),*) => {
            [$( ($title, size_of::<$name>(), $name::FIELDS), )*]
        };
    }
    described![
        "Request header" RequestHeader,
        "Response header" ResponseHeader,
        "Certificate segment" CertificateSegment,
        "Certificate head" CertificateHead,
        "Requirement" RequirementRecord,
        "Lowered floor" LoweredFloorRecord,
        "Hold" HoldRecord,
        "Kept constraint" KeptRecord,
        "Turned column" TurnedColumn,
        "Stage" StageRecord,
        "Places of a trajectory" TrajectoryPlaces,
        "Trajectory" TrajectoryRecord,
        "Warning" WarningRecord,
        "Refusal" RefusalRecord,
        "Control request header" ControlHeader,
        "Control reply header" ControlReplyHeader,
        "Status" StatusRecord,
        "Scene event" SceneEvent,
        "Envelope" Envelope,
        "Section" SectionRow
    ]
}

/// Lists [`super::Section`], which has no macro of its own.
struct SectionRow {
    _offset: u32,
    _count: u32,
}

impl SectionRow {
    const FIELDS: &'static [Field] = &[
        Field {
            name: "offset",
            kind: "u32",
            offset: 0,
            size: 4,
            meaning: "first byte, a multiple of 8",
        },
        Field {
            name: "count",
            kind: "u32",
            offset: 4,
            size: 4,
            meaning: "entries, not bytes",
        },
    ];
}

fn service_table(text: &mut String) {
    text.push_str("\n## Services\n\n| name | carries |\n|---|---|\n");
    for (name, carries) in services::ALL {
        let _ = writeln!(text, "| `{name}` | {carries} |");
    }
    text.push_str(GENERATIONS);
}

fn type_table(text: &mut String, title: &str, size: usize, fields: &[Field]) {
    let _ = write!(
        text,
        "\n## {title}, {size} bytes\n\n| offset | size | field | type | meaning |\n|---|---|---|---|---|\n"
    );
    for f in fields {
        let _ = writeln!(
            text,
            "| {} | {} | `{}` | `{}` | {} |",
            f.offset, f.size, f.name, f.kind, f.meaning
        );
    }
}

fn number_tables(text: &mut String) {
    macro_rules! table {
        ($title:literal, $name:ident) => {
            let _ = write!(
                text,
                "\n## {}\n\n| value | name | meaning |\n|---|---|---|\n",
                $title
            );
            for (value, meaning) in $name::ALL {
                let _ = writeln!(text, "| {} | {value:?} | {meaning} |", u32::from(*value));
            }
        };
    }
    table!("Modes", Mode);
    table!("Statuses", Status);
    table!("Envelope kinds", EnvelopeKind);
    table!("Terminations", Termination);
    table!("Refusal reasons", RefusalReason);
    table!("Requirement kinds", RequirementKind);
    table!("Units", Unit);
    table!("Stages", Stage);
    table!("Times", Times);
    table!("Stages of timing", TimingStage);
    table!("Controllers", Controller);
    table!("Warning kinds", WarningKind);
    table!("Scene event kinds", SceneEventKind);
    request_flags(text);
    text.push_str(
        "\n## Response flags\n\nbit 0 proved, bit 1 superseded (the scene has a newer version).\n",
    );
}

fn request_flags(text: &mut String) {
    text.push_str(
        "\n## Request flags\n\nFrom the table of options; a bit that is not set is the default.\n\n\
         | bit | name | option |\n|---|---|---|\n",
    );
    for (bit, name, meaning) in RequestFlags::LISTED {
        let _ = writeln!(text, "| {bit} | {name} |{meaning} |");
    }
}

fn code_table(text: &mut String) {
    text.push_str(
        "\n## Codes\n\n| code | name | exit | retry | meaning |\n|---|---|---|---|---|\n",
    );
    for code in Code::ALL {
        let retry = if code.is_retryable() {
            "after `retry_after_ms`"
        } else {
            ""
        };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {retry} | {} |",
            i32::from(*code),
            code.name(),
            code.exit_code(),
            code.meaning()
        );
    }
}

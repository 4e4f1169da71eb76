//! Why an input was refused, in one line.

use taut::optimize::{ColumnTurns, Outcome, Refusal};
use taut::solid::TOUCHING_M;
use taut::validation::RequirementKind;

use crate::units::length;

/// Where and how; `None` where the input was not refused.
pub(super) fn line(outcome: &Outcome) -> Option<String> {
    let refusal = outcome.refusal.as_ref()?;
    let read = match turned(&outcome.turned) {
        turned if turned.is_empty() => turned,
        turned => format!("   read as unrolled{turned}"),
    };
    // A path of one waypoint has no segment; the place is then the waypoint itself.
    let segments = outcome.path.len().saturating_sub(1).max(1);
    Some(format!("{}{read}", at(refusal, segments)))
}

fn at(refusal: &Refusal, segments: usize) -> String {
    let hint = match refusal.hint.as_str() {
        "" => String::new(),
        hint => format!(" ({hint})"),
    };
    format!(
        "{} segment {} of {segments}, t = {:.3}: {}, {}{hint}",
        refusal.reason.name(),
        refusal.segment + 1,
        refusal.t,
        refusal.requirement,
        amount(refusal),
    )
}

fn amount(refusal: &Refusal) -> String {
    match refusal.requirement.kind {
        RequirementKind::Clearance => distance(refusal.amount),
        RequirementKind::Orientation | RequirementKind::Position | RequirementKind::Joint => {
            format!(
                "{:.3e} {} left",
                refusal.amount,
                refusal.requirement.unit.name()
            )
        }
    }
}

fn distance(metres: f64) -> String {
    match metres {
        distance if distance.abs() <= TOUCHING_M => "touching".to_owned(),
        distance if distance < 0.0 => format!("depth ≥ {}", length(-distance)),
        distance => format!("distance {}", length(distance)),
    }
}

/// Which columns the numbers that were read are whole turns away in.
fn turned(columns: &[ColumnTurns]) -> String {
    columns.iter().map(column).collect()
}

fn column(turned: &ColumnTurns) -> String {
    let name = &turned.variable;
    match turned.turns {
        0 => format!(", column {name} between its ends"),
        turns @ (1 | -1) => format!(", column {name} {} turn", signed(turns)),
        turns => format!(", column {name} {} turns", signed(turns)),
    }
}

/// A whole number with its sign, the minus as wide as the plus.
fn signed(number: i64) -> String {
    match number < 0 {
        true => format!("−{}", number.unsigned_abs()),
        false => format!("+{number}"),
    }
}

//! How an answer is shown: as a result file's one JSON object, or in lines for people.

use taut::files::ResultFile;
use taut::files::result::texts;
use taut::optimize::{ColumnTurns, Outcome, Refusal};
use taut::solid::TOUCHING_M;
use taut::warning::{self, Warning};
use taut_ipc::wire::Mode;

use super::answered::Answered;
use super::subject::Subject;
use taut_ipc::wire::Code;

/// The answer to a request in `mode` as a file has it.
pub(super) fn result(subject: &Subject, mode: Mode, answered: &Answered) -> ResultFile {
    let outcome = &answered.outcome;
    let told = told(subject, answered);
    ResultFile {
        name: subject.name.clone(),
        mode: mode.name().to_owned(),
        geometry: subject.geometry.to_owned(),
        code: answered.code.into(),
        code_name: answered.code.name().to_owned(),
        metric: subject.metric.clone(),
        request_id: answered.request_id.map(|id| format!("{id:016x}")),
        cpu_s: answered.cpu_s,
        time_s: answered.time_s,
        lengths_over_time: answered.lengths_over_time.clone(),
        warnings: texts(&told, |_| true),
        uncovered: texts(&told, Warning::is_uncovered),
        variables: subject.variables.clone(),
        path_before: subject.path_before.clone(),
        subject: subject.source.clone(),
        corridor: answered.corridor.clone(),
        ..ResultFile::of(outcome)
    }
}

/// What a person should know beside the answer.
pub(super) fn told(subject: &Subject, answered: &Answered) -> Vec<Warning> {
    warning::told(
        subject
            .warnings
            .iter()
            .chain(&answered.outcome.warnings)
            .chain(&subject.notes),
    )
}

/// Prints warnings, each after `before`.
pub(super) fn warn(warnings: &[Warning], before: &str) {
    for warning in warnings {
        eprintln!("warning: {before}{warning}");
    }
}

/// What a verdict says beside "proved" where the robot has geometry, and no two bodies that may not
/// touch.
pub(super) const NOTHING_TO_CHECK: &str = ", nothing to check: 0 pairs";

/// What was proved or refused, in one line.
pub(super) fn verdict(answered: &Answered) -> String {
    let outcome = &answered.outcome;
    if let Some(refusal) = &outcome.refusal {
        let read = if outcome.turned.is_empty() {
            String::new()
        } else {
            format!("   read{}", turned(outcome))
        };
        return format!("{}{read}", refused(refusal, outcome.path.len()));
    }
    if let Some(why) = &outcome.uncheckable {
        return format!("{}   {why}", answered.code.name());
    }
    match &outcome.certificate {
        Some(_) if outcome.pairs == 0 => format!("proved{}{NOTHING_TO_CHECK}", turned(outcome)),
        Some(certificate) => {
            let clearance = clearance(certificate.clearance_m());
            format!("proved{}   {clearance}{}", turned(outcome), floors(outcome))
        }
        None if answered.code == Code::Preempted => {
            format!(
                "{}   ended before the path was proved",
                answered.code.name()
            )
        }
        None => format!(
            "{}   the deadline passed before the path was proved",
            answered.code.name()
        ),
    }
}

/// Which columns the numbers that were proved are whole turns away in.
fn turned(outcome: &Outcome) -> String {
    let column = |turned: &ColumnTurns| match turned.turns {
        0 => format!(", column {} between its ends", turned.variable),
        turns @ (1 | -1) => format!(", column {} {} turn", turned.variable, signed(turns)),
        turns => format!(", column {} {} turns", turned.variable, signed(turns)),
    };
    let columns: String = outcome.turned.iter().map(column).collect();
    if columns.is_empty() {
        columns
    } else {
        format!(" as unrolled{columns}")
    }
}

/// A whole number with its sign, the minus as wide as the plus.
fn signed(number: i64) -> String {
    if number < 0 {
        format!("−{}", number.unsigned_abs())
    } else {
        format!("+{number}")
    }
}

/// What a certificate claims that a path keeps.
pub(super) fn clearance(claimed_m: Option<f64>) -> String {
    claimed_m.map_or_else(
        || "nothing near".to_owned(),
        |metres| format!("clearance ≥ {}", length(metres)),
    )
}

fn refused(refusal: &Refusal, waypoints: usize) -> String {
    let [a, b] = &refusal.bodies;
    // A path of one waypoint has no segment; the place is then the waypoint itself.
    let segments = waypoints.saturating_sub(1).max(1);
    let place = format!(
        "segment {} of {segments}, t = {:.3}",
        refusal.segment + 1,
        refusal.t
    );
    let depth = match refusal.depth_m {
        depth if depth.abs() <= TOUCHING_M => "touching".to_owned(),
        depth if depth > 0.0 => format!("depth ≥ {}", length(depth)),
        depth => format!("distance {}", length(-depth)),
    };
    let hint = if refusal.hint.is_empty() {
        String::new()
    } else {
        format!(" ({})", refusal.hint)
    };
    format!(
        "{} {place}: {a} × {b}, {depth}{hint}",
        refusal.reason.name()
    )
}

fn floors(outcome: &Outcome) -> String {
    let lowered = outcome.floors_lowered.iter();
    let named: Vec<String> = lowered
        .map(|floor| {
            format!(
                "{} × {} {}",
                floor.bodies[0],
                floor.bodies[1],
                length(floor.floor_m)
            )
        })
        .collect();
    if named.is_empty() {
        String::new()
    } else {
        format!("   lowered: {}", named.join(", "))
    }
}

/// Lengths before and after, in one line.
pub(super) fn lengths(outcome: &Outcome) -> String {
    let before = outcome.length_before;
    let after = outcome.length_after;
    let change = if before > 0.0 {
        format!(" (−{:.1} %)", 100.0 * (1.0 - after / before))
    } else {
        String::new()
    };
    format!("length {before:.4} → {after:.4}{change}")
}

/// A distance with a fitting unit.
pub(super) fn length(metres: f64) -> String {
    match metres {
        m if m >= 1.0 => format!("{m:.2} m"),
        m if m >= 1e-4 => format!("{:.3} mm", m * 1e3),
        m => format!("{:.3} µm", m * 1e6),
    }
}

/// A time with a fitting unit.
pub(super) fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 1.0 => format!("{s:.2} s"),
        s if s >= 1e-3 => format!("{:.2} ms", s * 1e3),
        s => format!("{:.1} µs", s * 1e6),
    }
}

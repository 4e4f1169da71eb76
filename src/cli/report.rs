//! How an answer is shown: as a result file's one JSON object, or in lines for people.

use taut::files::result::{ResultCoordinate, ResultCorridor, ResultSubject, texts};
use taut::files::{Geometry, ResultFile};
use taut::optimize::{ColumnTurns, Mode, Outcome, Refusal};
use taut::solid::TOUCHING_M;
use taut::warning::{self, Warning};

use super::code::Code;
use super::layout::Coordinate;
use super::run::Timed;

/// What was answered about.
pub(super) struct Subject {
    /// Label of the problem, or the file's name.
    pub name: String,
    /// Which of the robot's models was taken.
    pub geometry: &'static str,
    /// What a person should know of robot and scene, where the answer itself does not tell.
    pub warnings: Vec<Warning>,
    /// What the request leaves to be known.
    pub notes: Vec<Warning>,
    /// Columns of the path.
    pub variables: Vec<String>,
    /// Velocity coordinates.
    pub coordinates: Vec<Coordinate>,
    /// What lengths are measured in.
    pub metric: String,
    /// The input's waypoints.
    pub path_before: Vec<Vec<f64>>,
    /// Where robot and scene come from; empty where no result file is wanted.
    pub source: ResultSubject,
}

/// The answer to a request in `mode` as a file has it.
pub(super) fn result(subject: &Subject, mode: Mode, timed: &Timed) -> ResultFile {
    let outcome = &timed.outcome;
    let told = told(subject, timed);
    ResultFile {
        name: subject.name.clone(),
        mode: mode.name().to_owned(),
        geometry: subject.geometry.to_owned(),
        code: timed.code.into(),
        code_name: timed.code.name().to_owned(),
        metric: subject.metric.clone(),
        request_id: timed.request_id.map(|id| format!("{id:016x}")),
        cpu_s: timed.cpu_s,
        time_s: timed.time_s,
        lengths_over_time: timed.lengths_over_time.clone(),
        warnings: texts(&told, |_| true),
        uncovered: texts(&told, Warning::is_uncovered),
        variables: subject.variables.clone(),
        path_before: subject.path_before.clone(),
        subject: subject.source.clone(),
        corridor: corridor(subject, outcome),
        ..ResultFile::of(outcome)
    }
}

/// What a person should know beside the answer.
pub(super) fn told(subject: &Subject, timed: &Timed) -> Vec<Warning> {
    warning::told(
        subject
            .warnings
            .iter()
            .chain(&timed.outcome.warnings)
            .chain(&subject.notes),
    )
}

/// Prints warnings, each after `before`.
pub(super) fn warn(warnings: &[Warning], before: &str) {
    for warning in warnings {
        eprintln!("warning: {before}{warning}");
    }
}

/// How far what is executed may stray from the path.
fn corridor(subject: &Subject, outcome: &Outcome) -> Option<ResultCorridor> {
    let corridor = outcome.corridor.as_ref()?;
    let unwrapped = outcome
        .certificate
        .as_ref()
        .is_some_and(|certificate| certificate.unwrapped);
    let coordinate = |(coordinate, reach_m): (&Coordinate, &f64)| ResultCoordinate {
        variable: coordinate.variable.clone(),
        kind: coordinate.kind(unwrapped).to_owned(),
        reach_m: *reach_m,
    };
    Some(ResultCorridor {
        floor_m: corridor.floor_m,
        coordinates: subject
            .coordinates
            .iter()
            .zip(&corridor.reach)
            .map(coordinate)
            .collect(),
        slack_m: corridor.slack_m.clone(),
    })
}

/// Name of a geometry in results.
pub(super) fn geometry_name(geometry: Geometry) -> &'static str {
    match geometry {
        Geometry::Given => "given",
        Geometry::Spheres => "spheres",
    }
}

/// What a verdict says beside "proved" where the robot has geometry, and no two bodies that may not
/// touch.
pub(super) const NOTHING_TO_CHECK: &str = ", nothing to check: 0 pairs";

/// What was proved or refused, in one line.
pub(super) fn verdict(timed: &Timed) -> String {
    let outcome = &timed.outcome;
    if let Some(refusal) = &outcome.refusal {
        let read = if outcome.turned.is_empty() {
            String::new()
        } else {
            format!("   read{}", turned(outcome))
        };
        return format!("{}{read}", refused(refusal, outcome.path.len()));
    }
    if let Some(why) = &outcome.uncheckable {
        return format!("{}   {why}", timed.code.name());
    }
    match &outcome.certificate {
        Some(_) if outcome.pairs == 0 => format!("proved{}{NOTHING_TO_CHECK}", turned(outcome)),
        Some(certificate) => {
            let clearance = clearance(certificate.clearance_m());
            format!("proved{}   {clearance}{}", turned(outcome), floors(outcome))
        }
        None if timed.code == Code::Preempted => {
            format!("{}   ended before the path was proved", timed.code.name())
        }
        None => format!(
            "{}   the deadline passed before the path was proved",
            timed.code.name()
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

//! How an answer is shown: as a result file's one JSON object, or in lines for people.

use taut::files::ResultFile;
use taut::files::result::texts;
use taut::optimize::{ColumnTurns, Outcome, Refusal};
use taut::solid::TOUCHING_M;
use taut::validation::{Certificate, LoweredFloor, NamedRequirement, RequirementKind, Unit};
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
        request_id: answered
            .request_id
            .map(|id| format!("{id:016x}")),
        world_age_s: answered.world_age_s,
        cpu_s: answered.cpu_s,
        time_s: answered.time_s,
        lengths_over_time: answered.lengths_over_time.clone(),
        warnings: texts(&told, |_| true),
        uncovered: texts(&told, Warning::is_uncovered),
        variables: subject.variables.clone(),
        path_before: subject.path_before.clone(),
        path_constraints: subject.constraints.clone(),
        subject: subject.source.clone(),
        corridor: answered.corridor.clone(),
        times: answered.times.clone(),
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
    let code = answered.code.name();
    if let Some(refusal) = &outcome.refusal {
        return refused(refusal, outcome.path.len()) + &read_as(outcome);
    }
    if let Some(why) = &outcome.uncheckable {
        return format!("{code}   {why}");
    }
    match &outcome.certificate {
        Some(certificate) => proved(outcome, certificate) + &seen(answered.world_age_s),
        None if answered.code == Code::Preempted => {
            format!("{code}   ended before the path was proved")
        }
        None => format!("{code}   the deadline passed before the path was proved"),
    }
}

/// How old what sensors see of the scene was.
fn seen(world_age_s: Option<f64>) -> String {
    world_age_s.map_or_else(String::new, |age_s| format!("   seen {} ago", time(age_s)))
}

/// Which columns of a refused path were read otherwise than they stand.
fn read_as(outcome: &Outcome) -> String {
    match outcome.turned.is_empty() {
        true => String::new(),
        false => format!("   read{}", turned(outcome)),
    }
}

fn proved(outcome: &Outcome, certificate: &Certificate) -> String {
    let turned = turned(outcome);
    if outcome.pairs == 0 {
        return format!("proved{turned}{NOTHING_TO_CHECK}");
    }
    let clearance = clearance(certificate.clearance_m());
    let lowered = lowered(&outcome.floors_lowered);
    format!("proved{turned}   {clearance}{lowered}")
}

/// Which columns the numbers that were proved are whole turns away in.
fn turned(outcome: &Outcome) -> String {
    match outcome.turned.is_empty() {
        true => String::new(),
        false => format!(
            " as unrolled{}",
            outcome
                .turned
                .iter()
                .map(column)
                .collect::<String>()
        ),
    }
}

fn column(turned: &ColumnTurns) -> String {
    let variable = &turned.variable;
    match turned.turns {
        0 => format!(", column {variable} between its ends"),
        turns @ (1 | -1) => format!(", column {variable} {} turn", signed(turns)),
        turns => format!(", column {variable} {} turns", signed(turns)),
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
    // A path of one waypoint has no segment; the place is then the waypoint itself.
    let segments = waypoints.saturating_sub(1).max(1);
    format!(
        "{} segment {} of {segments}, t = {:.3}: {}, {}{}",
        refusal.reason.name(),
        refusal.segment + 1,
        refusal.t,
        refusal.requirement,
        amount(&refusal.requirement, refusal.amount),
        hint(&refusal.hint)
    )
}

/// How much of a requirement is kept that is not kept enough.
pub(super) fn amount(requirement: &NamedRequirement, amount: f64) -> String {
    match requirement.kind {
        RequirementKind::Clearance => distance(amount),
        RequirementKind::Orientation | RequirementKind::Position | RequirementKind::Joint => {
            tolerance(requirement.unit, amount)
        }
    }
}

fn tolerance(unit: Unit, left: f64) -> String {
    match left < 0.0 {
        true => format!("outside by {}", quantity(unit, -left)),
        false => format!("{} left", quantity(unit, left)),
    }
}

fn distance(metres: f64) -> String {
    match metres {
        distance if distance.abs() <= TOUCHING_M => "touching".to_owned(),
        distance if distance < 0.0 => format!("depth ≥ {}", length(-distance)),
        distance => format!("distance {}", length(distance)),
    }
}

fn hint(hint: &str) -> String {
    match hint {
        "" => String::new(),
        hint => format!(" ({hint})"),
    }
}

/// Floors that were lowered, and tolerances that were raised; nothing where none was.
pub(super) fn lowered(floors: &[LoweredFloor]) -> String {
    let of_clearance = |floor: &&LoweredFloor| floor.requirement.kind == RequirementKind::Clearance;
    let (clearances, constraints): (Vec<_>, Vec<_>) = floors.iter().partition(of_clearance);
    let lowered = listed("   lowered: ", clearances.into_iter().map(floor));
    lowered + &listed("   raised: ", constraints.into_iter().map(raised))
}

/// By how much a constraint's tolerance was raised.
fn raised(LoweredFloor { requirement, floor }: &LoweredFloor) -> String {
    format!("{requirement} by {}", quantity(requirement.unit, -floor))
}

/// A certificate as its file has it.
pub(super) fn certificate(certificate: &Certificate) -> String {
    let text = serde_json::to_string(certificate);
    text.expect("a certificate holds only strings and numbers") + "\n"
}

/// Items after what stands before them; nothing where there is none.
pub(super) fn listed(before: &str, items: impl Iterator<Item = String>) -> String {
    let items: Vec<String> = items.collect();
    match items.is_empty() {
        true => String::new(),
        false => format!("{before}{}", items.join(", ")),
    }
}

fn floor(LoweredFloor { requirement, floor }: &LoweredFloor) -> String {
    format!("{requirement} {}", quantity(requirement.unit, *floor))
}

/// An amount with its unit.
pub(super) fn quantity(unit: Unit, amount: f64) -> String {
    match unit {
        Unit::Metre => length(amount),
        Unit::Radian => angle(amount),
    }
}

/// Lengths before and after, in one line.
pub(super) fn lengths(outcome: &Outcome) -> String {
    let before = outcome.length_before;
    let after = outcome.length_after;
    let lengths = format!("length {before:.4} → {after:.4}");
    match before > 0.0 {
        true => format!("{lengths} (−{:.1} %)", 100.0 * (1.0 - after / before)),
        false => lengths,
    }
}

/// A number to four digits, rounded up: what is proved to be no more stays true.
pub(super) fn no_less(number: f64) -> String {
    rounded(number, f64::ceil)
}

/// The same rounded down.
pub(super) fn no_more(number: f64) -> String {
    rounded(number, f64::floor)
}

fn rounded(number: f64, round: fn(f64) -> f64) -> String {
    if number == 0.0 {
        return "0".to_owned();
    }
    let magnitude = number.abs().log10().floor();
    let places = (3.0 - magnitude).clamp(0.0, 12.0) as usize;
    let unit = 10_f64.powi(places as i32);
    format!("{:.places$}", round(number * unit) / unit)
}

/// An angle, to what shows.
fn angle(radians: f64) -> String {
    match radians.abs() {
        rad if rad == 0.0 || rad >= 1e-3 => format!("{radians:.5} rad"),
        _ => format!("{radians:.2e} rad"),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_proved_is_rounded_so_that_it_stays_true() {
        let both = |number: f64| (no_more(number), no_less(number));
        let words = |low: &str, high: &str| (low.to_owned(), high.to_owned());
        assert_eq!(both(0.098_104_3), words("0.09810", "0.09811"));
        assert_eq!(both(1.999_96), words("1.999", "2.000"));
        assert_eq!(both(-2.504_3e-4), words("-0.0002505", "-0.0002504"));
        assert_eq!(both(0.0), words("0", "0"));
        assert_eq!(both(12_345.6), words("12345", "12346"));
    }
}

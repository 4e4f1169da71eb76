//! How an answer is shown: one JSON object, or lines for people.

use serde::Serialize;
use taut::collision::query::TOUCHING_M;
use taut::files::Geometry;
use taut::optimize::{Mode, Outcome, PathContact, Refusal, StageShare, Termination};
use taut::validation::{Certificate, HitReason};

use super::code::Code;
use super::layout::Coordinate;
use super::run::Timed;

/// What was answered about.
pub(super) struct Subject {
    /// Label of the problem, or the file's name.
    pub name: String,
    /// Which of the robot's models was taken.
    pub geometry: &'static str,
    /// What is odd about robot and scene, a line each.
    pub warnings: Vec<String>,
    /// Columns of the path.
    pub variables: Vec<String>,
    /// Velocity coordinates.
    pub coordinates: Vec<Coordinate>,
    /// What lengths are measured in.
    pub metric: String,
}

/// An answer as JSON has it. Lengths are in the metric of `weights`, distances in metres, times in seconds.
#[derive(Serialize)]
pub(super) struct Answer<'a> {
    name: &'a str,
    mode: &'static str,
    geometry: &'static str,
    proved: bool,
    code: i32,
    code_name: &'static str,
    length_before: f64,
    length_after: f64,
    lower_bound: f64,
    gap: Option<f64>,
    metric: &'a str,
    clearance_m: f64,
    floor_m: f64,
    floors_lowered: Vec<Floor<'a>>,
    pinched: &'a [[String; 2]],
    searched_m: Option<f64>,
    smallest_clearance: Option<Contact<'a>>,
    contacts: Option<Vec<Contact<'a>>>,
    /// For `taut why`.
    #[serde(skip_serializing_if = "Option::is_none")]
    request_id: Option<String>,
    cpu_s: f64,
    time_s: f64,
    iterations: u64,
    work: u64,
    termination: &'static str,
    stage: &'static str,
    stages: Vec<Share>,
    #[serde(flatten)]
    refusal: Option<RefusalFields<'a>>,
    warnings: Vec<&'a str>,
    variables: Vec<&'a str>,
    weights: &'a [f64],
    path: Vec<&'a [f64]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    corridor: Option<Corridor<'a>>,
    certificate: Option<&'a Certificate>,
}

#[derive(Serialize)]
struct Floor<'a> {
    bodies: &'a [String; 2],
    floor_m: f64,
}

#[derive(Serialize)]
struct Contact<'a> {
    segment: usize,
    t: f64,
    bodies: &'a [String; 2],
    distance_m: f64,
    points: [[f64; 3]; 2],
    normal: [f64; 3],
}

/// How far what is executed may stray from the path; read again by `taut::files::CorridorFile`.
#[derive(Serialize)]
struct Corridor<'a> {
    floor_m: f64,
    coordinates: Vec<Reaching<'a>>,
    slack_m: &'a [f64],
}

#[derive(Serialize)]
struct Reaching<'a> {
    variable: &'a str,
    kind: &'static str,
    reach_m: f64,
}

#[derive(Serialize)]
struct Share {
    stage: &'static str,
    gain: f64,
    iterations: u64,
    work: u64,
}

#[derive(Serialize)]
struct RefusalFields<'a> {
    reason: &'static str,
    segment: usize,
    t: f64,
    bodies: &'a [String; 2],
    points: [[f64; 3]; 2],
    normal: [f64; 3],
    depth_m: f64,
    proved_prefix: f64,
    hint: &'a str,
}

impl<'a> Answer<'a> {
    /// The answer to a request in `mode`.
    pub(super) fn new(subject: &'a Subject, mode: Mode, timed: &'a Timed) -> Self {
        let outcome = &timed.outcome;
        let code = timed.code;
        let floors = outcome.floors_lowered.iter();
        let nearest = outcome.nearest.as_ref();
        let stages = outcome.stages.iter();
        let unwrapped = outcome.certificate.as_ref().is_some_and(|certificate| certificate.unwrapped);
        let corridor = outcome.corridor.as_ref();
        let corridor = corridor.map(|corridor| Corridor::new(corridor, &subject.coordinates, unwrapped));
        Self {
            name: &subject.name,
            mode: mode.name(),
            geometry: subject.geometry,
            proved: outcome.proved,
            code: code.into(),
            code_name: code.name(),
            length_before: outcome.length_before,
            length_after: outcome.length_after,
            lower_bound: outcome.lower_bound,
            gap: outcome.gap(),
            metric: &subject.metric,
            clearance_m: outcome.clearance_m,
            floor_m: outcome.floor_m,
            floors_lowered: floors.map(|floor| Floor { bodies: &floor.bodies, floor_m: floor.floor_m }).collect(),
            pinched: &outcome.pinched,
            searched_m: nearest.map(|nearest| nearest.searched_m),
            smallest_clearance: nearest.and_then(|nearest| nearest.smallest.as_ref()).map(Contact::new),
            contacts: nearest.map(|nearest| nearest.contacts.iter().map(Contact::new).collect()),
            request_id: timed.request_id.map(|id| format!("{id:016x}")),
            cpu_s: timed.cpu_s,
            time_s: timed.time_s,
            iterations: outcome.iterations,
            work: outcome.work,
            termination: termination_name(outcome.termination),
            stage: outcome.stage.name(),
            stages: stages.map(Share::new).collect(),
            refusal: outcome.refusal.as_ref().map(RefusalFields::new),
            warnings: subject.warnings.iter().chain(&outcome.warnings).map(String::as_str).collect(),
            variables: subject.variables.iter().map(String::as_str).collect(),
            weights: &outcome.weights,
            path: outcome.path.waypoints().collect(),
            corridor,
            certificate: outcome.certificate.as_ref(),
        }
    }

    /// The answer as one line of JSON.
    pub(super) fn json(&self) -> String {
        serde_json::to_string(self).expect("an answer holds only strings, booleans and numbers")
    }
}

impl<'a> Contact<'a> {
    fn new(contact: &'a PathContact) -> Self {
        Self {
            segment: contact.segment,
            t: contact.t,
            bodies: &contact.bodies,
            distance_m: contact.distance_m,
            points: contact.points.map(|point| point.to_array()),
            normal: contact.normal.to_array(),
        }
    }
}

impl<'a> Corridor<'a> {
    fn new(corridor: &'a taut::validation::Corridor, coordinates: &'a [Coordinate], unwrapped: bool) -> Self {
        let reaching = |(coordinate, reach_m): (&'a Coordinate, &f64)| Reaching {
            variable: &coordinate.variable,
            kind: coordinate.kind(unwrapped),
            reach_m: *reach_m,
        };
        let coordinates = coordinates.iter().zip(&corridor.reach).map(reaching).collect();
        Self { floor_m: corridor.floor_m, coordinates, slack_m: &corridor.slack_m }
    }
}

impl Share {
    fn new(share: &StageShare) -> Self {
        let StageShare { stage, gain, work, iterations } = *share;
        Self { stage: stage.name(), gain, iterations, work }
    }
}

impl<'a> RefusalFields<'a> {
    fn new(refusal: &'a Refusal) -> Self {
        Self {
            reason: reason_name(refusal.reason),
            segment: refusal.segment,
            t: refusal.t,
            bodies: &refusal.bodies,
            points: refusal.points.map(|point| point.to_array()),
            normal: refusal.normal.to_array(),
            depth_m: refusal.depth_m,
            proved_prefix: refusal.proved_prefix,
            hint: &refusal.hint,
        }
    }
}

/// Name of a geometry in results.
pub(super) fn geometry_name(geometry: Geometry) -> &'static str {
    match geometry {
        Geometry::Given => "given",
        Geometry::Spheres => "spheres",
    }
}

/// Name of a termination in results.
pub(super) fn termination_name(termination: Termination) -> &'static str {
    match termination {
        Termination::Done => "done",
        Termination::Converged => "converged",
        Termination::IterationLimit => "iteration-limit",
        Termination::WorkBudget => "work-budget",
        Termination::Stopped => "stopped",
    }
}

fn reason_name(reason: HitReason) -> &'static str {
    match reason {
        HitReason::Collision => "COLLISION",
        HitReason::TooClose => "TOO_CLOSE",
        HitReason::Uncertified => "UNCERTIFIED",
    }
}

/// What was proved or refused, in one line.
pub(super) fn verdict(timed: &Timed) -> String {
    let outcome = &timed.outcome;
    if let Some(refusal) = &outcome.refusal {
        return refused(refusal, outcome.path.len());
    }
    match &outcome.certificate {
        Some(certificate) => {
            let clearance = clearance(certificate.clearance_m());
            format!("proved   {clearance}{}", floors(outcome))
        }
        None if timed.code == Code::Preempted => format!("{}   ended before the path was proved", timed.code.name()),
        None => format!("{}   the deadline passed before the path was proved", timed.code.name()),
    }
}

/// What a certificate claims that a path keeps.
pub(super) fn clearance(claimed_m: Option<f64>) -> String {
    claimed_m.map_or_else(|| "nothing near".to_owned(), |metres| format!("clearance ≥ {}", length(metres)))
}

fn refused(refusal: &Refusal, waypoints: usize) -> String {
    let [a, b] = &refusal.bodies;
    // A path of one waypoint has no segment; the place is then the waypoint itself.
    let segments = waypoints.saturating_sub(1).max(1);
    let place = format!("segment {} of {segments}, t = {:.3}", refusal.segment + 1, refusal.t);
    let depth = match refusal.depth_m {
        depth if depth.abs() <= TOUCHING_M => "touching".to_owned(),
        depth if depth > 0.0 => format!("depth {}", length(depth)),
        depth => format!("distance {}", length(-depth)),
    };
    let hint = if refusal.hint.is_empty() { String::new() } else { format!(" ({})", refusal.hint) };
    format!("{} {place}: {a} × {b}, {depth}{hint}", reason_name(refusal.reason))
}

fn floors(outcome: &Outcome) -> String {
    let lowered = outcome.floors_lowered.iter();
    let named: Vec<String> =
        lowered.map(|floor| format!("{} × {} {}", floor.bodies[0], floor.bodies[1], length(floor.floor_m))).collect();
    if named.is_empty() { String::new() } else { format!("   lowered: {}", named.join(", ")) }
}

/// Lengths before and after, in one line.
pub(super) fn lengths(outcome: &Outcome) -> String {
    let (before, after) = (outcome.length_before, outcome.length_after);
    let change = if before > 0.0 { format!(" (−{:.1} %)", 100.0 * (1.0 - after / before)) } else { String::new() };
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

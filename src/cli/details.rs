//! What stands below the first line of an answer for people: how good it is, what holds it, how it
//! came about.

use std::fmt::Write;

use taut::files::result::{ResultNearest, ResultTrajectory};
use taut::optimize::{KeptConstraint, Outcome, PathHold, Stage, StageShare};
use taut::validation::{Corridor, RequirementKind};

use super::answered::Answered;
use super::report::{clearance, length, listed, lowered, no_less, no_more, quantity};
use super::subject::Subject;

/// Places that are listed one by one.
const LISTED: usize = 8;

/// Below a shortened path.
pub(super) fn of_shortening(subject: &Subject, answered: &Answered) -> String {
    let outcome = &answered.outcome;
    if !outcome.proved {
        return String::new();
    }
    let mut text = String::new();
    line(&mut text, "bound", &bound(outcome, &subject.metric));
    times(&mut text, answered);
    along(&mut text, outcome);
    corridor(&mut text, outcome);
    pinched(&mut text, outcome);
    if !outcome.stages.is_empty() {
        line(&mut text, "stages", &stages(outcome));
    }
    line(&mut text, "ended", &ended(outcome));
    request(&mut text, answered);
    text
}

fn pinched(text: &mut String, outcome: &Outcome) {
    let pinched = outcome.pinched.iter().map(ToString::to_string);
    let between = listed("between ", pinched);
    if !between.is_empty() {
        line(text, "pinched", &between);
    }
}

fn request(text: &mut String, answered: &Answered) {
    if let Some(id) = answered.request_id {
        let hint = format!("{id:016x}   taut why tells how it went");
        line(text, "request", &hint);
    }
}

/// Below a path that was checked.
pub(super) fn of_check(answered: &Answered) -> String {
    let mut text = String::new();
    times(&mut text, answered);
    along(&mut text, &answered.outcome);
    corridor(&mut text, &answered.outcome);
    text
}

fn line(text: &mut String, head: &str, rest: &str) {
    let _ = write!(text, "\n  {head:<9}{rest}");
}

/// How long its trajectory takes, where one was asked for.
fn times(text: &mut String, answered: &Answered) {
    let Some(times) = &answered.times else {
        return;
    };
    match &times.trajectory {
        Some(trajectory) => {
            line(text, "time", &timed(trajectory));
            let nearest = trajectory.nearest.as_ref();
            if let Some(nearest) = nearest.map(nearest_in_time) {
                line(text, "", &nearest);
            }
        }
        None => line(
            text,
            "time",
            &format!("none ({}): {}", times.status, times.message),
        ),
    }
}

fn timed(trajectory: &ResultTrajectory) -> String {
    format!(
        "{:.3} s → {:.3} s   bound {:.3} s ({}), gap {:.1} %   proved   {}{}   {} points",
        trajectory.stops_s,
        trajectory.duration_s,
        trajectory.duration_bound_s,
        trajectory.decides,
        100.0 * trajectory.gap,
        clearance(trajectory.clearance_m),
        lowered(&trajectory.floors_lowered),
        trajectory.times_ns.len(),
    )
}

fn nearest_in_time(nearest: &ResultNearest) -> String {
    format!(
        "nearest at {:.3} s: {}, {}",
        nearest.time_s,
        nearest.requirement,
        quantity(nearest.requirement.unit, nearest.amount)
    )
}

fn bound(outcome: &Outcome, metric: &str) -> String {
    let gap = outcome
        .gap()
        .map(|gap| format!(", gap {:.1} %", 100.0 * gap));
    format!(
        "{:.4}{}   lengths in {metric}",
        outcome.lower_bound,
        gap.unwrap_or_default()
    )
}

fn nearest(text: &mut String, outcome: &Outcome) {
    let Some(nearest) = &outcome.nearest else {
        return;
    };
    let segments = segments(outcome);
    let smallest = match &nearest.smallest {
        Some(hold) => place(hold, segments),
        None => format!("nothing within {}", length(nearest.searched_m)),
    };
    line(text, "nearest", &smallest);
}

/// What comes near, what is left of constraints, what holds the path.
fn along(text: &mut String, outcome: &Outcome) {
    nearest(text, outcome);
    keeps(text, outcome);
    held_by(text, outcome);
}

fn segments(outcome: &Outcome) -> usize {
    outcome.path.len().saturating_sub(1).max(1)
}

/// What holds the path.
fn held_by(text: &mut String, outcome: &Outcome) {
    let segments = segments(outcome);
    let holds = outcome
        .nearest
        .iter()
        .flat_map(|nearest| &nearest.holds);
    list(text, "held by", holds, |hold| place(hold, segments));
}

/// What the path keeps of each constraint.
fn keeps(text: &mut String, outcome: &Outcome) {
    let segments = segments(outcome);
    list(text, "keeps", outcome.keeps.iter(), |kept| {
        format!("{} ({})", proved(kept), found(kept, segments))
    });
}

/// What is proved of a constraint everywhere along the path.
fn proved(kept: &KeptConstraint) -> String {
    let requirement = &kept.tightest.requirement;
    let unit = requirement.unit.name();
    match kept.asked {
        Some(asked) => format!(
            "{requirement} {} at most {} of {asked} {unit}",
            verb(requirement.kind),
            no_less(asked - kept.left)
        ),
        None => format!(
            "{requirement} keeps {} {unit} of its tolerance",
            no_more(kept.left)
        ),
    }
}

fn verb(kind: RequirementKind) -> &'static str {
    match kind {
        RequirementKind::Orientation => "tilts",
        RequirementKind::Clearance | RequirementKind::Position | RequirementKind::Joint => "strays",
    }
}

/// Where least was found to be left, which proves nothing.
fn found(kept: &KeptConstraint, segments: usize) -> String {
    let tightest = &kept.tightest;
    let unit = tightest.requirement.unit.name();
    let amount = match kept.asked {
        Some(asked) => no_more(asked - tightest.amount),
        None => no_less(tightest.amount),
    };
    format!(
        "tightest at segment {} of {segments}, t = {:.3}: {amount} {unit} found",
        tightest.segment + 1,
        tightest.t
    )
}

/// Lines for the first items, the first line after a head.
fn list<T>(
    text: &mut String,
    head: &str,
    mut items: impl Iterator<Item = T>,
    words: impl Fn(T) -> String,
) {
    for (index, item) in items.by_ref().take(LISTED).enumerate() {
        let head = if index == 0 { head } else { "" };
        line(text, head, &words(item));
    }
    match items.count() {
        0 => {}
        more => line(text, "", &format!("and {more} more")),
    }
}

fn corridor(text: &mut String, outcome: &Outcome) {
    let slack = outcome.corridor.as_ref().and_then(slack);
    if let Some(slack) = slack {
        line(text, "corridor", &slack);
    }
}

/// The least slack of a corridor; `None` of one without segments.
fn slack(corridor: &Corridor) -> Option<String> {
    let slack = &corridor.slack_m;
    let narrowest = (0..slack.len()).min_by(|&i, &j| slack[i].total_cmp(&slack[j]))?;
    Some(format!(
        "slack {} or more, least on segment {} of {}, keeps {}",
        length(slack[narrowest]),
        narrowest + 1,
        slack.len(),
        length(corridor.floor_m)
    ))
}

fn place(hold: &PathHold, segments: usize) -> String {
    let requirement = &hold.requirement;
    let amount = quantity(requirement.unit, hold.amount);
    let segment = hold.segment + 1;
    format!(
        "{requirement}, {amount}, segment {segment} of {segments}, t = {:.3}",
        hold.t
    )
}

fn stages(outcome: &Outcome) -> String {
    let shares: Vec<String> = outcome.stages.iter().map(share).collect();
    shares.join(", ")
}

fn share(share: &StageShare) -> String {
    let name = share.stage.name();
    let gain = share.gain;
    format!(
        "{name} −{gain:.4} ({} iterations, {} work)",
        share.iterations, share.work
    )
}

fn ended(outcome: &Outcome) -> String {
    let why = outcome.termination.name();
    let iterations = outcome.iterations;
    let work = outcome.work;
    let found = found_by(outcome.stage);
    format!("{why}, {found}, {iterations} iterations, {work} work")
}

fn found_by(stage: Stage) -> String {
    match stage {
        Stage::Input => "nothing shorter found".to_owned(),
        stage => format!("found by {}", stage.name()),
    }
}

//! What stands below the first line of an answer for people: how good it is, what holds it, how it
//! came about.

use std::fmt::Write;

use taut::optimize::{NearestBodies, Outcome, PathContact};

use super::answered::Answered;
use super::report::length;
use super::subject::Subject;

/// Contacts that are listed one by one.
const LISTED: usize = 8;

/// Below a shortened path.
pub(super) fn of_shortening(subject: &Subject, answered: &Answered) -> String {
    let outcome = &answered.outcome;
    if !outcome.proved {
        return String::new();
    }
    let mut text = String::new();
    line(&mut text, "bound", &bound(outcome, &subject.metric));
    nearest(&mut text, outcome);
    corridor(&mut text, outcome);
    if !outcome.pinched.is_empty() {
        let pairs = outcome.pinched.iter().map(|[a, b]| format!("{a} × {b}"));
        line(
            &mut text,
            "pinched",
            &format!("between {}", pairs.collect::<Vec<_>>().join(", ")),
        );
    }
    if !outcome.stages.is_empty() {
        line(&mut text, "stages", &stages(outcome));
    }
    line(&mut text, "ended", &ended(outcome));
    if let Some(id) = answered.request_id {
        line(
            &mut text,
            "request",
            &format!("{id:016x}   taut why tells how it went"),
        );
    }
    text
}

/// Below a path that was checked.
pub(super) fn of_check(answered: &Answered) -> String {
    let mut text = String::new();
    nearest(&mut text, &answered.outcome);
    corridor(&mut text, &answered.outcome);
    text
}

fn line(text: &mut String, head: &str, rest: &str) {
    let _ = write!(text, "\n  {head:<9}{rest}");
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
    let Some(NearestBodies {
        searched_m,
        smallest,
        contacts,
    }) = &outcome.nearest
    else {
        return;
    };
    let segments = outcome.path.len().saturating_sub(1).max(1);
    match smallest {
        Some(contact) => line(text, "nearest", &place(contact, segments)),
        None => line(
            text,
            "nearest",
            &format!("nothing within {}", length(*searched_m)),
        ),
    }
    for (index, contact) in contacts.iter().take(LISTED).enumerate() {
        line(
            text,
            if index == 0 { "held by" } else { "" },
            &place(contact, segments),
        );
    }
    if contacts.len() > LISTED {
        line(text, "", &format!("and {} more", contacts.len() - LISTED));
    }
}

fn corridor(text: &mut String, outcome: &Outcome) {
    let Some(corridor) = &outcome.corridor else {
        return;
    };
    let slack = &corridor.slack_m;
    let Some(narrowest) = (0..slack.len()).min_by(|&i, &j| slack[i].total_cmp(&slack[j])) else {
        return;
    };
    let least = length(slack[narrowest]);
    let segment = narrowest + 1;
    let of = slack.len();
    let floor = length(corridor.floor_m);
    line(
        text,
        "corridor",
        &format!("slack {least} or more, least on segment {segment} of {of}, keeps {floor}"),
    );
}

fn place(contact: &PathContact, segments: usize) -> String {
    let [a, b] = &contact.bodies;
    let distance = length(contact.distance_m);
    let segment = contact.segment + 1;
    format!(
        "{a} × {b}, {distance}, segment {segment} of {segments}, t = {:.3}",
        contact.t
    )
}

fn stages(outcome: &Outcome) -> String {
    let share = |share: &taut::optimize::StageShare| {
        let name = share.stage.name();
        let gain = share.gain;
        format!(
            "{name} −{gain:.4} ({} iterations, {} work)",
            share.iterations, share.work
        )
    };
    outcome
        .stages
        .iter()
        .map(share)
        .collect::<Vec<_>>()
        .join(", ")
}

fn ended(outcome: &Outcome) -> String {
    let why = outcome.termination.name();
    let iterations = outcome.iterations;
    let work = outcome.work;
    let found = match outcome.stage {
        taut::optimize::Stage::Input => "nothing shorter found".to_owned(),
        stage => format!("found by {}", stage.name()),
    };
    format!("{why}, {found}, {iterations} iterations, {work} work")
}

//! Runs one problem in every mode, several times, and puts down what came of it.

use std::collections::BTreeMap;

use taut::collision::CollisionModel;
use taut::files::Peer;
use taut::optimize::{Mode, Outcome, Settings, Workspace};
use taut::robot::ConfigurationSpace;
use taut::translate::code_of;

use super::arguments::Arguments;
use super::curve::ratio;
use super::idle::Idle;
use super::loaded::Loaded;
use super::repeats::{self, Combined, Repeat};
use super::row::{Figures, PeerFigures, Row};
use super::run::{Timed, run};
use super::{meshes, refusal};
use crate::error::Error;

/// Runs longer than this are not repeated (s): their times are known well enough.
const LONG_S: f64 = 2.0;

/// Runs each mode and copies the figures of the peers.
pub(super) fn fill(
    row: &mut Row,
    arguments: &Arguments,
    loaded: &Loaded,
    workspace: &mut Workspace,
) {
    row.geometry = loaded.geometry_name();
    row.mesh_check = meshes::collisions(&loaded.mesh_check);
    let model = match loaded.model() {
        Ok(model) => model,
        Err(error) => return row.error = Some(error.to_string()),
    };
    for (mode, answer) in answers(arguments, loaded, &model, workspace) {
        take(row, mode, answer);
    }
    if let Some(before) = row.length_before {
        add_peers(row, loaded, before);
    }
}

/// What came of one mode, or why nothing did.
fn take(row: &mut Row, mode: Mode, answer: Answer) {
    match answer {
        Ok((outcome, figures)) => {
            row.length_before = Some(outcome.length_before);
            row.lower_bound = Some(outcome.lower_bound);
            row.answers.insert(mode.name(), figures);
        }
        Err(error) => {
            row.error
                .get_or_insert_with(|| format!("{}: {error}", mode.name()));
        }
    }
}

/// The recorded answers, relative to the length of the path given.
fn add_peers(row: &mut Row, loaded: &Loaded, before: f64) {
    for (name, peer) in &loaded.peers {
        row.peers
            .insert(name.clone(), relative(peer, before));
    }
    let best = loaded.best_honest_peer.as_ref();
    row.best_honest_peer = best.map(|(name, peer)| {
        let figures = PeerFigures {
            // Recorded as the best only because every check found it valid.
            honest: true,
            ..relative(peer, before)
        };
        (name.clone(), figures)
    });
    row.compare();
}

fn relative(peer: &Peer, before: f64) -> PeerFigures {
    PeerFigures {
        ratio: ratio(peer.length, before),
        cpu_s: peer.cpu_s,
        honest: peer.honest,
    }
}

type Answer = Result<(Outcome, Figures), String>;

/// Turn by turn through the modes, so that whatever else the machine does falls on all alike.
fn answers(
    arguments: &Arguments,
    loaded: &Loaded,
    model: &CollisionModel,
    workspace: &mut Workspace,
) -> Vec<(Mode, Answer)> {
    let runs = |mode| Runs::new(arguments, loaded, mode);
    let mut all: Vec<Runs> = arguments
        .modes()
        .into_iter()
        .map(runs)
        .collect();
    for _ in 0..arguments.repeat {
        for runs in &mut all {
            runs.once(model, workspace);
        }
    }
    all.into_iter()
        .map(|runs| (runs.mode, runs.answer()))
        .collect()
}

/// The runs of one mode on one problem.
struct Runs<'a> {
    arguments: &'a Arguments,
    loaded: &'a Loaded,
    mode: Mode,
    settings: Result<Settings, Error>,
    timed: Vec<Timed>,
}

impl<'a> Runs<'a> {
    fn new(arguments: &'a Arguments, loaded: &'a Loaded, mode: Mode) -> Self {
        let nv = loaded.robot.space().nv();
        let metric = loaded.weights.as_ref();
        Self {
            arguments,
            loaded,
            mode,
            settings: arguments
                .rules
                .settings(mode, metric, nv)
                .map(|settings| Settings {
                    constraints: loaded.constraints.clone(),
                    ..settings
                }),
            timed: Vec::new(),
        }
    }

    /// One more run, unless the first was long.
    fn once(&mut self, model: &CollisionModel, workspace: &mut Workspace) {
        let Ok(settings) = &self.settings else { return };
        let mut earlier = self.timed.iter();
        if earlier
            .next()
            .is_some_and(|first| first.time_s > LONG_S)
        {
            return;
        }
        let deadline = self.arguments.rules.deadline;
        match run(self.loaded, model, settings, deadline, workspace) {
            Ok(timed) => self.timed.push(timed),
            Err(error) => self.settings = Err(error),
        }
    }

    fn answer(mut self) -> Answer {
        if let Err(error) = &self.settings {
            return Err(error.to_string());
        }
        let repeats: Vec<Repeat> = self.timed.iter().map(repeat).collect();
        let combined = match self.arguments.rules.deadline {
            None => repeats::alike(&repeats)?,
            Some(_) => repeats::middle(&repeats),
        };
        let outcome = self.timed.swap_remove(combined.run).outcome;
        let figures = figures(self.arguments, self.loaded, &outcome, combined);
        Ok((outcome, figures))
    }
}

fn repeat(timed: &Timed) -> Repeat {
    Repeat {
        hash: timed.outcome.path.hash(),
        curve: timed.curve.clone(),
        cpu_s: timed.cpu_s,
        time_s: timed.time_s,
    }
}

fn figures(
    arguments: &Arguments,
    loaded: &Loaded,
    outcome: &Outcome,
    combined: Combined,
) -> Figures {
    let space = space(arguments, loaded);
    let idle = Idle::of(&space, &loaded.path);
    let remaining = |at: &std::time::Duration| combined.curve.remaining(at.as_secs_f64());
    Figures {
        proved: outcome.proved,
        code: code_of(outcome, None, None).name(),
        ratio: ratio(outcome.length_after, outcome.length_before),
        length: outcome.length_after,
        runs: combined.runs,
        cpu_s: combined.cpu_s,
        time_s: combined.time_s,
        first_improvement_s: combined.curve.first_s(),
        ratio_at: arguments.at.iter().map(remaining).collect(),
        curve: combined.curve,
        over_best_honest_peer: BTreeMap::new(),
        idle_travel_before: idle.travel(&loaded.path),
        idle_travel: idle.travel(&outcome.path),
        path_hash: format!("{:016x}", outcome.path.hash()),
        floor_m: outcome.floor_m,
        floors_lowered: outcome.floors_lowered.len(),
        iterations: outcome.iterations,
        work: outcome.work,
        termination: outcome.termination.name(),
        refusal: refusal::line(outcome),
    }
}

/// Of the columns as the runs took them.
fn space(arguments: &Arguments, loaded: &Loaded) -> ConfigurationSpace {
    match arguments.rules.unwrapped {
        true => loaded.robot.space().unwrapped(),
        false => loaded.robot.space().clone(),
    }
}

//! Runs one problem in every mode, several times, and puts down what came of it.

use std::collections::BTreeMap;

use taut::collision::CollisionModel;
use taut::files::Peer;
use taut::optimize::{Mode, Settings, Workspace};

use super::Arguments;
use super::curve::{Curve, ratio};
use super::idle::Idle;
use super::meshes;
use super::repeats::{self, Combined, Repeat};
use super::row::{Figures, PeerFigures, Row};
use super::run as runner;
use crate::cli::answered::Answered as Timed;
use crate::cli::error::CliError;
use crate::cli::load::Loaded;
use crate::cli::report::verdict;

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
        match answer {
            Ok((timed, figures)) => {
                row.length_before = Some(timed.outcome.length_before);
                row.lower_bound = Some(timed.outcome.lower_bound);
                row.answers.insert(mode.name(), figures);
            }
            Err(error) => {
                _ = row
                    .error
                    .get_or_insert_with(|| format!("{}: {error}", mode.name()))
            }
        }
    }
    let Some(before) = row.length_before else {
        return;
    };
    let relative = |peer: &Peer| PeerFigures {
        ratio: ratio(peer.length, before),
        cpu_s: peer.cpu_s,
        honest: peer.honest,
    };
    row.peers = loaded
        .peers
        .iter()
        .map(|(name, peer)| (name.clone(), relative(peer)))
        .collect();
    // Recorded as the best only because every check found it valid.
    let best = loaded.best_honest_peer.as_ref();
    row.best_honest_peer = best.map(|(name, peer)| {
        (
            name.clone(),
            PeerFigures {
                honest: true,
                ..relative(peer)
            },
        )
    });
    row.compare();
}

type Answer = Result<(Timed, Figures), String>;

/// Turn by turn through the modes, so that whatever else the machine does falls on all alike.
fn answers(
    arguments: &Arguments,
    loaded: &Loaded,
    model: &CollisionModel,
    workspace: &mut Workspace,
) -> Vec<(Mode, Answer)> {
    let mut all: Vec<Runs> = arguments
        .modes()
        .into_iter()
        .map(|mode| Runs::new(arguments, loaded, mode))
        .collect();
    for _ in 0..arguments.repeat {
        for runs in &mut all {
            runs.once(arguments, loaded, model, workspace);
        }
    }
    all.into_iter()
        .map(|runs| (runs.mode, runs.answer(arguments, loaded)))
        .collect()
}

/// The runs of one mode on one problem.
struct Runs {
    mode: Mode,
    settings: Result<Settings, CliError>,
    timed: Vec<Timed>,
    repeats: Vec<Repeat>,
}

impl Runs {
    fn new(arguments: &Arguments, loaded: &Loaded, mode: Mode) -> Self {
        let nv = loaded.robot.space().nv();
        let settings = arguments
            .rules
            .settings(mode, loaded.weights.as_ref(), nv)
            .map_err(CliError::Usage);
        Self {
            mode,
            settings,
            timed: Vec::new(),
            repeats: Vec::new(),
        }
    }

    /// One more run, unless the first was long.
    fn once(
        &mut self,
        arguments: &Arguments,
        loaded: &Loaded,
        model: &CollisionModel,
        workspace: &mut Workspace,
    ) {
        let Ok(settings) = &self.settings else { return };
        if self
            .repeats
            .first()
            .is_some_and(|first| first.time_s > LONG_S)
        {
            return;
        }
        let mut curve = Curve::new(f64::NAN);
        let mut watch =
            |time: std::time::Duration, length: f64| curve.push(time.as_secs_f64(), length);
        match runner::run(
            loaded,
            model,
            settings,
            arguments.rules.deadline,
            workspace,
            &mut watch,
        ) {
            Ok(timed) => {
                curve.close(
                    timed.outcome.length_before,
                    timed.outcome.length_after,
                    timed.time_s,
                );
                let hash = timed.outcome.path.hash();
                self.repeats.push(Repeat {
                    hash,
                    curve,
                    cpu_s: timed.cpu_s,
                    time_s: timed.time_s,
                });
                self.timed.push(timed);
            }
            Err(error) => self.settings = Err(error),
        }
    }

    fn answer(mut self, arguments: &Arguments, loaded: &Loaded) -> Answer {
        self.settings.map_err(|error| error.to_string())?;
        let combined = match arguments.rules.deadline {
            None => repeats::alike(&self.repeats)?,
            Some(_) => repeats::middle(&self.repeats),
        };
        let timed = self.timed.swap_remove(combined.run);
        let figures = figures(arguments, loaded, &timed, combined);
        Ok((timed, figures))
    }
}

fn figures(arguments: &Arguments, loaded: &Loaded, timed: &Timed, combined: Combined) -> Figures {
    let outcome = &timed.outcome;
    let space = match arguments.rules.unwrapped {
        true => loaded.robot.space().unwrapped(),
        false => loaded.robot.space().clone(),
    };
    let idle = Idle::of(&space, &loaded.path);
    Figures {
        proved: outcome.proved,
        code: timed.code.name(),
        ratio: ratio(outcome.length_after, outcome.length_before),
        length: outcome.length_after,
        runs: combined.runs,
        cpu_s: combined.cpu_s,
        time_s: combined.time_s,
        first_improvement_s: combined.curve.first_s(),
        ratio_at: arguments
            .at
            .iter()
            .map(|budget| combined.curve.remaining(budget.as_secs_f64()))
            .collect(),
        curve: combined.curve,
        over_best_honest_peer: BTreeMap::new(),
        idle_travel_before: idle.travel(&loaded.path),
        idle_travel: idle.travel(&outcome.path),
        path_hash: format!("{:016x}", timed.outcome.path.hash()),
        floor_m: outcome.floor_m,
        floors_lowered: outcome.floors_lowered.len(),
        iterations: outcome.iterations,
        work: outcome.work,
        termination: outcome.termination.name(),
        refusal: outcome.refusal.is_some().then(|| verdict(timed)),
    }
}

//! What the rows of a set, or of several sets, amount to.
//!
//! An answer that is not proved is the path given, so it counts with the length 1 everywhere.

use std::collections::BTreeMap;

use serde::Serialize;

use super::meshes::Meshes;
use super::moment::{AGAINST_ANY, AGAINST_BEST};
use super::row::{Figures, PeerFigures, Row};
use super::statistics::{Average, Tally, Worst, mean, median};

/// Figures of a set or of several.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    /// Its name.
    pub set: String,
    /// Its problems, those that could not be run included.
    pub problems: usize,
    /// Median of the distance of the ends, as a part of the length.
    pub lower_bound: Option<f64>,
    /// Ours by mode.
    pub modes: BTreeMap<&'static str, ModeSummary>,
    /// Recorded peers by name.
    pub peers: BTreeMap<String, PeerSummary>,
    /// The best honest peer of each path, taken together.
    pub best_honest_peer: Option<PeerSummary>,
    /// Checks with the exact meshes, where recorded.
    pub mesh_check: Option<Meshes>,
}

/// One mode on a set.
#[derive(Debug, Serialize)]
pub(super) struct ModeSummary {
    /// Answers.
    pub answers: usize,
    /// Proved ones among them.
    pub valid: usize,
    /// Median of the remaining length.
    pub ratio: f64,
    /// Its mean.
    pub ratio_mean: f64,
    /// The same of the proved answers alone.
    pub ratio_proved: Option<Average>,
    /// Remaining length at each of the report's budgets.
    pub ratio_at: Vec<Average>,
    /// Median CPU time (s).
    pub cpu_s: f64,
    /// Median time of the first improvement, where there is one (s).
    pub first_improvement_s: Option<f64>,
    /// How far above the best of the other modes, at each budget and at the end.
    pub above_other_modes: Vec<Above>,
    /// Ours ÷ the best honest peer's of each path, by moment.
    pub over_best_honest_peer: BTreeMap<&'static str, Versus>,
    /// Travel of coordinates that end where they start; `None` where the paths given have none.
    pub idle: Option<IdleSummary>,
}

/// How far a mode is above the best other mode at the same time; negative is below.
#[derive(Debug, Serialize)]
pub(super) struct Above {
    /// Of the modes' medians (%).
    pub medians_percent: Option<f64>,
    /// Median over the paths, each against the mode that is best there (%).
    pub paths_percent: Option<f64>,
}

/// Lengths of ours ÷ those of another, path by path.
#[derive(Debug, Serialize)]
pub(super) struct Versus {
    /// The middle quotient.
    pub median: f64,
    /// The largest.
    pub worst: Worst,
    /// Who is shorter how often.
    #[serde(flatten)]
    pub tally: Tally,
}

/// Travel of coordinates that end where they start (plain rad and m).
#[derive(Debug, Serialize)]
pub(super) struct IdleSummary {
    /// Paths whose idle coordinates move.
    pub paths: usize,
    /// Median travel in the paths given.
    pub before: f64,
    /// In the answers.
    pub after: f64,
    /// Most in an answer.
    pub worst: Worst,
}

/// One peer on a set.
#[derive(Debug, Serialize)]
pub(super) struct PeerSummary {
    /// Its recorded answers.
    pub answers: usize,
    /// Honest ones among them.
    pub valid: usize,
    /// Median of the remaining length.
    pub ratio: f64,
    /// Its mean.
    pub ratio_mean: f64,
    /// Median CPU time (s).
    pub cpu_s: f64,
    /// Ours against it, by mode and moment.
    pub ours: BTreeMap<&'static str, BTreeMap<&'static str, Tally>>,
}

impl Summary {
    /// Of rows, for modes at so many budgets.
    pub(super) fn of(set: &str, rows: &[&Row], modes: &[&'static str], budgets: usize) -> Self {
        let lower_bounds = rows.iter().filter_map(|row| Some(row.lower_bound? / row.length_before?));
        let mut names: Vec<&String> = rows.iter().flat_map(|row| row.peers.keys()).collect();
        names.sort();
        names.dedup();
        let peer = |name: &&String| Some(((*name).clone(), PeerSummary::of(rows, modes, |row| row.peers.get(*name))?));
        Self {
            set: set.to_owned(),
            problems: rows.len(),
            lower_bound: median(lower_bounds),
            modes: modes
                .iter()
                .filter_map(|mode| Some((*mode, ModeSummary::of(rows, mode, modes, budgets)?)))
                .collect(),
            peers: names.iter().filter_map(peer).collect(),
            best_honest_peer: PeerSummary::of(rows, modes, |row| row.best_honest_peer.as_ref().map(|best| &best.1)),
            mesh_check: Meshes::of(rows, modes),
        }
    }
}

impl ModeSummary {
    fn of(rows: &[&Row], mode: &str, modes: &[&str], budgets: usize) -> Option<Self> {
        let answers: Vec<(&Row, &Figures)> =
            rows.iter().filter_map(|row| Some((*row, row.answers.get(mode)?))).collect();
        let figures = || answers.iter().map(|answer| answer.1);
        let at = |budget: usize| Average::of(figures().map(move |figures| remaining(figures, budget)));
        let ratios = at(budgets)?;
        let versus = AGAINST_BEST.map(|moment| {
            let name = moment.name();
            let quotient = |(row, f): &(&Row, &Figures)| Some((*f.over_best_honest_peer.get(name)?, row.label()));
            Some((name, Versus::of(answers.iter().filter_map(quotient).collect())?))
        });
        Some(Self {
            answers: answers.len(),
            valid: figures().filter(|figures| figures.proved).count(),
            ratio: ratios.median,
            ratio_mean: ratios.mean,
            ratio_proved: Average::of(figures().filter(|figures| figures.proved).map(|figures| figures.ratio)),
            ratio_at: (0..budgets).filter_map(at).collect(),
            cpu_s: median(figures().map(|figures| figures.cpu_s))?,
            first_improvement_s: median(figures().filter_map(|figures| figures.first_improvement_s)),
            above_other_modes: (0..=budgets).map(|budget| Above::of(rows, mode, modes, budget)).collect(),
            over_best_honest_peer: versus.into_iter().flatten().collect(),
            idle: IdleSummary::of(&answers),
        })
    }
}

/// Remaining length at a budget; the one after the last is the end.
fn remaining(figures: &Figures, budget: usize) -> f64 {
    figures.ratio_at.get(budget).copied().unwrap_or(figures.ratio)
}

impl Above {
    fn of(rows: &[&Row], mode: &str, modes: &[&str], budget: usize) -> Self {
        let percent = |ours: f64, best: f64| 100.0 * (ours / best - 1.0);
        let length = |row: &Row, mode: &str| row.answers.get(mode).map(|figures| remaining(figures, budget));
        let of_mode = |mode: &str| median(rows.iter().filter_map(|row| length(row, mode)));
        let others = || modes.iter().filter(|other| **other != mode);
        let of_path = |row: &&Row| {
            let best = others().filter_map(|other| length(row, other)).min_by(f64::total_cmp)?;
            Some(percent(length(row, mode)?, best))
        };
        let best = others().filter_map(|other| of_mode(other)).min_by(f64::total_cmp);
        Self {
            medians_percent: of_mode(mode).zip(best).map(|(ours, best)| percent(ours, best)),
            paths_percent: median(rows.iter().filter_map(of_path)),
        }
    }
}

impl Versus {
    fn of(quotients: Vec<(f64, String)>) -> Option<Self> {
        let values = || quotients.iter().map(|quotient| quotient.0);
        let (median, tally) = (median(values())?, Tally::of(values()));
        Some(Self { median, tally, worst: Worst::of(quotients.into_iter())? })
    }
}

impl IdleSummary {
    fn of(answers: &[(&Row, &Figures)]) -> Option<Self> {
        /// Less is rounding (rad or m).
        const MOVES: f64 = 1e-9;
        let moving: Vec<_> = answers.iter().filter(|(_, figures)| figures.idle_travel_before > MOVES).collect();
        Some(Self {
            paths: moving.len(),
            before: median(moving.iter().map(|(_, figures)| figures.idle_travel_before))?,
            after: median(moving.iter().map(|(_, figures)| figures.idle_travel))?,
            worst: Worst::of(moving.iter().map(|(row, figures)| (figures.idle_travel, row.label())))?,
        })
    }
}

impl PeerSummary {
    /// Of the answer that `of` finds in a row.
    fn of<'a>(
        rows: &[&'a Row],
        modes: &[&'static str],
        of: impl Fn(&'a Row) -> Option<&'a PeerFigures>,
    ) -> Option<Self> {
        let answers: Vec<(&Row, &PeerFigures)> = rows.iter().filter_map(|row| Some((*row, of(row)?))).collect();
        let peers = || answers.iter().map(|answer| answer.1);
        let against = |mode: &'static str| {
            let tally = AGAINST_ANY.map(|moment| {
                let quotient = |(row, peer): &(&Row, &PeerFigures)| Some(row.answers.get(mode)?.over(peer, moment));
                (moment.name(), Tally::of(answers.iter().filter_map(quotient)))
            });
            (mode, tally.into())
        };
        Some(Self {
            answers: answers.len(),
            valid: peers().filter(|peer| peer.honest).count(),
            ratio: median(peers().map(|peer| peer.ratio))?,
            ratio_mean: mean(peers().map(|peer| peer.ratio))?,
            cpu_s: median(peers().map(|peer| peer.cpu_s))?,
            ours: modes.iter().copied().map(against).collect(),
        })
    }
}

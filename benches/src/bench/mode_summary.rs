//! What one mode made of a set.

use std::collections::BTreeMap;

use serde::Serialize;

use super::moment::AGAINST_BEST;
use super::row::{Figures, Row};
use crate::statistics::{Average, Tally, Worst, median};

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

impl ModeSummary {
    /// Of its answers among the rows; `None` where there are none.
    pub(super) fn of(rows: &[&Row], mode: &str, modes: &[&str], budgets: usize) -> Option<Self> {
        let answers: Vec<(&Row, &Figures)> = rows
            .iter()
            .filter_map(|row| Some((*row, row.answers.get(mode)?)))
            .collect();
        let figures = || answers.iter().map(|answer| answer.1);
        let at =
            |budget: usize| Average::of(figures().map(move |figures| remaining(figures, budget)));
        let ratios = at(budgets)?;
        let versus = AGAINST_BEST.map(|moment| {
            let name = moment.name();
            let quotient = |(row, f): &(&Row, &Figures)| {
                Some((*f.over_best_honest_peer.get(name)?, row.label()))
            };
            Some((
                name,
                Versus::of(answers.iter().filter_map(quotient).collect())?,
            ))
        });
        Some(Self {
            answers: answers.len(),
            valid: figures().filter(|figures| figures.proved).count(),
            ratio: ratios.median,
            ratio_mean: ratios.mean,
            ratio_proved: Average::of(
                figures()
                    .filter(|figures| figures.proved)
                    .map(|figures| figures.ratio),
            ),
            ratio_at: (0..budgets).filter_map(at).collect(),
            cpu_s: median(figures().map(|figures| figures.cpu_s))?,
            first_improvement_s: median(
                figures().filter_map(|figures| figures.first_improvement_s),
            ),
            above_other_modes: (0..=budgets)
                .map(|budget| Above::of(rows, mode, modes, budget))
                .collect(),
            over_best_honest_peer: versus.into_iter().flatten().collect(),
            idle: IdleSummary::of(&answers),
        })
    }
}

/// Remaining length at a budget; the one after the last is the end.
fn remaining(figures: &Figures, budget: usize) -> f64 {
    figures
        .ratio_at
        .get(budget)
        .copied()
        .unwrap_or(figures.ratio)
}

impl Above {
    fn of(rows: &[&Row], mode: &str, modes: &[&str], budget: usize) -> Self {
        let percent = |ours: f64, best: f64| 100.0 * (ours / best - 1.0);
        let length = |row: &Row, mode: &str| {
            row.answers
                .get(mode)
                .map(|figures| remaining(figures, budget))
        };
        let of_mode = |mode: &str| median(rows.iter().filter_map(|row| length(row, mode)));
        let others = || modes.iter().filter(|other| **other != mode);
        let of_path = |row: &&Row| {
            let best = others()
                .filter_map(|other| length(row, other))
                .min_by(f64::total_cmp)?;
            Some(percent(length(row, mode)?, best))
        };
        let best = others()
            .filter_map(|other| of_mode(other))
            .min_by(f64::total_cmp);
        Self {
            medians_percent: of_mode(mode)
                .zip(best)
                .map(|(ours, best)| percent(ours, best)),
            paths_percent: median(rows.iter().filter_map(of_path)),
        }
    }
}

impl Versus {
    fn of(quotients: Vec<(f64, String)>) -> Option<Self> {
        let values = || quotients.iter().map(|quotient| quotient.0);
        let median = median(values())?;
        let tally = Tally::of(values());
        Some(Self {
            median,
            tally,
            worst: Worst::of(quotients.into_iter())?,
        })
    }
}

impl IdleSummary {
    fn of(answers: &[(&Row, &Figures)]) -> Option<Self> {
        /// Less is rounding (rad or m).
        const MOVES: f64 = 1e-9;
        let moving: Vec<_> = answers
            .iter()
            .filter(|(_, figures)| figures.idle_travel_before > MOVES)
            .collect();
        Some(Self {
            paths: moving.len(),
            before: median(moving.iter().map(|(_, figures)| figures.idle_travel_before))?,
            after: median(moving.iter().map(|(_, figures)| figures.idle_travel))?,
            worst: Worst::of(
                moving
                    .iter()
                    .map(|(row, figures)| (figures.idle_travel, row.label())),
            )?,
        })
    }
}

//! What one mode made of a set.

use std::collections::BTreeMap;

use serde::Serialize;

use super::moment::{AGAINST_BEST, Moment};
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
        let answers = Answers::of(rows, mode);
        let ratios = answers.at(budgets)?;
        let above = |budget| Above::of(rows, mode, modes, budget);
        Some(Self {
            answers: answers.0.len(),
            valid: answers.proved().count(),
            ratio: ratios.median,
            ratio_mean: ratios.mean,
            ratio_proved: Average::of(answers.proved().map(|figures| figures.ratio)),
            ratio_at: (0..budgets)
                .filter_map(|at| answers.at(at))
                .collect(),
            cpu_s: median(answers.figures().map(|figures| figures.cpu_s))?,
            first_improvement_s: answers.first_improvement_s(),
            above_other_modes: (0..=budgets).map(above).collect(),
            over_best_honest_peer: answers.over_best_honest_peer(),
            idle: IdleSummary::of(&answers),
        })
    }
}

/// A mode's answers, each with its problem.
struct Answers<'a>(Vec<(&'a Row, &'a Figures)>);

impl<'a> Answers<'a> {
    fn of(rows: &[&'a Row], mode: &str) -> Self {
        let answer = |row: &&'a Row| Some((*row, row.answers.get(mode)?));
        Self(rows.iter().filter_map(answer).collect())
    }

    fn figures(&self) -> impl Iterator<Item = &'a Figures> + Clone {
        self.0.iter().map(|answer| answer.1)
    }

    fn proved(&self) -> impl Iterator<Item = &'a Figures> + Clone {
        self.figures().filter(|figures| figures.proved)
    }

    /// Remaining length at a budget.
    fn at(&self, budget: usize) -> Option<Average> {
        Average::of(
            self.figures()
                .map(move |figures| remaining(figures, budget)),
        )
    }

    fn first_improvement_s(&self) -> Option<f64> {
        median(
            self.figures()
                .filter_map(|figures| figures.first_improvement_s),
        )
    }

    fn over_best_honest_peer(&self) -> BTreeMap<&'static str, Versus> {
        let versus = |moment: Moment| Some((moment.name(), self.versus(moment)?));
        AGAINST_BEST
            .into_iter()
            .filter_map(versus)
            .collect()
    }

    fn versus(&self, moment: Moment) -> Option<Versus> {
        let quotient = |(row, figures): &(&Row, &Figures)| {
            let over = figures
                .over_best_honest_peer
                .get(moment.name())?;
            Some((*over, row.label()))
        };
        Versus::of(self.0.iter().filter_map(quotient).collect())
    }

    /// Those whose idle coordinates move in the path given.
    fn idle(&self) -> Vec<(&'a Row, &'a Figures)> {
        /// Less is rounding (rad or m).
        const MOVES: f64 = 1e-9;
        let mut moving = self.0.clone();
        moving.retain(|(_, figures)| figures.idle_travel_before > MOVES);
        moving
    }
}

/// Remaining length at a budget; the one after the last is the end.
fn remaining(figures: &Figures, budget: usize) -> f64 {
    let at = figures.ratio_at.get(budget);
    at.copied().unwrap_or(figures.ratio)
}

/// The same of a mode's answer to one problem.
fn remaining_of(row: &Row, mode: &str, budget: usize) -> Option<f64> {
    Some(remaining(row.answers.get(mode)?, budget))
}

/// The median over all problems.
fn median_of(rows: &[&Row], mode: &str, budget: usize) -> Option<f64> {
    median(
        rows.iter()
            .filter_map(|row| remaining_of(row, mode, budget)),
    )
}

impl Above {
    fn of(rows: &[&Row], mode: &str, modes: &[&str], budget: usize) -> Self {
        let others: Vec<&str> = modes
            .iter()
            .copied()
            .filter(|other| *other != mode)
            .collect();
        let of_medians = |mode: &str| median_of(rows, mode, budget);
        let of_path =
            |row: &&Row| above_percent(mode, &others, |mode| remaining_of(row, mode, budget));
        Self {
            medians_percent: above_percent(mode, &others, of_medians),
            paths_percent: median(rows.iter().filter_map(of_path)),
        }
    }
}

/// How far a mode's length is above the best of the others (%).
fn above_percent(mode: &str, others: &[&str], length: impl Fn(&str) -> Option<f64>) -> Option<f64> {
    let lengths = others.iter().filter_map(|other| length(other));
    let best = lengths.min_by(f64::total_cmp)?;
    Some(100.0 * (length(mode)? / best - 1.0))
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
    fn of(answers: &Answers) -> Option<Self> {
        let moving = answers.idle();
        let figures = || moving.iter().map(|answer| answer.1);
        let travels = moving
            .iter()
            .map(|(row, figures)| (figures.idle_travel, row.label()));
        Some(Self {
            paths: moving.len(),
            before: median(figures().map(|figures| figures.idle_travel_before))?,
            after: median(figures().map(|figures| figures.idle_travel))?,
            worst: Worst::of(travels)?,
        })
    }
}

//! What one peer made of a set, and how ours compares.

use std::collections::BTreeMap;

use serde::Serialize;

use super::moment::{AGAINST_ANY, Moment};
use super::row::{PeerFigures, Row};
use crate::statistics::{Tally, mean, median};

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

impl PeerSummary {
    /// Of the answer that `of` finds in a row; `None` where it finds none.
    pub(super) fn of<'a>(
        rows: &[&'a Row],
        modes: &[&'static str],
        of: impl Fn(&'a Row) -> Option<&'a PeerFigures>,
    ) -> Option<Self> {
        let answer = |row: &&'a Row| Some((*row, of(row)?));
        let answers: Vec<Answer> = rows.iter().filter_map(answer).collect();
        let peers = || answers.iter().map(|answer| answer.1);
        let against = |mode: &&'static str| (*mode, against(&answers, mode));
        Some(Self {
            answers: answers.len(),
            valid: peers().filter(|peer| peer.honest).count(),
            ratio: median(peers().map(|peer| peer.ratio))?,
            ratio_mean: mean(peers().map(|peer| peer.ratio))?,
            cpu_s: median(peers().map(|peer| peer.cpu_s))?,
            ours: modes.iter().map(against).collect(),
        })
    }
}

/// What a peer made of a problem.
type Answer<'a> = (&'a Row, &'a PeerFigures);

/// Ours against it, by moment.
fn against(answers: &[Answer], mode: &str) -> BTreeMap<&'static str, Tally> {
    let tally = |moment: Moment| {
        let quotient = |(row, peer): &Answer| Some(row.answers.get(mode)?.over(peer, moment));
        (
            moment.name(),
            Tally::of(answers.iter().filter_map(quotient)),
        )
    };
    AGAINST_ANY.map(tally).into()
}

//! The figures of `taut bench`: rows, medians of each set, and how both are shown.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use super::report::{length, time};

/// Peers whose medians stand beside ours wherever they are recorded.
const PEERS: [&str; 5] = [
    "hpp/GradientBased(port)+bounds",
    "hpp/RandomShortcut",
    "vamp/simplify",
    "ompl/simplifyMax",
    "sampled/dof_shortcut_1000",
];

/// One problem.
#[derive(Debug, Default, Serialize)]
pub(super) struct Row {
    /// Folder of the problem.
    pub set: String,
    /// File name without its ending.
    pub name: String,
    /// Which of the robot's models was taken.
    pub geometry: &'static str,
    /// Why the problem could not be read or run.
    pub error: Option<String>,
    /// Length of the planner's path.
    pub length_before: Option<f64>,
    /// Distance of its ends.
    pub lower_bound: Option<f64>,
    /// Our answers by mode.
    pub answers: BTreeMap<&'static str, Figures>,
    /// Recorded answers by name.
    pub peers: BTreeMap<String, PeerFigures>,
    /// The best recorded answer that is valid.
    pub best_honest_peer: Option<(String, PeerFigures)>,
}

/// One answer of ours.
#[derive(Debug, Serialize)]
pub(super) struct Figures {
    /// Whether the answer is proved.
    pub proved: bool,
    /// Code of the answer.
    pub code: &'static str,
    /// Remaining length, as a part of the planner's.
    pub ratio: f64,
    /// Remaining length.
    pub length: f64,
    /// CPU time (s).
    pub cpu_s: f64,
    /// Time on the clock (s).
    pub time_s: f64,
    /// Smallest floor of any pair (m).
    pub floor_m: f64,
    /// Pairs with a lowered floor.
    pub floors_lowered: usize,
    /// Iterations of the optimizer.
    pub iterations: u64,
    /// Pairs examined at nodes.
    pub work: u64,
    /// How the run ended.
    pub termination: &'static str,
    /// Why the input was refused.
    pub refusal: Option<String>,
}

/// A recorded answer, relative to the length of the planner's path.
#[derive(Clone, Debug, Serialize)]
pub(super) struct PeerFigures {
    /// Remaining length, as a part of the planner's.
    pub ratio: f64,
    /// CPU time (s).
    pub cpu_s: f64,
    /// Whether every check found it valid.
    pub honest: bool,
}

/// Medians of one optimizer on one set.
#[derive(Debug, Serialize)]
pub(super) struct Medians {
    /// Answers that count: proved ones of ours, all of a peer's.
    pub answers: usize,
    /// Answers that are proved, or honest.
    pub valid: usize,
    /// Median remaining length.
    pub ratio: f64,
    /// Median CPU time (s).
    pub cpu_s: f64,
}

/// Medians of one set.
#[derive(Debug, Serialize)]
pub(super) struct SetMedians {
    set: String,
    problems: usize,
    lower_bound: Option<f64>,
    modes: BTreeMap<&'static str, Medians>,
    peers: BTreeMap<String, Medians>,
}

/// All rows and their medians.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    rows: Vec<Row>,
    sets: Vec<SetMedians>,
    #[serde(skip)]
    modes: Vec<&'static str>,
}

impl Report {
    /// Takes the medians of the rows, for these modes in this order.
    pub(super) fn new(rows: Vec<Row>, modes: Vec<&'static str>) -> Self {
        let mut by_set: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
        for row in &rows {
            by_set.entry(&row.set).or_default().push(row);
        }
        let sets = by_set.into_iter().map(|(set, rows)| SetMedians::of(set, &rows, &modes)).collect();
        Self { sets, rows, modes }
    }

    /// Whether a problem could not be read or run.
    pub(super) fn has_errors(&self) -> bool {
        self.rows.iter().any(|row| row.error.is_some())
    }

    /// Rows and medians as JSON.
    pub(super) fn json(&self) -> String {
        serde_json::to_string(self).expect("a report holds only strings, booleans and numbers")
    }

    /// Rows and medians for people: remaining length and CPU time of each mode, beside the best honest peer.
    pub(super) fn table(&self) -> String {
        let mut text = String::new();
        let width = self.rows.iter().map(|row| row.set.len() + row.name.len() + 1).max().unwrap_or(0).max(7);
        let mut line = |first: &str, cells: &[String], last: &str| {
            let cells: String = cells.iter().map(|cell| format!("  {cell:<25}")).collect();
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{}", format!("{first:<width$}{cells}  {last}").trim_end());
        };
        let modes: Vec<String> = self.modes.iter().map(|mode| (*mode).to_owned()).collect();
        line("problem", &modes, "best honest peer");
        for row in &self.rows {
            let name = format!("{}/{}", row.set, row.name);
            let cells: Vec<String> = self.modes.iter().map(|mode| cell(row.answers.get(mode))).collect();
            let best = row.best_honest_peer.as_ref();
            let best = best.map(|(name, peer)| format!("{:.3} {:>9}  {name}", peer.ratio, time(peer.cpu_s)));
            line(&name, &cells, best.as_deref().unwrap_or(""));
        }
        for row in &self.rows {
            if let Some(error) = &row.error {
                let _ = writeln!(text, "{}/{}: {error}", row.set, row.name);
            }
            let refusals = row.answers.values().filter_map(|figures| figures.refusal.as_ref());
            if let Some(refusal) = refusals.min() {
                let _ = writeln!(text, "{}/{}: {refusal}", row.set, row.name);
            }
        }
        for set in &self.sets {
            set.write(&self.modes, &mut text);
        }
        text
    }
}

/// `0.571  1.23 ms`, or the code of an answer that is not proved; `*` marks lowered floors.
fn cell(figures: Option<&Figures>) -> String {
    match figures {
        None => "-".to_owned(),
        Some(figures) if !figures.proved => figures.code.to_owned(),
        Some(figures) => {
            let lowered =
                if figures.floors_lowered > 0 { format!(" *{}", length(figures.floor_m)) } else { String::new() };
            format!("{:.3} {:>9}{lowered}", figures.ratio, time(figures.cpu_s))
        }
    }
}

impl SetMedians {
    fn of(set: &str, rows: &[&Row], modes: &[&'static str]) -> Self {
        let lower_bounds = rows.iter().filter_map(|row| Some(row.lower_bound? / row.length_before?));
        let of_mode = |mode: &&'static str| {
            let answers: Vec<&Figures> = rows.iter().filter_map(|row| row.answers.get(mode)).collect();
            let proved = || answers.iter().filter(|figures| figures.proved);
            let (ratio, cpu_s) = (median(proved().map(|f| f.ratio))?, median(proved().map(|f| f.cpu_s))?);
            Some((*mode, Medians { answers: answers.len(), valid: proved().count(), ratio, cpu_s }))
        };
        let of_peer = |name: &str| {
            let peers: Vec<&PeerFigures> = rows.iter().filter_map(|row| row.peers.get(name)).collect();
            let (ratio, cpu_s) = (median(peers.iter().map(|p| p.ratio))?, median(peers.iter().map(|p| p.cpu_s))?);
            let valid = peers.iter().filter(|peer| peer.honest).count();
            Some((name.to_owned(), Medians { answers: peers.len(), valid, ratio, cpu_s }))
        };
        let mut peers: BTreeMap<String, Medians> = PEERS.into_iter().filter_map(of_peer).collect();
        let best: Vec<&PeerFigures> = rows.iter().filter_map(|r| Some(&r.best_honest_peer.as_ref()?.1)).collect();
        if let (Some(ratio), Some(cpu_s)) = (median(best.iter().map(|p| p.ratio)), median(best.iter().map(|p| p.cpu_s)))
        {
            let medians = Medians { answers: best.len(), valid: best.len(), ratio, cpu_s };
            peers.insert("best honest peer of each".to_owned(), medians);
        }
        Self {
            set: set.to_owned(),
            problems: rows.len(),
            lower_bound: median(lower_bounds),
            modes: modes.iter().filter_map(of_mode).collect(),
            peers,
        }
    }

    fn write(&self, modes: &[&'static str], text: &mut String) {
        let bound = self.lower_bound.map_or(String::new(), |bound| format!(", lower bound {bound:.3}"));
        let _ = writeln!(text, "\n{}: medians of {} problems{bound}", self.set, self.problems);
        let mut line = |name: &str, medians: &Medians, what: &str| {
            let Medians { answers, valid, ratio, cpu_s } = medians;
            let _ = writeln!(text, "  {name:<32} {ratio:.3} {:>9}  {valid} of {answers} {what}", time(*cpu_s));
        };
        for mode in modes {
            match self.modes.get(mode) {
                Some(medians) => line(mode, medians, "proved"),
                None => continue,
            }
        }
        for (name, medians) in &self.peers {
            line(name, medians, "honest");
        }
    }
}

/// The middle value, or the mean of the two middle ones.
pub(super) fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        count if count % 2 == 1 => Some(values[middle]),
        _ => Some((values[middle - 1] + values[middle]) / 2.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_count_is_the_mean_of_the_middle_two() {
        assert_eq!(median([3.0, 1.0, 2.0].into_iter()), Some(2.0));
        assert_eq!(median([4.0, 1.0, 2.0, 3.0].into_iter()), Some(2.5));
        assert_eq!(median(std::iter::empty()), None);
    }
}

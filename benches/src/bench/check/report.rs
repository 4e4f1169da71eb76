//! All that measuring the check found.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use super::figures::{Figures, or};
use crate::error::Error;
use crate::output;
use crate::statistics::median;

/// One problem.
#[derive(Debug, Serialize)]
pub(crate) struct Row {
    set: String,
    name: String,
    /// Why the problem could not be read or run.
    error: Option<String>,
    #[serde(flatten)]
    figures: Option<Figures>,
}

/// Medians of one set over the paths that are proved.
#[derive(Debug, Serialize)]
struct SetMedians {
    set: String,
    problems: usize,
    proved: usize,
    proof_s: Option<f64>,
    refusal_s: Option<f64>,
    sampled_s: Option<f64>,
    ratio: Option<f64>,
    worst_ratio: Option<f64>,
    /// Part of a run's tests that remembered proofs save.
    saved: Option<f64>,
    /// Time to prove the constraints over that of all else, and looks for each segment.
    constraints_ratio: Option<f64>,
    constraint_looks_a_segment: Option<f64>,
}

/// All rows and their medians.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    rows: Vec<Row>,
    sets: Vec<SetMedians>,
}

impl Row {
    /// What came of one problem.
    pub(crate) fn new(set: String, name: String, measured: Result<Figures, Error>) -> Self {
        let error = measured.as_ref().err().map(Error::to_string);
        Self {
            set,
            name,
            error,
            figures: measured.ok(),
        }
    }

    fn label(&self) -> String {
        format!("{}/{}", self.set, self.name)
    }

    fn cells(&self) -> String {
        match (&self.figures, &self.error) {
            (Some(figures), _) => figures.cells(),
            (None, error) => error.clone().unwrap_or_default(),
        }
    }
}

impl Report {
    /// Takes the medians of the rows.
    pub(crate) fn new(rows: Vec<Row>) -> Self {
        let mut by_set: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
        for row in &rows {
            by_set.entry(&row.set).or_default().push(row);
        }
        let sets = by_set
            .into_iter()
            .map(|(set, rows)| SetMedians::of(set, &rows))
            .collect();
        Self { sets, rows }
    }

    /// Whether a problem could not be read or run.
    pub(crate) fn has_errors(&self) -> bool {
        self.rows.iter().any(|row| row.error.is_some())
    }

    /// Rows and medians as JSON.
    pub(crate) fn json(&self) -> String {
        output::json(self)
    }

    /// Rows and medians for people.
    pub(crate) fn table(&self) -> String {
        let mut text = self.head();
        let width = self.width();
        for row in &self.rows {
            text += &format!("{:<width$}  {}\n", row.label(), row.cells());
        }
        for set in &self.sets {
            set.write(&mut text);
        }
        text
    }

    fn head(&self) -> String {
        let width = self.width();
        format!(
            "{:<width$}  waypoints     proof   refusal   sampled  ratio  intervals  tests far, near, exact   keeps\n",
            "problem"
        )
    }

    fn width(&self) -> usize {
        let labels = self.rows.iter().map(|row| row.label().len());
        labels.fold("problem".len(), usize::max)
    }
}

impl SetMedians {
    fn of(set: &str, rows: &[&Row]) -> Self {
        let all = || {
            rows.iter()
                .filter_map(|row| row.figures.as_ref())
        };
        let proved = || all().filter(|figures| figures.proved);
        let ratios = || proved().filter_map(|figures| figures.ratio);
        Self {
            set: set.to_owned(),
            problems: rows.len(),
            proved: proved().count(),
            proof_s: median(proved().map(|figures| figures.proof_s)),
            refusal_s: median(all().filter_map(|figures| figures.refusal_s)),
            sampled_s: median(proved().filter_map(|figures| figures.sampled_s)),
            ratio: median(ratios()),
            worst_ratio: ratios().max_by(f64::total_cmp),
            saved: median(proved().map(|figures| figures.saved())),
            constraints_ratio: median(proved().filter_map(Figures::constraints_ratio)),
            constraint_looks_a_segment: median(
                proved().filter_map(|figures| Some(figures.constraints?.looks_a_segment)),
            ),
        }
    }

    fn write(&self, text: &mut String) {
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "\n{}: {} of {} proved; medians of these\n  proof {}  refusal {}",
            self.set,
            self.proved,
            self.problems,
            or(self.proof_s, "-"),
            or(self.refusal_s, "-")
        );
        self.write_sampled(text);
        self.write_saved(text);
        self.write_constraints(text);
        let _ = writeln!(text);
    }

    fn write_sampled(&self, text: &mut String) {
        let (Some(ratio), Some(worst)) = (self.ratio, self.worst_ratio) else {
            return;
        };
        let sampled = or(self.sampled_s, "-");
        let _ = write!(
            text,
            "  sampled every 1/32 rad {sampled}  proof ÷ sampled {ratio:.2} (worst {worst:.2})"
        );
    }

    fn write_constraints(&self, text: &mut String) {
        let (Some(ratio), Some(looks)) = (self.constraints_ratio, self.constraint_looks_a_segment)
        else {
            return;
        };
        let _ = write!(
            text,
            "\n  constraints ÷ proof {ratio:.2}, {looks:.2} looks a segment"
        );
    }

    fn write_saved(&self, text: &mut String) {
        let Some(saved) = self.saved else { return };
        let _ = write!(
            text,
            "  remembered proofs save {:.0} % of a run's tests",
            100.0 * saved
        );
    }
}

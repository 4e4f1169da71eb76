//! The report for people: a row for each path, then what each set and each family of sets amounts
//! to.

use std::fmt::Write;

use super::grid::Grid;
use super::report::Report;
use super::row::{Figures, Row};
use super::sections::Sections;
use crate::units::time;

impl Report {
    /// The whole report.
    pub(super) fn table(&self) -> String {
        let mut text = self.head();
        self.rows(&mut text);
        self.remarks(&mut text);
        for summary in self.sets.iter().chain(&self.pooled) {
            Sections {
                report: self,
                summary,
            }
            .write(&mut text);
        }
        text
    }

    fn head(&self) -> String {
        let given = match &self.from {
            None => "the planner's path".to_owned(),
            Some(peer) if self.skipped == 0 => format!("the path of {peer}"),
            Some(peer) => format!(
                "the path of {peer}, which {} problems do not have and are left out",
                self.skipped
            ),
        };
        let runs = match (self.repeat, self.deadline_s) {
            (1, _) => "one run each".to_owned(),
            (count, None) => format!("{count} runs each, times are medians"),
            (count, Some(_)) => format!("{count} runs each, the one of median length counts"),
        };
        let deadline = self.deadline_s.map_or(String::new(), |deadline| {
            format!("; deadline {}", time(deadline))
        });
        let calibration = time(self.calibration_s);
        format!(
            "remaining length (1 = {given}) and CPU; {runs}{deadline}; calibration kernel {calibration}\n\n"
        )
    }

    fn rows(&self, text: &mut String) {
        let mut grid = Grid::new("<");
        let modes = self.modes.iter().map(|mode| (*mode).to_owned());
        let best = self
            .rows
            .iter()
            .any(|row| row.best_honest_peer.is_some())
            .then(|| "best honest peer".to_owned());
        grid.line(["problem".to_owned()].into_iter().chain(modes).chain(best));
        for row in &self.rows {
            let best = row.best_honest_peer.as_ref();
            let best = best
                .map(|(name, peer)| format!("{:.3} {:>9}  {name}", peer.ratio, time(peer.cpu_s)));
            let cells = self
                .modes
                .iter()
                .map(|mode| self.cell(row.answers.get(mode)));
            grid.line(
                [row.label()]
                    .into_iter()
                    .chain(cells)
                    .chain([best.unwrap_or_default()]),
            );
        }
        grid.write("", text);
    }

    /// `0.571  1.23 ms`, or why there is no proof.
    fn cell(&self, figures: Option<&Figures>) -> String {
        match figures {
            None => "-".to_owned(),
            // Where and why is said below.
            Some(figures) if figures.refusal.is_some() => "refused".to_owned(),
            Some(figures) if !figures.proved => figures.code.to_owned(),
            Some(figures) => {
                let lowered = if figures.floors_lowered > 0 { "*" } else { "" };
                let once = if figures.runs < self.repeat { "¹" } else { "" };
                format!(
                    "{:.3} {:>9}{lowered}{once}",
                    figures.ratio,
                    time(figures.cpu_s)
                )
            }
        }
    }

    /// What the marks mean, and what is wrong with which problem.
    fn remarks(&self, text: &mut String) {
        let any = |what: &dyn Fn(&Figures) -> bool| {
            self.rows.iter().any(|row| row.answers.values().any(what))
        };
        // Writing to a string cannot fail.
        if any(&|figures| figures.proved && figures.floors_lowered > 0) {
            let _ = writeln!(
                text,
                "* where the path given keeps less than the clearance, so does the answer"
            );
        }
        if any(&|figures| figures.proved && figures.runs < self.repeat) {
            let _ = writeln!(text, "¹ one long run");
        }
        for row in &self.rows {
            let refusals = row
                .answers
                .values()
                .filter_map(|figures| figures.refusal.as_ref());
            for reason in row.error.iter().chain(refusals.min()) {
                let _ = writeln!(text, "{}: {reason}", Row::label(row));
            }
        }
    }
}

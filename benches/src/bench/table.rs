//! The report for people: a row for each path, then what each set and each family of sets amounts
//! to.

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
        format!(
            "remaining length (1 = {}) and CPU; {}{}; calibration kernel {}\n\n",
            self.given(),
            self.runs(),
            self.deadline(),
            time(self.calibration_s)
        )
    }

    fn given(&self) -> String {
        match &self.from {
            None => "the planner's path".to_owned(),
            Some(peer) if self.skipped == 0 => format!("the path of {peer}"),
            Some(peer) => format!(
                "the path of {peer}, which {} problems do not have and are left out",
                self.skipped
            ),
        }
    }

    fn runs(&self) -> String {
        match (self.repeat, self.deadline_s) {
            (1, _) => "one run each".to_owned(),
            (count, None) => format!("{count} runs each, times are medians"),
            (count, Some(_)) => format!("{count} runs each, the one of median length counts"),
        }
    }

    fn deadline(&self) -> String {
        let deadline = self.deadline_s.map(time);
        deadline.map_or(String::new(), |deadline| format!("; deadline {deadline}"))
    }

    fn rows(&self, text: &mut String) {
        let mut grid = Grid::new("<");
        let mut head = vec!["problem"];
        head.extend(&self.modes);
        if self
            .rows
            .iter()
            .any(|row| row.best_honest_peer.is_some())
        {
            head.push("best honest peer");
        }
        grid.line(head);
        for row in &self.rows {
            grid.line(self.line(row));
        }
        grid.write("", text);
    }

    fn line(&self, row: &Row) -> Vec<String> {
        let mut cells = vec![row.label()];
        let answers = self
            .modes
            .iter()
            .map(|mode| row.answers.get(mode));
        cells.extend(answers.map(|figures| self.cell(figures)));
        cells.push(best(row));
        cells
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
        if self.any_proved(|figures| figures.floors_lowered > 0) {
            *text += "* where the path given keeps less than the clearance, so does the answer\n";
        }
        if self.any_proved(|figures| figures.runs < self.repeat) {
            *text += "¹ one long run\n";
        }
        for row in &self.rows {
            let refusals = row
                .answers
                .values()
                .filter_map(|one| one.refusal.as_ref());
            for reason in row.error.iter().chain(refusals.min()) {
                *text += &format!("{}: {reason}\n", row.label());
            }
        }
    }

    fn any_proved(&self, what: impl Fn(&Figures) -> bool) -> bool {
        let mut answers = self
            .rows
            .iter()
            .flat_map(|row| row.answers.values());
        answers.any(|figures| figures.proved && what(figures))
    }
}

/// The best honest peer of a problem.
fn best(row: &Row) -> String {
    match &row.best_honest_peer {
        None => String::new(),
        Some((name, peer)) => format!("{:.3} {:>9}  {name}", peer.ratio, time(peer.cpu_s)),
    }
}

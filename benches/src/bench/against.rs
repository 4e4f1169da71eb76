//! `--against`: every answer beside the one of an earlier run, to show that a change moved nothing.
//!
//! Paths, verdicts, codes, lengths and ends are the answer: they are equal in every bit, or the answer
//! is another. Counts of work are how it was found: they are told, and are no difference.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::row::{Figures, Row};
use crate::error::Error;

/// An earlier run's report, as far as it is compared.
#[derive(Debug, Deserialize)]
pub(super) struct Before {
    rows: Vec<Problem>,
}

#[derive(Debug, Deserialize)]
struct Problem {
    set: String,
    name: String,
    error: Option<String>,
    answers: BTreeMap<String, Answer>,
}

/// What is compared of an answer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
struct Answer {
    path_hash: String,
    proved: bool,
    code: String,
    length: f64,
    termination: String,
    iterations: u64,
    work: u64,
}

/// What differs.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Compared {
    /// Answers that both have.
    answers: usize,
    /// A line for each answer or problem that is another.
    different: Vec<String>,
    /// A line for each answer that only took other work.
    other_work: Vec<String>,
}

impl Before {
    /// Reads a report.
    ///
    /// # Errors
    /// A file that cannot be read or is no report.
    pub(super) fn read(file: &Path) -> Result<Self, Error> {
        let error = |reason: String| Error::Before {
            file: file.display().to_string(),
            reason,
        };
        let text = std::fs::read_to_string(file).map_err(|reason| error(reason.to_string()))?;
        serde_json::from_str(&text).map_err(|reason| error(reason.to_string()))
    }

    /// Compares every problem and mode of both.
    pub(super) fn compare(&self, now: &[Row]) -> Compared {
        let mut compared = Compared::default();
        let mut before: BTreeMap<String, &Problem> = self
            .rows
            .iter()
            .map(|row| (row.label(), row))
            .collect();
        for row in now {
            match before.remove(&row.label()) {
                Some(problem) => compared.problem(problem, row),
                None => compared.differs(&row.label(), "is new"),
            }
        }
        for label in before.keys() {
            compared.differs(label, "is gone");
        }
        compared
    }
}

impl Problem {
    fn label(&self) -> String {
        format!("{}/{}", self.set, self.name)
    }
}

impl Answer {
    fn of(figures: &Figures) -> Self {
        Self {
            path_hash: figures.path_hash.clone(),
            proved: figures.proved,
            code: figures.code.to_owned(),
            length: figures.length,
            termination: figures.termination.to_owned(),
            iterations: figures.iterations,
            work: figures.work,
        }
    }

    /// What is another in `now`, work left out; empty where nothing is.
    fn changes(&self, now: &Self) -> String {
        let changes = [
            change("path", &self.path_hash, &now.path_hash),
            change("proved", &self.proved, &now.proved),
            change("code", &self.code, &now.code),
            change("length", &self.length, &now.length),
            change("ended", &self.termination, &now.termination),
        ];
        joined(changes)
    }

    fn changes_of_work(&self, now: &Self) -> String {
        joined([
            change("iterations", &self.iterations, &now.iterations),
            change("work", &self.work, &now.work),
        ])
    }
}

fn change<T: PartialEq + std::fmt::Display>(what: &str, before: &T, now: &T) -> Option<String> {
    (before != now).then(|| format!("{what} {before} -> {now}"))
}

fn joined<const N: usize>(changes: [Option<String>; N]) -> String {
    let changes: Vec<String> = changes.into_iter().flatten().collect();
    changes.join(", ")
}

impl Compared {
    /// Whether anything but work differs.
    pub(super) fn is_different(&self) -> bool {
        !self.different.is_empty()
    }

    /// A line for each difference, and the counts.
    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        for line in self.different.iter().chain(&self.other_work) {
            text += line;
            text.push('\n');
        }
        text + &format!(
            "{} answers compared, {} different, {} with other work only\n",
            self.answers,
            self.different.len(),
            self.other_work.len()
        )
    }

    fn differs(&mut self, label: &str, what: &str) {
        self.different
            .push(format!("DIFFERENT {label}: {what}"));
    }

    fn problem(&mut self, before: &Problem, now: &Row) {
        let label = now.label();
        if before.error != now.error {
            let said = |error: &Option<String>| error.clone().unwrap_or("no error".to_owned());
            let errors = [&before.error, &now.error].map(said);
            self.differs(&label, &errors.join(" -> "));
        }
        for (mode, figures) in &now.answers {
            let label = format!("{label} {mode}");
            match before.answers.get(*mode) {
                Some(answer) => self.answer(&label, answer, &Answer::of(figures)),
                None => self.differs(&label, "is new"),
            }
        }
        let is_gone = |mode: &&String| !now.answers.contains_key(mode.as_str());
        for mode in before.answers.keys().filter(is_gone) {
            self.differs(&format!("{label} {mode}"), "is gone");
        }
    }

    fn answer(&mut self, label: &str, before: &Answer, now: &Answer) {
        self.answers += 1;
        let changes = before.changes(now);
        let work = before.changes_of_work(now);
        if !changes.is_empty() {
            self.differs(label, &changes);
        } else if !work.is_empty() {
            self.other_work
                .push(format!("other work {label}: {work}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::curve::Curve;
    use super::*;

    fn figures(path_hash: &str, work: u64) -> Figures {
        Figures {
            proved: true,
            code: "SUCCESS",
            ratio: 0.5,
            length: 0.1 + 0.2,
            runs: 1,
            cpu_s: 0.02,
            time_s: 0.02,
            first_improvement_s: None,
            ratio_at: Vec::new(),
            curve: Curve::new(1.0),
            over_best_honest_peer: BTreeMap::new(),
            idle_travel_before: 0.0,
            idle_travel: 0.0,
            path_hash: path_hash.to_owned(),
            floor_m: 1e-3,
            floors_lowered: 0,
            iterations: 3,
            work,
            termination: "converged",
            refusal: None,
        }
    }

    fn row(name: &str, answers: &[(&'static str, Figures)]) -> Row {
        let figures = |(mode, figures): &(&'static str, Figures)| {
            (*mode, self::figures(&figures.path_hash, figures.work))
        };
        Row {
            set: "set".to_owned(),
            name: name.to_owned(),
            answers: answers.iter().map(figures).collect(),
            ..Row::default()
        }
    }

    /// What a report of these rows is when it is read again.
    fn before(rows: &[Row]) -> Before {
        let text = serde_json::json!({ "calibration_s": 0.01, "rows": rows }).to_string();
        serde_json::from_str(&text).unwrap()
    }

    #[test]
    fn equal_reports_are_equal_and_another_time_is_no_difference() {
        let rows = [row("a", &[("gradient", figures("0a", 7))]), row("b", &[])];
        let mut again = row("a", &[("gradient", figures("0a", 7))]);
        again.answers.get_mut("gradient").unwrap().cpu_s = 1.0;
        let compared = before(&rows).compare(&[again, row("b", &[])]);
        assert!(!compared.is_different());
        assert_eq!(
            compared.text(),
            "1 answers compared, 0 different, 0 with other work only\n"
        );
    }

    #[test]
    fn another_path_is_a_difference_and_other_work_is_only_told() {
        let answers = |hash, work| {
            [
                ("contact", figures(hash, 7)),
                ("gradient", figures("0a", work)),
            ]
        };
        let earlier = before(&[row("a", &answers("0a", 7))]);
        let other_work = earlier.compare(&[row("a", &answers("0a", 8))]);
        assert!(!other_work.is_different());
        assert_eq!(
            other_work.other_work,
            ["other work set/a gradient: work 7 -> 8"]
        );
        let other_path = earlier.compare(&[row("a", &answers("0b", 8))]);
        assert!(other_path.is_different());
        assert_eq!(
            other_path.different,
            ["DIFFERENT set/a contact: path 0a -> 0b"]
        );
        assert_eq!((other_path.answers, other_path.other_work.len()), (2, 1));
    }

    #[test]
    fn every_part_of_an_answer_counts() {
        let earlier = before(&[row("a", &[("gradient", figures("0a", 7))])]);
        type Change = fn(&mut Figures);
        let changes: [(&str, Change); 4] = [
            ("proved true -> false", |figures| figures.proved = false),
            ("code SUCCESS -> TIMED_OUT", |figures| {
                figures.code = "TIMED_OUT"
            }),
            // One unit in the last place.
            ("length 0.30000000000000004 -> 0.3", |figures| {
                figures.length = 0.3
            }),
            ("ended converged -> stopped", |figures| {
                figures.termination = "stopped"
            }),
        ];
        for (what, change) in changes {
            let mut now = row("a", &[("gradient", figures("0a", 7))]);
            change(now.answers.get_mut("gradient").unwrap());
            let different = earlier.compare(&[now]).different;
            assert_eq!(different, [format!("DIFFERENT set/a gradient: {what}")]);
        }
    }

    #[test]
    fn what_only_one_of_them_has_is_a_difference() {
        let earlier = before(&[
            row("gone", &[]),
            row("mode", &[("contact", figures("0a", 7))]),
        ]);
        let mut failed = row("mode", &[("gradient", figures("0a", 7))]);
        failed.error = Some("no".to_owned());
        let compared = earlier.compare(&[row("new", &[]), failed]);
        assert_eq!(
            compared.different,
            [
                "DIFFERENT set/new: is new",
                "DIFFERENT set/mode: no error -> no",
                "DIFFERENT set/mode gradient: is new",
                "DIFFERENT set/mode contact: is gone",
                "DIFFERENT set/gone: is gone",
            ]
        );
    }
}

//! One line of the table: a figure, what is promised of it, and what was measured.

use serde::Serialize;

use crate::load::tally::Tally;
use crate::units;

/// The line above the rows.
pub(super) fn head() -> String {
    line("promise", "figure", "promised", "measured", "")
}

fn line(promise: &str, figure: &str, promised: &str, measured: &str, verdict: &str) -> String {
    let text = format!("{promise:<12} {figure:<66} {promised:<12} {measured:<22} {verdict}");
    text.trim_end().to_owned()
        + "
"
}

/// A figure.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    /// Name of the promise.
    pub promise: &'static str,
    /// What was measured.
    pub figure: String,
    /// What is promised.
    pub promised: String,
    /// What it was.
    pub measured: String,
    /// The same as a number.
    pub value: f64,
    /// Whether the promise is kept.
    pub kept: bool,
    /// Whether no noise of the machine can change it.
    pub certain: bool,
    /// Whether it decides in this form.
    pub judged: bool,
    /// Whether anything is promised of it.
    pub is_promise: bool,
}

impl Row {
    fn new(
        figure: impl Into<String>,
        promised: String,
        measured: String,
        value: f64,
        kept: bool,
    ) -> Self {
        let figure = figure.into();
        Self {
            promise: "",
            figure,
            promised,
            measured,
            value,
            kept,
            certain: false,
            judged: false,
            is_promise: true,
        }
    }

    /// A count that has to be 0.
    pub(super) fn none(figure: impl Into<String>, count: u64) -> Self {
        Self {
            certain: true,
            ..Self::new(
                figure,
                "0".to_owned(),
                count.to_string(),
                count as f64,
                count == 0,
            )
        }
    }

    /// Something that either is so or is not; `measured` says how it is.
    pub(super) fn is(
        figure: impl Into<String>,
        promised: &str,
        measured: String,
        value: f64,
        kept: bool,
    ) -> Self {
        Self {
            certain: true,
            ..Self::new(figure, promised.to_owned(), measured, value, kept)
        }
    }

    /// A time that may not be longer (s); decides in the long form only.
    pub(super) fn time(figure: impl Into<String>, most: f64, seconds: f64) -> Self {
        Self::new(
            figure,
            format!("<= {}", units::time(most)),
            units::time(seconds),
            seconds,
            seconds <= most,
        )
    }

    /// A ratio to a control that may not be larger; decides in the long form only.
    pub(super) fn at_most(figure: impl Into<String>, most: f64, ratio: f64) -> Self {
        Self::new(
            figure,
            format!("<= {most}"),
            format!("{ratio:.3}"),
            ratio,
            ratio <= most,
        )
    }

    /// A ratio to a control that may not be smaller; decides in the long form only.
    pub(super) fn at_least(figure: impl Into<String>, least: f64, ratio: f64) -> Self {
        Self::new(
            figure,
            format!(">= {least}"),
            format!("{ratio:.3}"),
            ratio,
            ratio >= least,
        )
    }

    /// A part that may not be larger; decides in the long form only.
    pub(super) fn part(figure: impl Into<String>, most: f64, part: f64) -> Self {
        let percent = |part: f64| format!("{} %", part * 1e2);
        Self::new(
            figure,
            format!("<= {}", percent(most)),
            format!("{:.3} %", part * 1e2),
            part,
            part <= most,
        )
    }

    /// A figure of which nothing is promised.
    pub(super) fn told(figure: impl Into<String>, measured: String, value: f64) -> Self {
        Self {
            is_promise: false,
            ..Self::new(figure, String::new(), measured, value, true)
        }
    }

    /// For people.
    pub(super) fn line(&self) -> String {
        let verdict = match (self.is_promise, self.kept, self.judged) {
            (false, ..) => "",
            (_, true, true) => "kept",
            (_, false, true) => "NOT KEPT",
            (_, true, false) => "(kept, not judged)",
            (_, false, false) => "(above, not judged)",
        };
        let Self {
            promise,
            figure,
            promised,
            measured,
            ..
        } = self;
        line(promise, figure, promised, measured, verdict)
    }
}

impl Tally {
    /// Requests of these that have no proved answer.
    pub(super) fn unserved(&self, whose: &str) -> Row {
        let figure = format!("of {} {whose}, without a proved answer", self.sent);
        Row::none(figure, self.sent - self.served)
    }

    /// Requests of these that were lost.
    pub(super) fn endless(&self, whose: &str) -> Row {
        Row::none(
            format!("of {} {whose}, without an end", self.sent),
            self.lost,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_judged_is_kept_or_not_and_the_rest_is_only_told() {
        let verdict = |row: Row| {
            row.line()
                .split("  ")
                .last()
                .unwrap()
                .trim()
                .to_owned()
        };
        let judged = |row: Row| Row {
            judged: true,
            ..row
        };
        assert_eq!(verdict(judged(Row::none("deaths", 0))), "kept");
        assert_eq!(verdict(judged(Row::none("deaths", 1))), "NOT KEPT");
        assert_eq!(verdict(Row::time("wait", 0.3, 0.5)), "(above, not judged)");
        assert!(Row::time("wait", 0.3, 0.3).kept && !Row::at_least("rate", 0.9, 0.89).kept);
        assert!(
            Row::told("size", "9 MiB".to_owned(), 9.0)
                .line()
                .ends_with("9 MiB\n")
        );
    }
}

//! One line of the table: a figure, what is promised of it, and what was measured.

use crate::statistics;

/// The line above the rows.
pub(crate) fn head() -> String {
    line("promise", "figure", "promised", "measured", "")
}

fn line(promise: &str, figure: &str, promised: &str, measured: &str, verdict: &str) -> String {
    let text = format!("{promise:<10} {figure:<72} {promised:<12} {measured:<26} {verdict}");
    text.trim_end().to_owned()
}

/// What decides about a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// No noise of the machine can change it: it decides in both forms.
    Certain,
    /// A time or ratio: it decides in the long form only.
    Measured,
    /// Nothing is promised of it.
    Told,
}

/// A figure.
#[derive(Debug)]
pub(crate) struct Row {
    figure: String,
    promised: String,
    measured: String,
    kept: bool,
    kind: Kind,
}

impl Row {
    /// A count that has to be 0.
    pub(crate) fn none(figure: impl Into<String>, count: u64) -> Self {
        Self::is(figure, "0", count.to_string(), count == 0)
    }

    /// Something that either is so or is not; `measured` says how it is.
    pub(crate) fn is(
        figure: impl Into<String>,
        promised: &str,
        measured: String,
        kept: bool,
    ) -> Self {
        Self {
            figure: figure.into(),
            promised: promised.to_owned(),
            measured,
            kept,
            kind: Kind::Certain,
        }
    }

    /// A time that may not be longer (s).
    pub(crate) fn time(figure: impl Into<String>, most: f64, seconds: f64) -> Self {
        Self {
            promised: format!("<= {}", statistics::time(most)),
            kind: Kind::Measured,
            ..Self::is(figure, "", statistics::time(seconds), seconds <= most)
        }
    }

    /// A ratio to a control that may not be larger.
    pub(crate) fn at_most(figure: impl Into<String>, most: f64, ratio: f64) -> Self {
        Self {
            promised: format!("<= {most}"),
            kind: Kind::Measured,
            ..Self::is(figure, "", format!("{ratio:.3}"), ratio <= most)
        }
    }

    /// A figure of which nothing is promised.
    pub(crate) fn told(figure: impl Into<String>, measured: impl Into<String>) -> Self {
        Self {
            kind: Kind::Told,
            ..Self::is(figure, "", measured.into(), true)
        }
    }

    /// Whether it speaks against the promise in this form.
    pub(crate) fn is_broken(&self, long: bool) -> bool {
        !self.kept && self.is_judged(long)
    }

    fn is_judged(&self, long: bool) -> bool {
        self.kind == Kind::Certain || (self.kind == Kind::Measured && long)
    }

    /// For people.
    pub(crate) fn line(&self, promise: &str, long: bool) -> String {
        let verdict = match (self.kind, self.kept, self.is_judged(long)) {
            (Kind::Told, ..) => "",
            (_, true, true) => "kept",
            (_, false, true) => "NOT KEPT",
            (_, true, false) => "(kept, not judged)",
            (_, false, false) => "(above, not judged)",
        };
        line(
            promise,
            &self.figure,
            &self.promised,
            &self.measured,
            verdict,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_decide_always_and_times_in_the_long_form() {
        let late = Row::time("wait", 0.3, 0.5);
        assert!(!late.is_broken(false) && late.is_broken(true));
        assert!(Row::none("lost", 1).is_broken(false) && !Row::none("lost", 0).is_broken(true));
        assert!(!Row::told("size", "9").is_broken(true));
        assert!(late.line("x", true).ends_with("NOT KEPT"));
        assert!(
            late.line("x", false)
                .ends_with("(above, not judged)")
        );
    }
}

//! What came of a path, for people and as JSON.

use serde_json::{Value, json};
use taut::timing::{ColumnLimits, Limits, Range, Timed, Usage, Use};
use taut::warning::{self, Warning};

use super::verdict::{Nearest, Reached, Shown, Verdict};
use super::written;
use crate::cli::load::Loaded;
use crate::cli::{report, subject};

/// An answer with all that is told of it.
pub(super) struct Answer<'a> {
    pub(super) loaded: &'a Loaded,
    pub(super) verdict: &'a Verdict,
    pub(super) stages: &'a [Reached],
    pub(super) limits: &'a Limits,
    /// The file of limits has scaling factors.
    pub(super) ignores_scaling: bool,
    pub(super) time_s: f64,
}

impl Answer<'_> {
    fn told(&self) -> Vec<Warning> {
        let mut of_files = subject::warnings(self.loaded);
        if self.ignores_scaling {
            let text = "the scaling factors in the file of limits are of MoveIt's requests and do not count here; use --speed";
            of_files.push(Warning::uncovered(text.to_owned()));
        }
        warning::told(of_files.iter().chain(&self.loaded.notes))
    }

    /// Says on standard error what a person should know.
    pub(super) fn warn(&self) {
        report::warn(&self.told(), "");
    }

    /// A line.
    pub(super) fn line(&self) -> String {
        let time = report::time(self.time_s);
        match self.verdict {
            Verdict::Timed(shown) => format!("{}   {time}", self.timed(shown)),
            Verdict::Refused(_, text) => format!("{text}   {time}"),
            Verdict::TimedOut => {
                format!(
                    "{}   the deadline passed before any trajectory was proved   {time}",
                    self.verdict.code().name()
                )
            }
        }
    }

    fn timed(&self, shown: &Shown) -> String {
        let timed = &shown.timed;
        let duration_s = timed.duration_s();
        let stops_s = self
            .stages
            .first()
            .map_or(duration_s, |stage| stage.timed.duration_s());
        format!(
            "time {stops_s:.3} s → {duration_s:.3} s   bound {:.3} s by {}, gap {:.1} %   proved   {}{}{}   {} points",
            timed.bound.time_s,
            self.name(timed.bound.column),
            100.0 * timed.gap(),
            report::clearance(clearance_m(timed)),
            report::lowered(shown.lowered()),
            shown
                .nearest
                .as_ref()
                .map_or(String::new(), near),
            timed.points.len(),
        )
    }

    fn name(&self, column: usize) -> &str {
        &self.loaded.robot.variables()[column].name
    }

    /// One object; a trajectory that is proved is in it.
    pub(super) fn json(&self) -> String {
        let code = self.verdict.code();
        let mut all = json!({
            "name": self.loaded.name,
            "code": i32::from(code),
            "code_name": code.name(),
            "stages": self.stages.iter().map(stage).collect::<Vec<_>>(),
            "warnings": taut::files::result::texts(&self.told(), |_| true),
            "uncovered": taut::files::result::texts(&self.told(), Warning::is_uncovered),
            "time_s": self.time_s,
        });
        let more = match self.verdict {
            Verdict::Timed(shown) => self.found(shown),
            Verdict::Refused(_, text) => json!({ "proved": false, "message": text }),
            Verdict::TimedOut => json!({ "proved": false }),
        };
        add(&mut all, more);
        all.to_string()
    }

    fn found(&self, shown: &Shown) -> Value {
        let timed = &shown.timed;
        let mut found = json!({
            "proved": true,
            "controller": timed.controller.to_string(),
            "duration_s": timed.duration_s(),
            "duration_bound_s": timed.bound.time_s,
            "bound_by": self.name(timed.bound.column),
            "gap": timed.gap(),
            "clearance_m": clearance_m(timed),
            "nearest": shown.nearest,
            "floors_lowered": shown.lowered(),
            "intervals": timed.proof.as_ref().map_or(0, |proof| proof.intervals()),
            "most_used": self.used(&timed.most_used()),
            "usage": timed.usage.iter().map(|usage| self.used(usage)).collect::<Vec<_>>(),
            "certificate": shown.certificate,
        });
        add(&mut found, written::message(self.loaded, timed));
        found
    }

    /// The largest part of a limit of each kind, and when.
    fn used(&self, usage: &Usage) -> Value {
        let used = |used: &Use, limit: fn(&ColumnLimits) -> Range| {
            let range = limit(&self.limits.columns()[used.column]);
            json!({
                "variable": self.name(used.column),
                "part": used.part,
                "at_s": used.time_s,
                "limit": [range.least, range.most],
            })
        };
        json!({
            "velocity": used(&usage.velocity, |limits| limits.velocity),
            "acceleration": used(&usage.acceleration, |limits| limits.acceleration),
        })
    }
}

/// Where it is nearest to anything.
fn near(nearest: &Nearest) -> String {
    let amount = report::amount(&nearest.requirement, nearest.amount);
    format!(
        ", least at {:.3} s: {}, {amount}",
        nearest.time_s, nearest.requirement
    )
}

fn stage(reached: &Reached) -> Value {
    json!({
        "name": reached.timed.stage.name(),
        "duration_s": reached.timed.duration_s(),
        "time_s": reached.after_s,
    })
}

/// Distance that every pair keeps (m); `None` where nothing is near.
fn clearance_m(timed: &Timed) -> Option<f64> {
    let proof = timed.proof.as_ref()?;
    Some(proof.clearance_m()).filter(|metres| metres.is_finite())
}

/// Adds the fields of an object to another.
fn add(all: &mut Value, more: Value) {
    if let (Value::Object(all), Value::Object(more)) = (all, more) {
        all.extend(more);
    }
}

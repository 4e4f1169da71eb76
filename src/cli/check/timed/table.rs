//! What was found, in a line for people.

use taut::solid::TOUCHING_M;
use taut::validation::timed::{Curve, Outside};

use super::judge::{Judged, Proof, Refusal, Verdict, code};
use crate::cli::report;
use taut_ipc::wire::Code;

/// The line, `time_s` after it was begun.
pub(super) fn table(curve: &Curve, judged: &Judged, time_s: f64) -> String {
    let points = curve.segments() + 1;
    let verdict = &judged.verdict;
    let text = match verdict {
        Verdict::Proved(_) if judged.pairs == 0 => format!("proved{}", report::NOTHING_TO_CHECK),
        Verdict::Proved(proof) => proved(curve, proof),
        Verdict::Refused(refusal) => refused(code(verdict).1.unwrap_or_default(), refusal, points),
        Verdict::Outside {
            outside: found,
            variable,
            limits,
        } => outside(found, variable, *limits, points),
        Verdict::Beyond(beyond) => format!(
            "LIMIT at {:.4} s, after point {} of {points}: the {} of {} is {:.6} of its limit",
            beyond.used.time_s,
            beyond.point + 1,
            beyond.what,
            beyond.variable,
            beyond.used.part
        ),
        Verdict::NoGeometry(why) => format!("{}   {why}", Code::Uncertified.name()),
        Verdict::TimedOut => format!(
            "{}   the deadline passed before the trajectory was proved",
            Code::TimedOut.name()
        ),
    };
    format!("{text}   {}", report::time(time_s))
}

fn proved(curve: &Curve, proof: &Proof) -> String {
    format!(
        "proved   {}{}   {} points, {}, {} intervals",
        report::clearance(proof.clearance_m),
        report::lowered(&proof.lowered),
        curve.segments() + 1,
        report::time(curve.total_s()),
        proof.intervals
    )
}

fn refused(reason: &str, refusal: &Refusal, points: usize) -> String {
    let time = refusal.time_s;
    let point = refusal.point + 1;
    let requirement = &refusal.requirement;
    let amount = amount(refusal);
    format!("{reason} at {time:.4} s, after point {point} of {points}: {requirement}, {amount}")
}

fn amount(refusal: &Refusal) -> String {
    let text = report::amount(&refusal.requirement, refusal.measure.amount);
    // Bodies may be deeper in each other a little later than when they first touch.
    match refusal.measure.amount < -TOUCHING_M {
        true => format!("{text} at {:.4} s", refusal.seen_s),
        false => text,
    }
}

fn outside(outside: &Outside, variable: &str, [lower, upper]: [f64; 2], points: usize) -> String {
    format!(
        "LIMIT at {:.4} s, after point {} of {points}: {variable} is {:.6}, outside [{lower}, {upper}] by {:.1e}",
        outside.time_s,
        outside.point + 1,
        outside.value,
        outside.by
    )
}

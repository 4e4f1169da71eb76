//! What was found, in a line for people.

use taut::solid::TOUCHING_M;
use taut::validation::timed::{Curve, Outside, TimedHit, TimedProof};

use super::judge::{Judged, Verdict, code, lowered};
use crate::cli::error::CliError;
use crate::cli::load::Loaded;
use crate::cli::report::{self, length};
use taut_ipc::wire::Code;

/// The line, `time_s` after it was begun.
pub(super) fn table(
    loaded: &Loaded,
    curve: &Curve,
    judged: &Judged,
    time_s: f64,
) -> Result<String, CliError> {
    let points = curve.segments() + 1;
    let verdict = &judged.verdict;
    let text = match verdict {
        Verdict::Proved(_) if judged.pairs == 0 => format!("proved{}", report::NOTHING_TO_CHECK),
        Verdict::Proved(proof) => proved(loaded, curve, proof)?,
        Verdict::Refused { hit, bodies } => {
            refused(code(verdict).1.unwrap_or_default(), hit, bodies, points)
        }
        Verdict::Outside {
            outside: found,
            variable,
            limits,
        } => outside(found, variable, *limits, points),
        Verdict::NoGeometry(why) => format!("{}   {why}", Code::Uncertified.name()),
        Verdict::TimedOut => format!(
            "{}   the deadline passed before the trajectory was proved",
            Code::TimedOut.name()
        ),
    };
    Ok(format!("{text}   {}", report::time(time_s)))
}

fn proved(loaded: &Loaded, curve: &Curve, proof: &TimedProof) -> Result<String, CliError> {
    let points = curve.segments() + 1;
    let clearance = report::clearance(Some(proof.clearance_m).filter(|metres| metres.is_finite()));
    let floors = lowered(loaded, proof)?;
    let floors: Vec<String> = floors
        .iter()
        .map(|(a, b, floor)| format!("{a} × {b} {}", length(*floor)))
        .collect();
    let floors = match floors.is_empty() {
        true => String::new(),
        false => format!("   lowered: {}", floors.join(", ")),
    };
    let seconds = report::time(curve.total_s());
    let pieces = proof.pieces;
    Ok(format!(
        "proved   {clearance}{floors}   {points} points, {seconds}, {pieces} pieces"
    ))
}

fn refused(reason: &str, hit: &TimedHit, [a, b]: &[String; 2], points: usize) -> String {
    let depth = match -hit.contact.distance {
        depth if depth.abs() <= TOUCHING_M => "touching".to_owned(),
        depth if depth > 0.0 => format!("depth ≥ {} at {:.4} s", length(depth), hit.seen_s),
        depth => format!("distance {}", length(-depth)),
    };
    let time = hit.time_s;
    let point = hit.point + 1;
    format!("{reason} at {time:.4} s, after point {point} of {points}: {a} × {b}, {depth}")
}

fn outside(outside: &Outside, variable: &str, [lower, upper]: [f64; 2], points: usize) -> String {
    let time_s = outside.time_s;
    let value = outside.value;
    let by = outside.by;
    let point = outside.point + 1;
    format!(
        "LIMIT at {time_s:.4} s, after point {point} of {points}: {variable} is {value:.6}, outside [{lower}, {upper}] by {by:.1e}"
    )
}

//! What a request asks of times, for its robot and its path.

use std::sync::Arc;

use crate::files;
use crate::optimize::Settings;
use crate::path::Path;
use crate::store::Snapshot;
use crate::timing;
use taut_ipc::control::Refusal;
use taut_ipc::limits::MAX_TIMED_NUMBERS;
use taut_ipc::wire::Code;

/// What a request asks of times.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// What the trajectory is to be, but for the waypoints that it must pass: those are known with the path
    /// that it follows.
    pub settings: timing::Settings,
    /// Clearance to keep where it is executed (m).
    pub clearance_m: f64,
    /// Whether its limits come with scaling factors, which do not count.
    pub ignores_scaling: bool,
}

/// What a text asks of times; `None` of an empty one.
///
/// # Errors
/// A text that is none, a joint that moves and has no limit, a path that is too long for an answer with
/// times.
pub(super) fn timing(
    text: &str,
    snapshot: &Snapshot,
    settings: &Settings,
    path: &Path,
) -> Result<Option<Arc<Timing>>, Refusal> {
    let invalid = |error: String| Refusal::new(Code::InvalidTiming, error);
    let Some(asked) = files::Timing::parse(text).map_err(invalid)? else {
        return Ok(None);
    };
    check_size(path)?;
    let limits = asked
        .settings(&snapshot.robot, path)
        .map_err(invalid)?;
    Ok(Some(Arc::new(Timing {
        settings: timing::Settings {
            strict: settings.strict,
            seed: settings.seed,
            ..limits
        },
        clearance_m: asked
            .clearance_m
            .unwrap_or(settings.clearance_m),
        ignores_scaling: asked.limits.has_scaling,
    })))
}

fn check_size(path: &Path) -> Result<(), Refusal> {
    let numbers = path.as_flat().len();
    if numbers <= MAX_TIMED_NUMBERS {
        return Ok(());
    }
    let text = format!(
        "{} waypoints x {} columns with times; at most {MAX_TIMED_NUMBERS} numbers: split the path",
        path.len(),
        path.nq()
    );
    Err(Refusal::new(Code::ResourceExhausted, text))
}

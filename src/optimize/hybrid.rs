//! The default: shortcuts and contact half-spaces in turns.

use super::outcome::Termination;
use super::progress::Progress;
use super::{contact, shortcut};

/// Pulls the path taut; returns why that ended.
pub fn optimize(progress: &mut Progress) -> Termination {
    if let Some(t) = shortcut::skip(progress) {
        return t;
    }
    match contact::optimize(progress) {
        Termination::Converged => {}
        other => return other,
    }
    match shortcut::partial(progress) {
        Termination::Converged => {}
        other => return other,
    }
    contact::optimize(progress)
}

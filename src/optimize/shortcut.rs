//! Placeholder.
use super::{Improvement, Task, Termination};
use crate::path::Path;
use crate::validation::Validator;

/// Placeholder.
pub fn random(
    _task: &Task,
    _path: &mut Path,
    _validator: &mut Validator,
    _stop: &mut dyn FnMut() -> bool,
    _publish: &mut dyn FnMut(Improvement),
) -> (u64, Termination) {
    (0, Termination::Converged)
}

/// Placeholder.
pub fn partial(
    _task: &Task,
    _path: &mut Path,
    _validator: &mut Validator,
    _stop: &mut dyn FnMut() -> bool,
    _publish: &mut dyn FnMut(Improvement),
) -> (u64, Termination) {
    (0, Termination::Converged)
}

//! The code of an answer: MoveIt's numbers where MoveIt has one, ours from −1001 down.

use taut::optimize::Outcome;
pub(super) use taut_ipc::wire::Code;

/// The code of an outcome of this process.
pub(super) fn of(outcome: &Outcome) -> Code {
    crate::daemon::translate::code_of(outcome, None)
}

//! The code of an answer: MoveIt's numbers where MoveIt has one, ours from −1001 down.

use taut::optimize::{Outcome, RefusalPlace, Termination};
use taut::validation::HitReason;

/// What an answer amounts to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Code {
    Success,
    InvalidMotionPlan,
    TimedOut,
    StartStateInCollision,
    GoalInCollision,
    Uncertified,
}

impl Code {
    /// The code of an outcome.
    pub(super) fn of(outcome: &Outcome) -> Self {
        match &outcome.refusal {
            _ if outcome.proved => Self::Success,
            Some(refusal) if refusal.reason == HitReason::Collision => match refusal.place {
                RefusalPlace::Start => Self::StartStateInCollision,
                RefusalPlace::Goal => Self::GoalInCollision,
                RefusalPlace::Between => Self::InvalidMotionPlan,
            },
            None if outcome.termination == Termination::Stopped => Self::TimedOut,
            _ => Self::Uncertified,
        }
    }

    /// Number on the wire and in results.
    pub(super) fn number(self) -> i32 {
        match self {
            Self::Success => 1,
            Self::InvalidMotionPlan => -2,
            Self::TimedOut => -6,
            Self::StartStateInCollision => -10,
            Self::GoalInCollision => -12,
            Self::Uncertified => -1001,
        }
    }

    /// Name in results and messages.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Success => "SUCCESS",
            Self::InvalidMotionPlan => "INVALID_MOTION_PLAN",
            Self::TimedOut => "TIMED_OUT",
            Self::StartStateInCollision => "START_STATE_IN_COLLISION",
            Self::GoalInCollision => "GOAL_IN_COLLISION",
            Self::Uncertified => "UNCERTIFIED",
        }
    }

    /// Exit code of the command line.
    pub(super) fn exit_code(self) -> u8 {
        match self {
            Self::Success => 0,
            Self::InvalidMotionPlan | Self::StartStateInCollision | Self::GoalInCollision => 1,
            Self::TimedOut | Self::Uncertified => 2,
        }
    }
}

//! Integers of the wire that mean one of a few things, with checked conversions.

use super::WireError;

macro_rules! number {
    ($(#[$meta:meta])* $name:ident, $field:literal { $( $variant:ident = $value:literal, $meaning:literal; )* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u32)]
        pub enum $name {
            $( #[doc = $meaning] $variant = $value, )*
        }

        impl $name {
            /// Every value with its number and meaning.
            pub const ALL: &'static [($name, &'static str)] = &[$( ($name::$variant, $meaning), )*];
        }

        impl TryFrom<u32> for $name {
            type Error = WireError;

            fn try_from(value: u32) -> Result<Self, WireError> {
                match value {
                    $( $value => Ok($name::$variant), )*
                    _ => Err(WireError::UnknownValue { field: $field, value: value.into() }),
                }
            }
        }

        impl From<$name> for u32 {
            fn from(value: $name) -> u32 {
                value as u32
            }
        }
    };
}

number! {
    /// What to do with the path.
    Mode, "mode" {
        Check = 0, "prove the path, change nothing";
        Gradient = 1, "the gradient method";
        RandomShortcut = 2, "shortcuts between random configurations";
        PartialShortcut = 3, "shortcuts of single joints";
        Contact = 4, "the gradient method with contact half-spaces";
        Hybrid = 5, "shortcuts and contact half-spaces in turns, by what they gain";
    }
}

number! {
    /// Whether more responses follow.
    Status, "status" {
        Progress = 0, "an improvement, or the verdict of a watch; more follow";
        Final = 1, "the last response of the request";
    }
}

number! {
    /// How the work on a request ended; data, not an error.
    Termination, "termination" {
        Running = 0, "it has not ended";
        Converged = 1, "a full round gained too little";
        WorkBudget = 2, "the counted budget is spent";
        Deadline = 3, "the deadline came";
        Cancelled = 4, "the client went away or cancelled";
        FinishedEarly = 5, "the client asked for the best so far";
        Checked = 6, "mode check: proved or not, nothing to improve";
        Refused = 7, "the request was refused, see code";
        IterationLimit = 8, "the method's own limit of iterations";
    }
}

number! {
    /// Why the input is not proved; what it amounts to is the code.
    RefusalReason, "refusal_reason" {
        None = 0, "it is proved, or nothing is known";
        Collision = 1, "bodies touch or overlap";
        TooClose = 2, "bodies come closer than 1.5 times their floor";
        Uncertified = 3, "the proof reached its limit";
        NoGeometry = 4, "no link of the robot has collision geometry";
    }
}

number! {
    /// The stage of the method that found a path.
    Stage, "stage" {
        Input = 0, "the input itself";
        Shortcut = 1, "whole-configuration shortcuts";
        PartialShortcut = 2, "single-joint shortcuts";
        Gradient = 3, "the gradient loop";
        Contact = 4, "the gradient loop with contact half-spaces";
    }
}

number! {
    /// What a warning means for the verdict.
    WarningKind, "kind" {
        Uncovered = 0, "what the verdict does not cover, or rests on";
        Cosmetic = 1, "takes nothing from the verdict; stands for all that are like it";
    }
}

number! {
    /// What happened to a scene.
    SceneEventKind, "kind" {
        Created = 0, "the scene is new";
        Changed = 1, "the scene has a new version";
        Deleted = 2, "the scene is gone";
        PathUnsafe = 3, "a watched path is no longer proved";
    }
}

/// Flags of a request.
pub struct RequestFlags;

impl RequestFlags {
    /// Never lower a pair's clearance floor; UNCERTIFIED instead.
    pub const STRICT: u32 = 1 << 0;
    /// Columns of continuous joints are real numbers, not angles on the circle.
    pub const UNWRAPPED: u32 = 1 << 1;
    /// Do not look for active contacts: an answer that only needs its proof comes sooner.
    pub const WITHOUT_CONTACTS: u32 = 1 << 2;
    /// Mode check only: do not end with the verdict, but check again after every change of the
    /// scene until the client drops the request.
    pub const WATCH: u32 = 1 << 3;
    /// Prove each segment of the answer at the largest clearance that it keeps, up to 10 cm, and
    /// tell the reach of each coordinate: the corridor in which what is executed stays free.
    pub const CORRIDOR: u32 = 1 << 4;
    /// The goal's numbers stay to the last bit; a path whose angles do not lead there by their
    /// numbers is refused.
    pub const KEEP_GOAL: u32 = 1 << 5;
    /// All flags that exist.
    pub const ALL: u32 = Self::STRICT
        | Self::UNWRAPPED
        | Self::WITHOUT_CONTACTS
        | Self::WATCH
        | Self::CORRIDOR
        | Self::KEEP_GOAL;

    /// Checks that only known flags are set.
    ///
    /// # Errors
    /// [`WireError::UnknownValue`] with the unknown bits.
    pub fn check(flags: u32) -> Result<(), WireError> {
        known(flags, Self::ALL)
    }
}

/// Flags of a response.
pub struct ResponseFlags;

impl ResponseFlags {
    /// The path is proved collision-free at its floors.
    pub const PROVED: u32 = 1 << 0;
    /// The scene has a newer version than the one the path was proved against.
    pub const SUPERSEDED: u32 = 1 << 1;
    /// All flags that exist.
    pub const ALL: u32 = Self::PROVED | Self::SUPERSEDED;

    /// Checks that only known flags are set.
    ///
    /// # Errors
    /// [`WireError::UnknownValue`] with the unknown bits.
    pub fn check(flags: u32) -> Result<(), WireError> {
        known(flags, Self::ALL)
    }
}

fn known(flags: u32, all: u32) -> Result<(), WireError> {
    let unknown = flags & !all;
    if unknown != 0 {
        return Err(WireError::UnknownValue {
            field: "flags",
            value: unknown.into(),
        });
    }
    Ok(())
}

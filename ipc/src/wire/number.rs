//! Integers of the wire that mean one of a few things, with checked conversions.

use super::WireError;

macro_rules! number {
    ($(#[$meta:meta])* $name:ident, $field:literal { $( $variant:ident = $value:literal $text:literal, $meaning:literal; )* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u32)]
        pub enum $name {
            $( #[doc = $meaning] $variant = $value, )*
        }

        impl $name {
            /// Every value with its number and meaning.
            pub const ALL: &'static [($name, &'static str)] = &[$( ($name::$variant, $meaning), )*];

            /// Its name in results and in other languages.
            pub const fn name(self) -> &'static str {
                match self {
                    $( $name::$variant => $text, )*
                }
            }

            /// The value of this name.
            pub fn named(name: &str) -> Option<Self> {
                Self::ALL.iter().map(|(value, _)| *value).find(|value| value.name() == name)
            }
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
        Check = 0 "check", "prove the path, change nothing";
        Gradient = 1 "gradient", "the gradient method";
        RandomShortcut = 2 "random-shortcut", "shortcuts between random configurations";
        PartialShortcut = 3 "partial-shortcut", "shortcuts of single joints";
        Contact = 4 "contact", "the gradient method with contact half-spaces";
        Hybrid = 5 "hybrid", "shortcuts and contact half-spaces in turns, by what they gain";
    }
}

number! {
    /// What a message on a network is.
    EnvelopeKind, "kind" {
        Request = 0 "request", "a request: its header and sections";
        Again = 1 "again", "the answers to a request that was sent, or how it ended; no payload";
        Control = 2 "control", "a control message";
    }
}

number! {
    /// Whether more responses follow.
    Status, "status" {
        Progress = 0 "progress", "an improvement, or the verdict of a watch; more follow";
        Final = 1 "final", "the last response of the request";
    }
}

number! {
    /// How the work on a request ended; data, not an error.
    Termination, "termination" {
        Running = 0 "running", "it has not ended";
        Converged = 1 "converged", "a full round gained too little";
        WorkBudget = 2 "work-budget", "the counted budget is spent";
        Deadline = 3 "deadline", "the deadline came";
        Cancelled = 4 "cancelled", "the client went away or cancelled";
        FinishedEarly = 5 "finished-early", "the client asked for the best so far";
        Checked = 6 "checked", "mode check: proved or not, nothing to improve";
        Refused = 7 "refused", "the request was refused, see code";
        IterationLimit = 8 "iteration-limit", "the method's own limit of iterations";
    }
}

number! {
    /// Why the input is not proved; what it amounts to is the code.
    RefusalReason, "refusal_reason" {
        None = 0 "none", "it is proved, or nothing is known";
        Collision = 1 "collision", "bodies touch or overlap";
        TooClose = 2 "too-close", "less is kept than 1.5 times the floor";
        Uncertified = 3 "uncertified", "the proof reached its limit";
        NoGeometry = 4 "no-geometry", "no link of the robot has collision geometry";
        Outside = 5 "outside", "a path constraint is violated";
    }
}

number! {
    /// What kind of thing a path must keep, which says how its amounts are meant.
    RequirementKind, "kind" {
        Clearance = 0 "clearance", "the distance of two bodies, at least the floor; below 0 they overlap, and the least way that parts them is no shorter, for two convex ones as long";
        Orientation = 1 "orientation", "what is left of how far something may turn; below 0 it is outside by so much";
        Position = 2 "position", "what is left of where a point may be; below 0 it is outside by so much";
        Joint = 3 "joint", "what is left of where a joint may be; below 0 it is outside by so much";
    }
}

number! {
    /// What amounts and floors are counted in.
    Unit, "unit" {
        Metre = 0 "m", "metres";
        Radian = 1 "rad", "radians";
    }
}

number! {
    /// The stage of the method that found a path.
    Stage, "stage" {
        Input = 0 "input", "the input itself";
        Shortcut = 1 "shortcut", "whole-configuration shortcuts";
        PartialShortcut = 2 "partial-shortcut", "single-joint shortcuts";
        Gradient = 3 "gradient", "the gradient loop";
        Contact = 4 "contact", "the gradient loop with contact half-spaces";
    }
}

number! {
    /// Whether an answer has a trajectory.
    Times, "times" {
        NotAsked = 0 "not-asked", "none is asked for";
        Timed = 1 "timed", "there is one, proved as it is written at every instant";
        NotReached = 2 "not-reached", "one is asked for, and none is proved yet, or was when the request ended";
        Refused = 3 "refused", "none is proved or none is possible, the message says why";
        NoPath = 4 "no-path", "the path is not proved, and gets no times";
    }
}

number! {
    /// What a trajectory comes of.
    TimingStage, "stage" {
        Stops = 0 "stops", "it stops at every waypoint";
        Rounded = 1 "rounded", "it rounds corners";
        Shortcuts = 2 "shortcuts", "parts of it are shortcuts in time";
    }
}

number! {
    /// What goes from one point of a trajectory to the next.
    Controller, "controller" {
        Cubic = 0 "cubic", "cubics that have the positions and velocities of both points";
        Quintic = 1 "quintic", "quintics that have their accelerations too";
        Linear = 2 "linear", "straight ways, so many points per second";
    }
}

number! {
    /// What a warning means for the verdict.
    WarningKind, "kind" {
        Uncovered = 0 "uncovered", "what the verdict does not cover, or rests on";
        Cosmetic = 1 "cosmetic", "takes nothing from the verdict; stands for all that are like it";
    }
}

number! {
    /// What happened to a scene.
    SceneEventKind, "kind" {
        Created = 0 "created", "the scene is new";
        Changed = 1 "changed", "the scene has a new version";
        Deleted = 2 "deleted", "the scene is gone";
        PathUnsafe = 3 "path-unsafe", "a watched path is no longer proved";
    }
}

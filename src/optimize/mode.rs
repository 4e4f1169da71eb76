//! The optimizers by name.

use super::outcome::Termination;
use super::progress::Progress;
use super::{contact, gradient, hybrid, shortcut};

/// Makes a path shorter until it ends by itself or is told to.
pub(super) type Optimizer = fn(&mut Progress) -> Termination;

macro_rules! modes {
    ($( $(#[$meta:meta])+ $mode:ident = $name:literal, $optimizer:expr; )*) => {
        /// Optimizer of a request.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub enum Mode {
            $( $(#[$meta])+ $mode, )*
        }

        impl Mode {
            /// Every mode, in the order of the wire.
            pub const ALL: [Self; [$( $name ),*].len()] = [$( Self::$mode ),*];

            /// Name on the command line and in results.
            pub const fn name(self) -> &'static str {
                match self {
                    $( Self::$mode => $name, )*
                }
            }

            /// What shortens; `None` where nothing is to be.
            pub(super) fn optimizer(self) -> Option<Optimizer> {
                match self {
                    $( Self::$mode => $optimizer, )*
                }
            }
        }
    };
}

modes! {
    /// Prove the path, change nothing.
    Check = "check", None;
    /// The gradient-based method of Campana, Lamiraux and Laumond.
    Gradient = "gradient", Some(gradient::optimize);
    /// Straight lines between random places of the path.
    RandomShortcut = "random-shortcut", Some(shortcut::random);
    /// The same for one joint at a time.
    PartialShortcut = "partial-shortcut", Some(shortcut::partial);
    /// The gradient with half-spaces from true closest points.
    Contact = "contact", Some(contact::optimize);
    /// Shortcuts and contact half-spaces in turns, scheduled by what they gain.
    #[default]
    Hybrid = "hybrid", Some(hybrid::optimize);
}

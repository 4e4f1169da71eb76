//! Flags of requests and responses.

use super::WireError;

/// Flags of a request.
pub struct RequestFlags;

macro_rules! request_flags {
    (
        scalars { $($scalars:tt)* }
        flags { $(
            $(#[doc = $doc:literal])+
            $field:ident = $default:literal, $bit:literal $name:ident { $($row:tt)* };
        )* }
        sections { $($sections:tt)* }
    ) => {
        impl RequestFlags {
            $(
                $(#[doc = $doc])+
                #[doc = concat!("\n\nThe bit says that `", stringify!($field), "` is not ", stringify!($default), ".")]
                pub const $name: u32 = 1 << $bit;
            )*
            /// All flags that exist.
            pub const ALL: u32 = $( Self::$name )|*;
            /// Number of the bit, name and meaning of every flag.
            pub(crate) const LISTED: &'static [(u32, &'static str, &'static str)] = &[
                $( ($bit, stringify!($name), concat!($($doc),+)), )*
            ];
        }
    };
}

option_table!(request_flags);

impl RequestFlags {
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

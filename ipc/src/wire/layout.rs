//! The macro that defines a wire type, asserts its layout and keeps its description.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "iceoryx2")]
use iceoryx2::prelude::ZeroCopySend;

/// One field of a wire type, as `WIRE.md` lists it.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Name of the field.
    pub name: &'static str,
    /// Its type.
    pub kind: &'static str,
    /// Offset from the start of the type, in bytes.
    pub offset: usize,
    /// Size in bytes.
    pub size: usize,
    /// What it means.
    pub meaning: &'static str,
}

/// Where a section of the payload lies: `count` entries from byte `offset` on. A count of 0 is an
/// absent section.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "iceoryx2", derive(ZeroCopySend))]
pub struct Section {
    /// First byte, a multiple of 8.
    pub offset: u32,
    /// Entries (not bytes).
    pub count: u32,
}

/// Defines a wire type with its size and the offset of each field, both asserted at compile time.
macro_rules! wire_type {
    (
        $(#[$meta:meta])*
        $name:ident, size $size:literal {
            $( $offset:literal $field:ident: $kind:ty, $meaning:literal; )*
        }
    ) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(
            Clone, Copy, Debug, PartialEq,
            bytemuck::Pod, bytemuck::Zeroable,
        )]
        #[cfg_attr(feature = "iceoryx2", derive(ZeroCopySend))]
        pub struct $name {
            $( #[doc = $meaning] pub $field: $kind, )*
        }

        impl $name {
            /// The fields in order.
            pub const FIELDS: &'static [$crate::wire::Field] = &[
                $( $crate::wire::Field {
                    name: stringify!($field),
                    kind: stringify!($kind),
                    offset: $offset,
                    size: size_of::<$kind>(),
                    meaning: $meaning,
                }, )*
            ];
        }

        impl Default for $name {
            fn default() -> Self {
                bytemuck::Zeroable::zeroed()
            }
        }

        const _: () = assert!(size_of::<$name>() == $size && align_of::<$name>() <= 8);
        $( const _: () = assert!(std::mem::offset_of!($name, $field) == $offset); )*
    };
}

//! Who asks.

/// Who asks, whatever it came through.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Client {
    /// Its identity; two connections of one process count as two.
    pub id: u128,
    /// Its process; 0 = not known.
    pub pid: u32,
}

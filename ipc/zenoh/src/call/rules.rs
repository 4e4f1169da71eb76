//! The times of the rules, in nanoseconds.

/// A point of the monotonic clock, or a time, in nanoseconds.
pub type Nanos = u64;

const MS: Nanos = 1_000_000;

/// Pause before a request is sent again to gateways that did not answer, at first.
pub const FIRST_PAUSE: Nanos = 20 * MS;
/// The longest one.
pub const LONGEST_PAUSE: Nanos = 200 * MS;
/// Silence after which a gateway that is there is asked again, at first.
pub const FIRST_SILENCE: Nanos = 2_000 * MS;
/// The longest one: a request without a deadline may compute for minutes.
pub const LONGEST_SILENCE: Nanos = 10_000 * MS;
/// Time after the deadline at which the final answer is asked for once more.
pub const LATE: Nanos = 250 * MS;
/// Time after the deadline at which the caller is answered here.
pub const GRACE: Nanos = 1_000 * MS;
/// How long no gateway may be there.
pub const ALONE: Nanos = 1_300 * MS;
/// How long gateways that are there may leave queries without a reply.
pub const UNSERVED: Nanos = 5_000 * MS;
/// Gateways or daemons that may be lost over one request: it may be what kills them.
pub const MOST_LOSSES: u32 = 10;

//! Names of the services.

use std::borrow::Cow;

/// Paths in, a stream of better paths out.
pub const OPTIMIZE: &str = "taut/v1/optimize";
/// Control messages.
pub const CONTROL: &str = "taut/v1/control";
/// State of the daemon.
pub const STATUS: &str = "taut/v1/status";
/// Changes of scenes.
pub const SCENE_EVENTS: &str = "taut/v1/scene-events";
/// Wakes the daemon.
pub const WAKE_SERVER: &str = "taut/v1/wake-server";
/// Wakes one client.
pub const WAKE_CLIENT: &str = "taut/v1/wake-client";

/// Generation of the services of a daemon that found nothing of another one.
pub const FIRST_GENERATION: u64 = 0;

/// Name of a service in a generation, which the daemon's lock file tells
/// ([`crate::DaemonState::Running`]).
///
/// Services that are made anew while clients of the old ones live have names of their own: the last
/// client of a service takes its file along, by its name.
pub fn name(service: &'static str, generation: u64) -> Cow<'static, str> {
    match generation {
        FIRST_GENERATION => Cow::Borrowed(service),
        later => Cow::Owned(format!("{service}/{later:016x}")),
    }
}

/// Every service and what it carries.
pub const ALL: [(&str, &str); 6] = [
    (
        OPTIMIZE,
        "request to a stream of responses, bytes with the headers below",
    ),
    (
        CONTROL,
        "request to one response, bincode 2.0.1 (standard configuration)",
    ),
    (
        STATUS,
        "publish-subscribe, one status record, history 1, twice a second",
    ),
    (SCENE_EVENTS, "publish-subscribe, one scene event"),
    (
        WAKE_SERVER,
        "event, any client to the daemon: something was sent, cancelled or asked to finish",
    ),
    (
        WAKE_CLIENT,
        "event, the daemon to the one listener named in the request's header",
    ),
];

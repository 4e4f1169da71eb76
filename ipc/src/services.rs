//! Names of the services.

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

/// Name of a service in a generation, which the daemon's lock file tells
/// ([`crate::DaemonState::Running`]).
///
/// The last that has a service open takes its file along, by its name: services that are made anew
/// while a client, or a daemon that was left without its files, has the old ones open need others.
pub fn name(service: &str, generation: u64) -> String {
    format!("{service}/{generation:016x}")
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

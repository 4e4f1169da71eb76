//! What gateways publish, published here.

use crate::caller::Caller;
use crate::names;
use crate::network::{NetworkError, declared};
use bytemuck::{AnyBitPattern, NoUninit};
use std::sync::Arc;
use taut_ipc::limits::WIRE_VERSION;
use taut_ipc::server::Server;
use taut_ipc::wire::{SceneEvent, SceneEventKind, StatusRecord};
use zenoh::Wait;
use zenoh::sample::Sample;

/// Publishes what the best gateway does, and what happens to scenes, for as long as the session is
/// open.
pub(super) fn follow(caller: &Arc<Caller>, server: &Arc<Server>) -> Result<(), NetworkError> {
    subscribe(caller, server, &names::status("*"), status)?;
    subscribe(caller, server, &names::scene_events("*"), event)
}

fn subscribe(
    caller: &Arc<Caller>,
    server: &Arc<Server>,
    key: &str,
    take: fn(&Caller, &Server, &Sample),
) -> Result<(), NetworkError> {
    let for_callback = caller.clone();
    // The server ends before the session does.
    let server = Arc::downgrade(server);
    let subscriber = caller
        .session
        .declare_subscriber(key)
        .callback(move |sample| {
            if let Some(server) = server.upgrade() {
                take(&for_callback, &server, &sample);
            }
        })
        .background()
        .wait();
    declared("a subscriber", subscriber)
}

fn status(caller: &Caller, server: &Server, sample: &Sample) {
    let Some(record) = read::<StatusRecord>(sample) else {
        return;
    };
    if record.wire_version == WIRE_VERSION
        && is_best(caller, sample)
        && let Err(error) = server.publish_status(&record)
    {
        tracing::warn!("{error}");
    }
}

fn event(caller: &Caller, server: &Server, sample: &Sample) {
    let Some(event) = read::<SceneEvent>(sample) else {
        return;
    };
    let Ok(kind) = SceneEventKind::try_from(event.kind) else {
        return;
    };
    // A path is watched wherever it was sent; a scene changes at its home.
    let is_wanted = kind == SceneEventKind::PathUnsafe || is_best(caller, sample);
    if event.wire_version != WIRE_VERSION || !is_wanted {
        return;
    }
    match kind {
        SceneEventKind::Deleted => caller.seen.forget(event.scene_id),
        _ => caller
            .seen
            .note(event.scene_id, event.scene_version, event.scene_hash),
    }
    if let Err(error) = server.publish_scene_event(&event) {
        tracing::warn!("{error}");
    }
}

fn read<T: AnyBitPattern + NoUninit>(sample: &Sample) -> Option<T> {
    let bytes = sample.payload().to_bytes();
    (bytes.len() == size_of::<T>()).then(|| bytemuck::pod_read_unaligned(&bytes))
}

fn is_best(caller: &Caller, sample: &Sample) -> bool {
    let daemon = names::daemon_of(sample.key_expr().as_str());
    caller
        .best()
        .is_some_and(|best| Some(&*best.name) == daemon)
}

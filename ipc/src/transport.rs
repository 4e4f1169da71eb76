//! The services and their settings, the same for both sides.
//!
//! Payload memory is static, at its largest size: it is sparse, so only what is written is taken.
//! Memory that grows (`PowerOfTwo`) would cost 256 segments of bookkeeping in each connection: 10
//! MB, and 0.1 s of the daemon whenever a client comes or goes.
//!
//! The daemon creates, clients only open. Both use iceoryx2's thread-safe variant: a client can
//! move between threads, and every thread of the daemon sends.

use crate::instance::{Instance, InstanceError};
use crate::limits::*;
use crate::services;
use crate::wire::{
    ControlHeader, ControlReplyHeader, RequestHeader, ResponseHeader, SceneEvent, StatusRecord,
};
use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::port::listener::{Listener, ListenerCreateError};
use iceoryx2::prelude::{
    FileName, FilePath, LogLevel, Path as IpcPath, SemanticString, ServiceName, SignalHandlingMode,
    ipc_threadsafe,
};
use iceoryx2::service::builder::{Builder, event, publish_subscribe, request_response};
use iceoryx2::service::port_factory::event as event_service;
use std::sync::{Mutex, PoisonError};

pub(crate) type Variant = ipc_threadsafe::Service;
pub(crate) type OptimizeBuilder =
    request_response::Builder<[u8], RequestHeader, [u8], ResponseHeader, Variant>;
pub(crate) type ControlBuilder =
    request_response::Builder<[u8], ControlHeader, [u8], ControlReplyHeader, Variant>;
pub(crate) type StatusBuilder = publish_subscribe::Builder<StatusRecord, (), Variant>;
pub(crate) type SceneEventBuilder = publish_subscribe::Builder<SceneEvent, (), Variant>;

// A payload follows its header, so headers of this size and alignment align it to 8. Asking
// iceoryx2 for that alignment would reserve 8 bytes for each byte.
const fn aligns_payload<H>() -> bool {
    size_of::<H>().is_multiple_of(PAYLOAD_ALIGN) && align_of::<H>() == PAYLOAD_ALIGN
}
const _: () = assert!(aligns_payload::<RequestHeader>() && aligns_payload::<ResponseHeader>());

/// A node, and which generation of services it opens or makes.
#[derive(Debug)]
pub(crate) struct ServiceNode {
    pub node: Node<Variant>,
    pub generation: u64,
}

impl ServiceNode {
    pub(crate) fn id(&self) -> u128 {
        self.node.id().value()
    }

    fn builder(&self, service: &'static str) -> Builder<Variant> {
        let name = ServiceName::new(&services::name(service, self.generation));
        self.node
            .service_builder(&name.expect("fixed and short"))
    }
}

/// iceoryx2's configuration for an instance.
///
/// Nobody cleans up in passing: only the daemon's janitor does, behind its guard.
pub(crate) fn config(instance: &Instance) -> Config {
    let mut config = Config::default();
    let root = instance.root().as_os_str().as_encoded_bytes();
    let global = &mut config.global;
    global.prefix =
        FileName::new(instance.prefix().as_bytes()).expect("`new` checked the characters");
    global.set_root_path(&IpcPath::new(root).expect("`new` checked the length"));
    global.node.cleanup_dead_nodes_on_creation = false;
    global.node.cleanup_dead_nodes_on_destruction = false;
    global.service.cleanup_dead_nodes_on_open = false;
    config
}

/// Makes iceoryx2's process-wide configuration this instance's, if none was set yet.
///
/// Nodes killed before they wrote their details are looked up there. Only the daemon does this:
/// a planner's process may use iceoryx2 for itself.
pub(crate) fn set_global_config(instance: &Instance) -> Result<(), InstanceError> {
    let path = instance.root().join("iceoryx2.toml");
    let config = config(instance);
    let text = format!(
        "[global]\nroot-path = '{}'\nprefix = '{}'\n\n[global.node]\ncleanup-dead-nodes-on-creation = false\n\
         cleanup-dead-nodes-on-destruction = false\n\n[global.service]\ncleanup-dead-nodes-on-open = false\n",
        config.global.root_path(),
        instance.prefix()
    );
    std::fs::write(&path, text).map_err(|source| instance.file_error(&path, source))?;
    let bytes = path.as_os_str().as_encoded_bytes();
    let file = FilePath::new(bytes).map_err(|_| InstanceError::Root(instance.root().to_owned()))?;
    Config::setup_global_config_from_file(&file)
        .map_err(|error| instance.file_error(&path, std::io::Error::other(error.to_string())))?;
    Ok(())
}

/// A node of `instance` that leaves signals to the program.
pub(crate) fn node(instance: &Instance, generation: u64) -> Result<ServiceNode, String> {
    quiet();
    let node = NodeBuilder::new()
        .config(&config(instance))
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<Variant>()
        .map_err(|error| error.to_string())?;
    Ok(ServiceNode { node, generation })
}

/// Keeps iceoryx2 from printing what callers get as errors anyway; `IOX2_LOG_LEVEL` overrides it.
pub(crate) fn quiet() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| iceoryx2::prelude::set_log_level_from_env_or(LogLevel::Error));
}

pub(crate) fn optimize(node: &ServiceNode) -> OptimizeBuilder {
    node.builder(services::OPTIMIZE)
        .request_response::<[u8], [u8]>()
        .request_user_header::<RequestHeader>()
        .response_user_header::<ResponseHeader>()
}

/// With the settings that the creator decides, for so many clients.
pub(crate) fn optimize_settings(builder: OptimizeBuilder, clients: usize) -> OptimizeBuilder {
    builder
        .max_servers(1)
        .max_clients(clients)
        .max_nodes(MAX_NODES)
        .max_active_requests_per_client(ACTIVE_REQUESTS_PER_CLIENT)
        .max_loaned_requests(ACTIVE_REQUESTS_PER_CLIENT)
        .max_response_buffer_size(RESPONSE_BUFFER)
        .max_borrowed_responses_per_pending_response(BORROWED_RESPONSES)
        .enable_safe_overflow_for_requests(false)
        .enable_safe_overflow_for_responses(true)
        .enable_fire_and_forget_requests(false)
}

pub(crate) fn control(node: &ServiceNode) -> ControlBuilder {
    node.builder(services::CONTROL)
        .request_response::<[u8], [u8]>()
        .request_user_header::<ControlHeader>()
        .response_user_header::<ControlReplyHeader>()
}

pub(crate) fn control_settings(builder: ControlBuilder) -> ControlBuilder {
    builder
        .max_servers(1)
        .max_clients(MAX_CLIENTS)
        .max_nodes(MAX_NODES)
        .max_active_requests_per_client(CONTROL_REQUESTS_PER_CLIENT)
        .max_loaned_requests(CONTROL_REQUESTS_PER_CLIENT)
        .max_response_buffer_size(1)
        .max_borrowed_responses_per_pending_response(1)
        .enable_safe_overflow_for_requests(false)
        .enable_safe_overflow_for_responses(true)
        .enable_fire_and_forget_requests(false)
}

pub(crate) fn status(node: &ServiceNode) -> StatusBuilder {
    node.builder(services::STATUS)
        .publish_subscribe::<StatusRecord>()
}

pub(crate) fn status_settings(builder: StatusBuilder) -> StatusBuilder {
    builder
        .max_publishers(1)
        .max_subscribers(MAX_CLIENTS)
        .max_nodes(MAX_NODES)
        .history_size(1)
        .subscriber_max_buffer_size(1)
        .subscriber_max_borrowed_samples(1)
        .enable_safe_overflow(true)
}

pub(crate) fn scene_events(node: &ServiceNode) -> SceneEventBuilder {
    node.builder(services::SCENE_EVENTS)
        .publish_subscribe::<SceneEvent>()
}

pub(crate) fn scene_event_settings(builder: SceneEventBuilder) -> SceneEventBuilder {
    builder
        .max_publishers(1)
        .max_subscribers(MAX_CLIENTS)
        .max_nodes(MAX_NODES)
        .history_size(0)
        .subscriber_max_buffer_size(SCENE_EVENT_BUFFER)
        .subscriber_max_borrowed_samples(1)
        .enable_safe_overflow(true)
}

pub(crate) fn wake_server(node: &ServiceNode) -> event::Builder<Variant> {
    node.builder(services::WAKE_SERVER).event()
}

pub(crate) fn wake_server_settings(builder: event::Builder<Variant>) -> event::Builder<Variant> {
    builder
        .max_listeners(1)
        .max_notifiers(MAX_NODES)
        .max_nodes(MAX_NODES)
}

pub(crate) fn wake_client(node: &ServiceNode) -> event::Builder<Variant> {
    node.builder(services::WAKE_CLIENT).event()
}

pub(crate) fn wake_client_settings(builder: event::Builder<Variant>) -> event::Builder<Variant> {
    builder
        .max_listeners(MAX_CLIENTS * LISTENERS_PER_CLIENT)
        .max_notifiers(1)
        .max_nodes(MAX_NODES)
}

/// Makes a listener, one at a time in a process: iceoryx2 sets the umask of the whole process
/// meanwhile and puts back what it found, so two at once could leave the wrong one for good.
pub(crate) fn listener(
    service: &event_service::PortFactory<Variant>,
) -> Result<Listener<Variant>, ListenerCreateError> {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _guard = ONE_AT_A_TIME
        .lock()
        .unwrap_or_else(PoisonError::into_inner);
    service.listener_builder().create()
}

//! The daemon's services and ports, with the settings that matter.

use super::error::ServerError;
use crate::limits::{CONTROL_REPLY_MAX, MAX_PAYLOAD};
use crate::transport::{self, ServiceNode, Variant};
use crate::wire::{
    ControlHeader, ControlReplyHeader, RequestHeader, ResponseHeader, SceneEvent, StatusRecord,
};
use iceoryx2::port::listener::Listener;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::server::Server as Port;
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy};
use iceoryx2::service::port_factory::request_response;

pub(super) type OptimizePort = Port<Variant, [u8], RequestHeader, [u8], ResponseHeader>;
pub(super) type ControlPort = Port<Variant, [u8], ControlHeader, [u8], ControlReplyHeader>;
pub(super) type OptimizeService =
    request_response::PortFactory<Variant, [u8], RequestHeader, [u8], ResponseHeader>;
pub(super) type ControlService =
    request_response::PortFactory<Variant, [u8], ControlHeader, [u8], ControlReplyHeader>;

pub(super) fn made<T, E: std::fmt::Display>(
    what: &'static str,
    result: Result<T, E>,
) -> Result<T, ServerError> {
    result.map_err(|error| ServerError::Setup {
        what,
        reason: error.to_string(),
    })
}

pub(super) fn optimize_port(service: &OptimizeService) -> Result<OptimizePort, ServerError> {
    let builder = service
        .server_builder()
        .initial_max_slice_len(MAX_PAYLOAD)
        .allocation_strategy(AllocationStrategy::Static)
        // Waiting for a client that does not read would hang the daemon, even after that client's
        // death.
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .max_loaned_responses_per_request(1);
    made("request port", builder.create())
}

pub(super) fn control_port(service: &ControlService) -> Result<ControlPort, ServerError> {
    let builder = service
        .server_builder()
        .initial_max_slice_len(CONTROL_REPLY_MAX)
        .allocation_strategy(AllocationStrategy::Static)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .max_loaned_responses_per_request(1);
    made("control port", builder.create())
}

pub(super) fn status_port(
    node: &ServiceNode,
) -> Result<Publisher<Variant, StatusRecord, ()>, ServerError> {
    let service = made(
        "status",
        transport::status_settings(transport::status(node)).open_or_create(),
    )?;
    let builder = service
        .publisher_builder()
        .backpressure_strategy(BackpressureStrategy::DiscardData);
    made("status port", builder.max_loaned_samples(1).create())
}

pub(super) fn scene_event_port(
    node: &ServiceNode,
) -> Result<Publisher<Variant, SceneEvent, ()>, ServerError> {
    let builder = transport::scene_event_settings(transport::scene_events(node));
    let service = made("scene events", builder.open_or_create())?;
    let builder = service
        .publisher_builder()
        .backpressure_strategy(BackpressureStrategy::DiscardData);
    made("scene event port", builder.max_loaned_samples(1).create())
}

pub(super) fn listener(node: &ServiceNode) -> Result<Listener<Variant>, ServerError> {
    let builder = transport::wake_server_settings(transport::wake_server(node));
    let service = made("wake-server", builder.open_or_create())?;
    made("wake-server listener", transport::listener(&service))
}

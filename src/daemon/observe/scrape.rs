//! The page that Prometheus reads.

use std::io::Cursor;

use prometheus_client::encoding::text;
use prometheus_client::registry::Registry;
use tiny_http::{Header, Request, Response};

const CONTENT_TYPE: &str =
    "Content-Type: application/openmetrics-text; version=1.0.0; charset=utf-8";

type Page = Response<Cursor<Vec<u8>>>;

/// Answers `/metrics`.
pub(crate) fn answer(request: Request, registry: &Registry) {
    let response = match request.url() {
        "/metrics" => metrics(registry),
        _ => None,
    };
    // A reader that went away needs no answer.
    let _ = request.respond(response.unwrap_or_else(elsewhere));
}

fn metrics(registry: &Registry) -> Option<Page> {
    let mut text = String::new();
    text::encode(&mut text, registry).ok()?;
    let header: Header = CONTENT_TYPE.parse().expect("a header");
    Some(Response::from_string(text).with_header(header))
}

fn elsewhere() -> Page {
    Response::from_string("see /metrics\n").with_status_code(404)
}

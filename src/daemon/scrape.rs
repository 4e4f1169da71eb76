//! The page that Prometheus reads.

use prometheus_client::encoding::text;
use prometheus_client::registry::Registry;
use tiny_http::{Header, Request, Response};

const CONTENT_TYPE: &str =
    "Content-Type: application/openmetrics-text; version=1.0.0; charset=utf-8";

/// Answers `/metrics`.
pub(super) fn answer(request: Request, registry: &Registry) {
    let mut page = String::new();
    let response = match request.url() {
        "/metrics" if text::encode(&mut page, registry).is_ok() => {
            let header: Header = CONTENT_TYPE.parse().expect("a header");
            Response::from_string(page).with_header(header)
        }
        _ => Response::from_string("see /metrics\n").with_status_code(404),
    };
    // A reader that went away needs no answer.
    let _ = request.respond(response);
}

//! The page that Prometheus reads.

use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::JoinHandle;

use prometheus_client::encoding::text;
use prometheus_client::registry::Registry;
use tiny_http::{Header, Request, Response, Server};

const CONTENT_TYPE: &str = "Content-Type: application/openmetrics-text; version=1.0.0; charset=utf-8";

/// Serves `/metrics` until it is dropped.
pub(super) struct Scrape {
    server: Arc<Server>,
    thread: Option<JoinHandle<()>>,
}

impl Scrape {
    /// Starts to serve.
    pub(super) fn start(address: SocketAddr, registry: Arc<Registry>) -> std::io::Result<Self> {
        let server = Server::http(address).map_err(|error| std::io::Error::other(error.to_string()))?;
        let server = Arc::new(server);
        let serving = Arc::clone(&server);
        let thread = std::thread::Builder::new().name("taut-metrics".into()).spawn(move || {
            serving.incoming_requests().for_each(|request| answer(request, &registry));
        })?;
        Ok(Self { server, thread: Some(thread) })
    }

    /// Where it serves: a port of 0 was one of the system's choice.
    pub(super) fn address(&self) -> String {
        self.server.server_addr().to_string()
    }
}

impl Drop for Scrape {
    fn drop(&mut self) {
        self.server.unblock();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn answer(request: Request, registry: &Registry) {
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

//! A small server of pages on a thread of its own.

use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::JoinHandle;

use tiny_http::{Request, Server};

/// Serves until it is dropped.
pub(super) struct Web {
    server: Arc<Server>,
    thread: Option<JoinHandle<()>>,
}

impl Web {
    /// Starts to serve: `answer` gets each request, on the thread of this name.
    pub(super) fn start(
        address: SocketAddr,
        thread: &str,
        answer: impl Fn(Request) + Send + 'static,
    ) -> std::io::Result<Self> {
        let server =
            Server::http(address).map_err(|error| std::io::Error::other(error.to_string()))?;
        let server = Arc::new(server);
        let serving = Arc::clone(&server);
        let named = std::thread::Builder::new().name(thread.to_owned());
        let thread = named.spawn(move || serving.incoming_requests().for_each(answer))?;
        Ok(Self {
            server,
            thread: Some(thread),
        })
    }

    /// Where it serves: a port of 0 was one of the system's choice.
    pub(super) fn address(&self) -> String {
        self.server.server_addr().to_string()
    }
}

impl Drop for Web {
    fn drop(&mut self) {
        self.server.unblock();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

//! A small server of pages on a thread of its own.

use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::JoinHandle;

use tiny_http::{Request, Server};

use crate::daemon::threads::spawn;

/// Serves until it is dropped.
pub(crate) struct Web {
    server: Arc<Server>,
    thread: Option<JoinHandle<()>>,
}

impl Web {
    /// Starts to serve: `answer` gets each request, on the thread of this name.
    pub(crate) fn start(
        address: SocketAddr,
        thread: &str,
        answer: impl Fn(Request) + Send + 'static,
    ) -> std::io::Result<Self> {
        let server = Arc::new(Server::http(address).map_err(std::io::Error::other)?);
        let serving = Arc::clone(&server);
        let serve = move || serving.incoming_requests().for_each(answer);
        let thread = Some(spawn(thread, serve)?);
        Ok(Self { server, thread })
    }

    /// Where it serves: a port of 0 was one of the system's choice.
    pub(crate) fn address(&self) -> String {
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

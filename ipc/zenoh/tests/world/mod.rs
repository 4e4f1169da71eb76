//! A daemon that echoes, and a gateway beside it, in this process.
#![allow(dead_code, missing_docs)]

#[path = "../../../tests/common/mod.rs"]
pub mod common;

use common::{Echo, Sandbox, until};
use std::net::TcpListener;
use std::thread::JoinHandle;
use std::time::Duration;
use taut_ipc::Instance;
use taut_ipc::planner::Carrier;
use taut_ipc::planner::carrier::{Answered, Asked, answers as answers_to};
use taut_ipc::wire::{
    Code, Envelope, EnvelopeKind, Mode, RequestHeader, ResponseHeader, ResponseView, Section,
    Status,
};
use taut_zenoh::message::{Payload, Sender, join, split};
use taut_zenoh::stop::Stop;
use taut_zenoh::{Network, Zenoh, names, serve};
use zenoh::bytes::ZBytes;
use zenoh::handlers::FifoChannelHandler;
use zenoh::query::Reply;
use zenoh::{Session, Wait};

pub const NAME: &str = "cell";

/// A thread that is asked to stop and waited for.
pub struct Until {
    stop: Stop,
    thread: Option<JoinHandle<()>>,
}

impl Until {
    pub fn stopped(work: impl FnOnce(Stop) + Send + 'static) -> Self {
        let stop = Stop::default();
        let for_thread = stop.clone();
        let thread = Some(std::thread::spawn(move || work(for_thread)));
        Self { stop, thread }
    }
}

impl Drop for Until {
    fn drop(&mut self) {
        self.stop.ask();
        let ended = self.thread.take().unwrap().join();
        assert!(ended.is_ok() || std::thread::panicking());
    }
}

pub struct World {
    // The gateway ends before its daemon.
    gateway: Option<Until>,
    pub echo: Option<Echo>,
    pub far: Sandbox,
    pub endpoint: String,
}

impl World {
    pub fn new() -> Self {
        Self::called(NAME)
    }

    pub fn called(name: &str) -> Self {
        let endpoint = format!("tcp/127.0.0.1:{}", free_port());
        Self::with(name, listening(&endpoint), endpoint)
    }

    pub fn with(name: &str, network: Network, endpoint: String) -> Self {
        let far = Sandbox::new();
        let echo = Some(Echo::start(&far.instance));
        Self {
            gateway: Some(gateway(name, network, &far.instance)),
            echo,
            far,
            endpoint,
        }
    }

    pub fn network(&self) -> Network {
        Network::to(&[&self.endpoint])
    }

    /// A session that does what it likes.
    pub fn session(&self) -> Session {
        let session = self.network().open().unwrap();
        let tokens = names::daemon_tokens();
        until("the gateway is there", || {
            let tokens = session.liveliness().get(&tokens).wait();
            tokens.unwrap().recv().is_ok()
        });
        session
    }
}

pub fn listening(endpoint: &str) -> Network {
    Network {
        listen: vec![endpoint.to_owned()],
        ..Network::default()
    }
}

/// A gateway beside the daemon of an instance, whatever that is.
pub fn gateway(name: &str, network: Network, instance: &Instance) -> Until {
    let options = serve::Options {
        name: name.to_owned(),
        instance: instance.clone(),
        follow: Vec::new(),
    };
    Until::stopped(move |stop| serve::serve(&network, &options, &stop).unwrap())
}

pub fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().port()
}

/// A request with a path of two waypoints.
pub fn request(mode: Mode, request_id: u64) -> (RequestHeader, Vec<u64>) {
    let path = [0.0, 1.0, 2.0, 3.0].map(f64::to_bits);
    let header = RequestHeader {
        wire_version: taut_ipc::limits::WIRE_VERSION,
        header_len: size_of::<RequestHeader>() as u32,
        request_id,
        mode: mode.into(),
        waypoints: 2,
        variables: 2,
        path: Section {
            offset: 0,
            count: 4,
        },
        ..RequestHeader::default()
    };
    (header, path.to_vec())
}

pub fn message((header, words): &(RequestHeader, Vec<u64>)) -> ZBytes {
    let payload: &[u8] = bytemuck::cast_slice(words);
    join(header, &payload.into())
}

pub fn attachment(kind: EnvelopeKind, client: u64, request: u64) -> ZBytes {
    let envelope = Envelope {
        client,
        request,
        ..Envelope::default()
    };
    Sender::write(&envelope, kind, "test")
}

pub fn ask(session: &Session, attachment: ZBytes, payload: ZBytes) -> FifoChannelHandler<Reply> {
    session
        .get(names::optimize(NAME))
        .attachment(attachment)
        .payload(payload)
        .timeout(Duration::from_secs(20))
        .wait()
        .unwrap()
}

/// The answers that come until the end; `None` = the gateway does not know the request.
pub fn answers(replies: &FifoChannelHandler<Reply>) -> Vec<Option<(Code, Status)>> {
    let mut answers = Vec::new();
    while let Ok(reply) = replies.recv() {
        answers.push(reply.result().ok().map(|sample| {
            let (header, _): (ResponseHeader, Payload) = split(sample.payload()).unwrap();
            let code = Code::try_from(header.code).unwrap();
            (code, Status::try_from(header.status).unwrap())
        }));
    }
    answers
}

/// Lengths of the answers of a transport.
pub fn told(zenoh: &Zenoh, request: &(RequestHeader, Vec<u64>)) -> Vec<(Code, f64)> {
    let told = asked(zenoh, request)
        .into_iter()
        .map(|answered| {
            let code = Code::try_from(answered.header.code).unwrap();
            (code, answered.header.length_after)
        });
    told.collect()
}

/// The line of the last answer of a transport.
pub fn line(zenoh: &Zenoh, request: &(RequestHeader, Vec<u64>)) -> String {
    let last = asked(zenoh, request).pop().unwrap();
    let view = ResponseView::parse(last.header, bytemuck::cast_slice(&last.words));
    view.unwrap().message.to_owned()
}

/// The answers of a transport.
fn asked(zenoh: &Zenoh, request: &(RequestHeader, Vec<u64>)) -> Vec<Answered> {
    let (header, words) = request.clone();
    let (inbox, mut outcome) = answers_to(header.request_id);
    zenoh
        .send(Asked { header, words }, inbox)
        .unwrap();
    let next = || outcome.next(Duration::from_secs(60)).unwrap();
    std::iter::from_fn(next).collect()
}

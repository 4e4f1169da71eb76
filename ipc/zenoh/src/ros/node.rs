//! A node of a ROS graph, as rmw_zenoh's nodes see it.

use super::refusal::Refusal;
use crate::network::{Network, NetworkError, declared};
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use taut_ipc::wire::Code;
use taut_ros::cdr::{decode, encode};
use taut_ros::keys::{Attachment, Kind, Node, Topic};
use taut_ros::{Message, Service};
use zenoh::liveliness::LivelinessToken;
use zenoh::query::{ConsolidationMode, Query, QueryTarget};
use zenoh::sample::Sample;
use zenoh::{Session, Wait};

/// Its name in the graph.
pub(super) const NAME: &str = "taut";
/// Calls that are worked on at once; a client of a daemon has about as many in flight.
const MOST_CALLS: usize = 64;

/// The node, with its session.
#[derive(Debug)]
pub(super) struct Ros {
    session: Session,
    node: Node,
    entities: AtomicU32,
    /// Kept: undeclared, nobody sees what they stand for.
    tokens: Mutex<Vec<LivelinessToken>>,
    calls: AtomicUsize,
    /// Of requests that it sends.
    sequence: Mutex<i64>,
}

impl Ros {
    pub fn open(network: &Network, domain: u32) -> Result<Self, NetworkError> {
        let session = network.open()?;
        let node = Node {
            domain,
            session: session.zid().to_string(),
            name: NAME.to_owned(),
        };
        let ros = Self {
            session,
            node,
            entities: AtomicU32::new(1),
            tokens: Mutex::default(),
            calls: AtomicUsize::new(0),
            sequence: Mutex::default(),
        };
        ros.declare(ros.node.token())?;
        Ok(ros)
    }

    fn declare(&self, token: String) -> Result<(), NetworkError> {
        let liveliness = self.session.liveliness();
        let token = liveliness.declare_token(token).wait();
        let token = declared("a node's token", token)?;
        let mut tokens = self
            .tokens
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        tokens.push(token);
        Ok(())
    }

    fn declare_entity(&self, kind: Kind, topic: &Topic) -> Result<(), NetworkError> {
        let number = self.entities.fetch_add(1, Ordering::Relaxed);
        self.declare(self.node.entity(number, kind, topic))
    }

    /// Serves a service: each call on a thread of its own, so that a long one keeps nobody waiting.
    /// What cannot be read or begun is told to `work`, which knows how its replies say so.
    pub fn serve<S: Service + 'static>(
        self: &Arc<Self>,
        name: &str,
        work: impl Fn(Result<S::Request, Refusal>) -> S::Response + Send + Sync + 'static,
    ) -> Result<(), NetworkError> {
        let topic = Topic::of_service::<S>(name);
        let work = Arc::new(work);
        let ros = self.clone();
        let key = topic.any_key(self.node.domain);
        let queryable = self
            .session
            .declare_queryable(key)
            .complete(true)
            .callback(move |query| ros.called::<S, _>(query, &work))
            .background()
            .wait();
        declared("a service", queryable)?;
        // After it, so that whoever sees the token finds the service.
        self.declare_entity(Kind::Server, &topic)
    }

    fn called<S, F>(self: &Arc<Self>, query: Query, work: &Arc<F>)
    where
        S: Service + 'static,
        F: Fn(Result<S::Request, Refusal>) -> S::Response + Send + Sync + 'static,
    {
        let call = Call::begin(self);
        if call.is_one_too_many() {
            let text = format!("{MOST_CALLS} calls are worked on; ask again later");
            return replied::<S>(&query, &work(Err(Refusal::new(Code::Overloaded, text))));
        }
        let work = work.clone();
        std::thread::spawn(move || {
            let _call = call;
            let payload = query.payload().map(|bytes| bytes.to_bytes());
            let request = decode(payload.as_deref().unwrap_or_default());
            let refused = |error| Refusal::new(Code::MalformedRequest, format!("{error}"));
            replied::<S>(&query, &work(request.map_err(refused)));
        });
    }

    /// Hears of what is published.
    pub fn subscribe<M: Message>(
        &self,
        name: &str,
        take: impl Fn(&Sample) + Send + Sync + 'static,
    ) -> Result<(), NetworkError> {
        let topic = Topic::of_message::<M>(name);
        let subscriber = self
            .session
            .declare_subscriber(topic.any_key(self.node.domain))
            .callback(move |sample| take(&sample))
            .background()
            .wait();
        declared("a subscription", subscriber)?;
        self.declare_entity(Kind::Subscription, &topic)
    }

    /// Shows others that it calls a service.
    pub fn declare_client<S: Service>(&self, name: &str) -> Result<(), NetworkError> {
        self.declare_entity(Kind::Client, &Topic::of_service::<S>(name))
    }

    /// Calls a service; the first reply counts.
    ///
    /// # Errors
    /// In words: nobody answers within the time, or what comes cannot be read.
    pub fn call<S: Service>(
        &self,
        name: &str,
        request: &S::Request,
        patience: Duration,
    ) -> Result<S::Response, String> {
        // Servers of other distributions have another hash, and are complete for that alone.
        let key = Topic::of_service::<S>(name).any_key(self.node.domain);
        let payload = encode(request).map_err(|error| error.to_string())?;
        let replies = self
            .session
            .get(key)
            .target(QueryTarget::All)
            .consolidation(ConsolidationMode::None)
            .payload(payload)
            .attachment(self.attachment().bytes())
            .timeout(patience)
            .wait()
            .map_err(|error| error.to_string())?;
        let reply = replies
            .recv()
            .map_err(|_| format!("{name} has not answered"))?;
        let sample = reply
            .result()
            .map_err(|_| format!("{name} has not answered within {patience:?}"))?;
        decode(&sample.payload().to_bytes()).map_err(|error| format!("{name}: {error}"))
    }

    fn attachment(&self) -> Attachment {
        let mut sequence = self
            .sequence
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        *sequence += 1;
        Attachment {
            sequence: *sequence,
            sent_ns: now_ns(),
            gid: self.session.zid().to_le_bytes(),
        }
    }
}

/// A call that is worked on.
struct Call(Arc<Ros>, usize);

impl Call {
    fn begin(ros: &Arc<Ros>) -> Self {
        let before = ros.calls.fetch_add(1, Ordering::SeqCst);
        Self(ros.clone(), before)
    }

    fn is_one_too_many(&self) -> bool {
        self.1 >= MOST_CALLS
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        self.0.calls.fetch_sub(1, Ordering::SeqCst);
    }
}

/// A reply repeats its request's number and client, without which the client drops it.
fn replied<S: Service>(query: &Query, response: &S::Response) {
    let bytes = match encode(response) {
        Ok(bytes) => bytes,
        Err(error) => return tracing::error!("a reply cannot be written: {error}"),
    };
    let reply = query.reply(query.key_expr().clone(), bytes);
    let sent = match attached(query.attachment()) {
        Some(request) => reply
            .attachment(
                Attachment {
                    sent_ns: now_ns(),
                    ..request
                }
                .bytes(),
            )
            .wait(),
        None => reply.wait(),
    };
    if let Err(error) = sent {
        tracing::warn!("a reply is not sent: {error}");
    }
}

/// What travels beside a message.
pub(super) fn attached(bytes: Option<&zenoh::bytes::ZBytes>) -> Option<Attachment> {
    Attachment::read(&bytes?.to_bytes())
}

fn now_ns() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |time| i64::try_from(time.as_nanos()).unwrap_or(i64::MAX))
}

//! A ROS 2 node of the tests: it calls services, serves one, and publishes, through its own CDR.

use std::sync::atomic::{AtomicI64, Ordering};
use std::time::Duration;
use taut_ros::cdr::{decode, encode};
use taut_ros::keys::{Attachment, Topic};
use taut_ros::{Message, Service};
use taut_zenoh::Network;
use zenoh::query::{ConsolidationMode, QueryTarget, Reply};
use zenoh::{Session, Wait};

pub const PATIENCE: Duration = Duration::from_secs(60);
const GID: [u8; 16] = [7; 16];

pub struct Node {
    pub session: Session,
    sequence: AtomicI64,
}

impl Node {
    pub fn open(endpoint: &str) -> Self {
        Self {
            session: Network::to(&[endpoint]).open().unwrap(),
            sequence: AtomicI64::new(1),
        }
    }

    /// Counts as a publisher does.
    pub fn attachment(&self) -> Attachment {
        Attachment {
            sequence: self.sequence.fetch_add(1, Ordering::Relaxed),
            sent_ns: 1,
            gid: GID,
        }
    }

    /// Leaves out a number, as if a message had been lost.
    pub fn skip(&self) {
        self.attachment();
    }

    /// Calls as rmw_zenoh does; the reply repeats the request's number and client.
    pub fn call<S: Service>(&self, name: &str, request: &S::Request) -> S::Response {
        let bytes = encode(request).unwrap();
        decode(&self.call_raw::<S>(name, bytes)).unwrap()
    }

    pub fn call_raw<S: Service>(&self, name: &str, bytes: Vec<u8>) -> Vec<u8> {
        let sent = self.attachment();
        let reply = self.ask::<S>(name, bytes, sent);
        let sample = reply.result().unwrap();
        let attachment = sample.attachment().unwrap().to_bytes();
        let got = Attachment::read(&attachment).unwrap();
        assert_eq!((got.sequence, got.gid), (sent.sequence, sent.gid));
        sample.payload().to_bytes().into_owned()
    }

    fn ask<S: Service>(&self, name: &str, bytes: Vec<u8>, sent: Attachment) -> Reply {
        let replies = self
            .session
            .get(Topic::of_service::<S>(name).key(0))
            .target(QueryTarget::AllComplete)
            .consolidation(ConsolidationMode::None)
            .payload(bytes)
            .attachment(sent.bytes())
            .timeout(PATIENCE)
            .wait()
            .unwrap();
        replies.recv().expect("the service is there")
    }

    pub fn publish<M: Message>(&self, name: &str, message: &M) {
        let topic = Topic::of_message::<M>(name);
        self.session
            .put(topic.key(0), encode(message).unwrap())
            .attachment(self.attachment().bytes())
            .wait()
            .unwrap();
    }

    /// Serves until the session ends.
    pub fn serve<S: Service>(
        &self,
        name: &str,
        work: impl Fn(S::Request) -> S::Response + Send + Sync + 'static,
    ) {
        self.session
            .declare_queryable(Topic::of_service::<S>(name).key(0))
            .complete(true)
            .callback(move |query| {
                let request = decode(&query.payload().unwrap().to_bytes()).unwrap();
                let sent = query
                    .attachment()
                    .unwrap()
                    .to_bytes()
                    .into_owned();
                let reply = encode(&work(request)).unwrap();
                query
                    .reply(query.key_expr().clone(), reply)
                    .attachment(sent)
                    .wait()
                    .unwrap();
            })
            .background()
            .wait()
            .unwrap();
    }
}

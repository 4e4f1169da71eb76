//! One request on its way: the rules' actions among threads.

use super::shared::{Caller, Client};
use crate::call::{Action, Answer, Call, Event, Failure, Gateway, Lack, Nanos};
use crate::live::locked;
use crate::message::{self, Payload, Refused, UNKNOWN};
use crate::names::{self, Wish};
use std::collections::VecDeque;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;
use taut_ipc::limits::WIRE_VERSION;
use taut_ipc::monotonic_ns;
use taut_ipc::wire::{
    Code, Envelope, EnvelopeKind, RequestHeader, ResponseFlags, ResponseHeader, Status, WireError,
};
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::handlers::CallbackDrop;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{ConsolidationMode, Reply};

/// Longer than any request: the rules say when it ends.
const FOR_EVER: Duration = Duration::from_secs(7 * 24 * 3600);

/// Who gets the answers. Never waits.
pub trait Sink: Send + 'static {
    /// Takes an answer; the final one is the last.
    ///
    /// # Errors
    /// Bytes that are no answer.
    fn deliver(&mut self, header: &ResponseHeader, payload: &Payload) -> Result<(), WireError>;
}

/// A request until its final answer.
///
/// Replies come on Zenoh's threads and are delivered there. Whatever sends is left to the one that
/// drives the request: sending may have to wait for a link.
pub struct Running<S> {
    caller: Arc<Caller>,
    client: Arc<Client>,
    header: RequestHeader,
    payload: ZBytes,
    inner: Mutex<Inner<S>>,
    wake: Box<dyn Fn() + Send + Sync>,
}

struct Inner<S> {
    call: Call,
    sink: S,
    queued: VecDeque<Action>,
    /// The last proved improvement that was delivered.
    best: Option<(ResponseHeader, Payload)>,
}

impl Caller {
    /// Begins a request, which [`Running::drive`] sends. Its deadline is of this machine's clock;
    /// `wake` is called where it has to be driven again.
    pub fn call<S: Sink>(
        self: &Arc<Self>,
        client: &Arc<Client>,
        header: RequestHeader,
        payload: ZBytes,
        sink: S,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Arc<Running<S>> {
        let call = Call::new(&header, monotonic_ns());
        Arc::new(Running::new(
            self.clone(),
            client.clone(),
            header,
            payload,
            (call, sink),
            Box::new(wake),
        ))
    }
}

impl<S: Sink> Running<S> {
    fn new(
        caller: Arc<Caller>,
        client: Arc<Client>,
        header: RequestHeader,
        payload: ZBytes,
        (call, sink): (Call, S),
        wake: Box<dyn Fn() + Send + Sync>,
    ) -> Self {
        let inner = Inner {
            call,
            sink,
            queued: VecDeque::new(),
            best: None,
        };
        Self {
            caller,
            client,
            header,
            payload,
            inner: Mutex::new(inner),
            wake,
        }
    }

    /// Looks at the time and the gateways, and sends what is to be sent. Gives when to come again
    /// at the latest; `None` where it has ended.
    pub fn drive(self: &Arc<Self>) -> Option<Nanos> {
        self.handle(Event::Look);
        self.lock().call.next_look()
    }

    /// The caller wants the best so far.
    pub fn finish_early(self: &Arc<Self>) {
        self.handle(Event::Finish);
    }

    /// The caller does not want it any more.
    pub fn cancel(self: &Arc<Self>) {
        self.handle(Event::Cancel);
    }

    fn handle(self: &Arc<Self>, event: Event) {
        self.event(event, None);
        while let Some(action) = self.next_action() {
            self.act(action);
        }
    }

    /// Whether its final answer was delivered, or it was cancelled.
    pub fn is_ended(&self) -> bool {
        self.lock().call.is_ended()
    }

    /// Lets `look` see who gets the answers.
    pub fn with_sink<T>(&self, look: impl FnOnce(&mut S) -> T) -> T {
        look(&mut self.lock().sink)
    }

    fn lock(&self) -> MutexGuard<'_, Inner<S>> {
        locked(&self.inner)
    }

    fn next_action(&self) -> Option<Action> {
        self.lock().queued.pop_front()
    }

    /// Has the rules take an event; gives whether something is to be sent.
    fn event(&self, event: Event, answer: Option<(ResponseHeader, Payload)>) -> bool {
        let live = self.caller.live.now();
        let mut inner = self.lock();
        let late = inner.call.late();
        let actions = inner.call.handle(event, monotonic_ns(), &live);
        let newly_late = inner.call.late() - late;
        let count = &self.caller.late;
        count.fetch_add(newly_late.into(), Ordering::Relaxed);
        let mut answer = answer;
        for action in actions {
            match action {
                Action::Deliver => {
                    if let Some((header, payload)) = answer.take() {
                        inner.deliver(&self.caller, header, payload);
                    }
                }
                Action::Fail(failure) => inner.fail(failure, &self.caller, self.header.request_id),
                action => inner.queued.push_back(action),
            }
        }
        !inner.queued.is_empty()
    }

    fn act(self: &Arc<Self>, action: Action) {
        match action {
            Action::Send {
                gateway,
                query,
                left,
            } => self.send(&gateway, query, left),
            Action::Again { gateway, query } => {
                self.get(&gateway, query, EnvelopeKind::Again, ZBytes::new());
            }
            Action::Cancel(gateway) => self.wish(Wish::Cancel, &gateway),
            Action::Finish(gateway) => self.wish(Wish::Finish, &gateway),
            // Done where they came up.
            Action::Deliver | Action::Fail(_) => {}
        }
    }

    fn send(self: &Arc<Self>, gateway: &Gateway, query: u32, left: Option<Nanos>) {
        let header = RequestHeader {
            listener_id: [0; 2],
            deadline_ns: left.unwrap_or(0),
            ..self.header
        };
        if query > 0 {
            let daemon = &*gateway.name;
            let request = self.header.request_id;
            tracing::info!(request, daemon, "sent again");
            self.caller
                .resent
                .fetch_add(1, Ordering::Relaxed);
        }
        let message = message::join(&header, &self.payload);
        self.get(gateway, query, EnvelopeKind::Request, message);
    }

    fn get(self: &Arc<Self>, gateway: &Gateway, query: u32, kind: EnvelopeKind, message: ZBytes) {
        let for_reply = self.clone();
        let for_end = self.clone();
        let handler = CallbackDrop {
            callback: move |reply| for_reply.replied(query, &reply),
            drop: move || for_end.told(Event::Ended(query), None),
        };
        let sent = self
            .caller
            .session
            .get(names::optimize(&gateway.name))
            .attachment(self.attachment(query, kind))
            .payload(message)
            .consolidation(ConsolidationMode::None)
            .congestion_control(CongestionControl::Block)
            .priority(Priority::DataHigh)
            // A batch is not waited for: it would take its time limit, a millisecond.
            .express(true)
            .timeout(FOR_EVER)
            .with(handler)
            .wait();
        if let Err(error) = sent {
            let request = self.header.request_id;
            tracing::warn!(request, "a query was not sent: {error}");
        }
    }

    fn attachment(&self, query: u32, kind: EnvelopeKind) -> ZBytes {
        let (seen_version, seen_hash) = self.caller.seen.newest(self.header.scene_id);
        let envelope = Envelope {
            request: self.header.request_id,
            attempt: query,
            seen_version,
            seen_hash,
            ..Envelope::default()
        };
        self.client.attachment(kind, envelope)
    }

    /// On one of Zenoh's threads.
    fn replied(&self, query: u32, reply: &Reply) {
        match reply.result() {
            Ok(sample) => match checked(sample.payload()) {
                Ok(answer) => self.answered(query, answer),
                Err(error) => self.garbled(query, &error),
            },
            Err(error) if *error.payload().to_bytes() == *UNKNOWN => {
                self.told(Event::Unknown(query), None);
            }
            // Its time is over, or the link: the end of the replies follows.
            Err(_) => {}
        }
    }

    fn answered(&self, query: u32, answer: (ResponseHeader, Payload)) {
        let said = Answer::of(&answer.0);
        let asked = self.lock().call.asked(query).cloned();
        let lack = asked
            .as_ref()
            .filter(|_| said.is_final)
            .and_then(|asked| {
                let code = answer.0.code;
                self.caller
                    .lack(&self.client, asked, &self.header, code)
            });
        let answer = match (lack, asked) {
            (Some(Lack::Elsewhere), Some((gateway, _))) => self.elsewhere(&gateway),
            _ => answer,
        };
        self.told(
            Event::Answered(query, Answer { lack, ..said }),
            Some(answer),
        );
    }

    /// What is told where a scene that was there does not come back in time.
    fn elsewhere(&self, gateway: &Gateway) -> (ResponseHeader, Payload) {
        let name = &gateway.name;
        let line = format!(
            "{name} does not have the scene, which was answered for before: load it again, start its home again, or have {name} copy it (`taut-zenoh serve --follow HOME`)"
        );
        let refused = Refused::new(Code::UnknownScene, line);
        let (header, payload) = refused.response(self.header.request_id);
        (header, payload.into())
    }

    fn garbled(&self, query: u32, error: &WireError) {
        let refused = Refused::from(error.clone());
        let (header, payload) = refused.response(self.header.request_id);
        let said = Answer::of(&header);
        self.told(Event::Answered(query, said), Some((header, payload.into())));
    }

    fn told(&self, event: Event, answer: Option<(ResponseHeader, Payload)>) {
        if self.event(event, answer) {
            (self.wake)();
        }
    }

    fn wish(&self, wish: Wish, gateway: &Gateway) {
        let key = wish.key(&gateway.name, self.client.id(), self.header.request_id);
        let sent = self
            .caller
            .session
            .put(key, ZBytes::new())
            .congestion_control(CongestionControl::Block)
            .priority(Priority::DataHigh)
            .express(true)
            .wait();
        if let Err(error) = sent {
            tracing::warn!("a wish was not sent: {error}");
        }
    }
}

impl<S: Sink> Inner<S> {
    fn deliver(&mut self, caller: &Caller, header: ResponseHeader, payload: Payload) {
        caller
            .seen
            .note(header.scene_id, header.scene_version, header.scene_hash);
        if let Err(error) = self.sink.deliver(&header, &payload) {
            // What is no answer is none; the final one is said to be so.
            tracing::warn!(
                request = header.request_id,
                "an answer was dropped: {error}"
            );
            if Answer::of(&header).is_final {
                self.refuse(header.request_id, &error.into());
            }
            return;
        }
        if header.flags & ResponseFlags::PROVED != 0 {
            self.best = Some((header, payload));
        }
    }

    fn fail(&mut self, failure: Failure, caller: &Caller, request: u64) {
        if failure == Failure::TimedOut
            && let Some(best) = self.best.take()
            && self.is_told_as_final(&best)
        {
            return;
        }
        let refused = match failure {
            Failure::TimedOut => Refused::new(
                Code::TimedOut,
                "the deadline passed, and no answer came from a gateway",
            ),
            Failure::Lost => Refused::new(Code::DaemonLost, caller.live.nobody()),
        };
        self.refuse(request, &refused);
    }

    /// Delivers the best that came as the final answer. A path that fills a message leaves no room for
    /// the line that says so.
    fn is_told_as_final(&mut self, (header, payload): &(ResponseHeader, Payload)) -> bool {
        let line = "the link was lost before the final answer came; this is the best that came";
        [line, ""].into_iter().any(|line| {
            let (header, payload) = message::as_final(header, payload, line);
            self.sink.deliver(&header, &payload).is_ok()
        })
    }

    fn refuse(&mut self, request: u64, refused: &Refused) {
        let (header, payload) = refused.response(request);
        if let Err(error) = self.sink.deliver(&header, &payload.into()) {
            tracing::error!(request, "a refusal was not delivered: {error}");
        }
    }
}

/// What the rules look at is checked here; who takes the answer checks its sections.
fn checked(bytes: &ZBytes) -> Result<(ResponseHeader, Payload), WireError> {
    let (header, payload): (ResponseHeader, Payload) = message::split(bytes)?;
    if header.wire_version != WIRE_VERSION {
        return Err(WireError::Version(header.wire_version));
    }
    Status::try_from(header.status)?;
    Ok((header, payload))
}

#[cfg(test)]
mod tests {
    use super::*;
    use taut_ipc::limits::MAX_PAYLOAD;

    /// Takes what fits a message, as an attached instance does.
    #[derive(Default)]
    struct Fitting(Vec<usize>);

    impl Sink for Fitting {
        fn deliver(&mut self, _: &ResponseHeader, payload: &Payload) -> Result<(), WireError> {
            let (found, limit) = (payload.len(), MAX_PAYLOAD);
            if found > limit {
                return Err(WireError::PayloadSize { found, limit });
            }
            self.0.push(found);
            Ok(())
        }
    }

    #[test]
    fn the_best_that_came_is_the_answer_even_where_it_fills_a_message() {
        for bytes in [64, MAX_PAYLOAD] {
            let mut inner = Inner {
                call: Call::new(&RequestHeader::default(), 0),
                sink: Fitting::default(),
                queued: VecDeque::new(),
                best: None,
            };
            let best = (ResponseHeader::default(), vec![0; bytes].into());
            assert!(inner.is_told_as_final(&best));
            assert_eq!(inner.sink.0.len(), 1, "{bytes}");
        }
    }
}

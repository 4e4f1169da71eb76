//! Answers from this process instead of a daemon.

use super::link::{Link, Stream};
use super::prepared::Prepared;
use super::{Best, Columns, PlannerError};
use crate::client_error::ClientError;
use crate::control::{ControlReply, ControlRequest};
use crate::limits::RESPONSE_BUFFER;
use crate::wire::{RequestHeader, RequestView, ResponseBody, ResponseHeader, Status, WireError};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Takes an answer.
pub type Tell<'a> = dyn Fn(&ResponseHeader, &ResponseBody<'_>) + 'a;

/// Something in this process that answers as a daemon does.
pub trait Service: Send + Sync + std::fmt::Debug {
    /// Answers a control message.
    fn control(&self, message: ControlRequest) -> ControlReply;

    /// Answers a request on a thread of its own: improvements, and a final answer last. It ends
    /// soon once it is asked to.
    fn answer(&self, request: &RequestView<'_>, ending: &Ending, tell: &Tell<'_>);
}

impl<S: Service> Service for Arc<S> {
    fn control(&self, message: ControlRequest) -> ControlReply {
        (**self).control(message)
    }

    fn answer(&self, request: &RequestView<'_>, ending: &Ending, tell: &Tell<'_>) {
        (**self).answer(request, ending, tell);
    }
}

/// Whether a request is to end before it is done.
#[derive(Debug, Default)]
pub struct Ending(AtomicU8);

impl Ending {
    /// `Some(true)` where the best so far is wanted now, `Some(false)` where nobody waits for an
    /// answer any more.
    pub fn asked(&self) -> Option<bool> {
        match self.0.load(Ordering::Relaxed) {
            0 => None,
            asked => Some(asked == 1),
        }
    }
}

/// The way to a service of this process.
#[derive(Debug)]
pub(super) struct Here(Arc<dyn Service>);

impl Here {
    pub(super) fn new(service: impl Service + 'static) -> Self {
        Self(Arc::new(service))
    }
}

impl Link for Here {
    fn control(
        &self,
        message: &ControlRequest,
        _stop: &dyn Fn() -> bool,
    ) -> Result<ControlReply, ClientError> {
        self.control_once(message)
    }

    fn control_once(&self, message: &ControlRequest) -> Result<ControlReply, ClientError> {
        Ok(self.0.control(message.clone()))
    }

    fn boot_id(&self) -> Option<u64> {
        // This process is started once.
        Some(0)
    }

    fn send(&self, prepared: &Prepared, path: &[f64]) -> Result<Box<dyn Stream>, PlannerError> {
        let answering = Answering::start(&self.0, prepared, path)?;
        Ok(Box::new(answering))
    }
}

/// The stream of answers of a [`Service`]. Dropping it cancels the request.
#[derive(Debug)]
struct Answering {
    shared: Arc<Shared>,
    request_id: u64,
    finished: bool,
}

#[derive(Debug, Default)]
struct Shared {
    ending: Ending,
    answers: Mutex<Answered>,
    came: Condvar,
}

#[derive(Debug, Default)]
struct Answered {
    waiting: VecDeque<Best>,
    told: u32,
    broken: Option<WireError>,
    ended: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Answered> {
        self.answers
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

impl Answering {
    /// Has a service answer a request.
    fn start(
        service: &Arc<dyn Service>,
        prepared: &Prepared,
        path: &[f64],
    ) -> Result<Self, PlannerError> {
        let mut header = prepared.header;
        let body = prepared.sections.body();
        let columns = prepared.columns.clone();
        let numbers = crate::wire::request::path_numbers(header.waypoints, header.variables)?;
        let bytes = body.lay_out(&mut header, numbers);
        header.wire_version = crate::limits::WIRE_VERSION;
        header.header_len = size_of::<RequestHeader>() as u32;
        header.request_id = crate::time::unique_number();
        let mut words = vec![0_u64; bytes.div_ceil(8)];
        let payload: &mut [u8] = bytemuck::cast_slice_mut(&mut words);
        body.write(&header, payload);
        columns.write(path, bytemuck::cast_slice_mut(&mut payload[..numbers * 8]));
        let shared = Arc::new(Shared::default());
        let service = service.clone();
        let for_thread = shared.clone();
        let work = move || work(&*service, header, &words, &for_thread, &columns);
        std::thread::Builder::new()
            .name("taut-local".into())
            .spawn(work)
            .map_err(|error| ClientError::transport("a thread for the request", error))?;
        Ok(Self {
            shared,
            request_id: header.request_id,
            finished: false,
        })
    }
}

impl Stream for Answering {
    fn request_id(&self) -> u64 {
        self.request_id
    }

    fn next(
        &mut self,
        timeout: Duration,
        _columns: &Arc<Columns>,
    ) -> Result<Option<Best>, ClientError> {
        if self.finished {
            return Ok(None);
        }
        let end = Instant::now() + timeout;
        let mut answered = self.shared.lock();
        loop {
            if let Some(best) = answered.waiting.pop_front() {
                self.finished = best.is_final();
                return Ok(Some(best));
            }
            if answered.ended {
                self.finished = true;
                return Err(answered
                    .broken
                    .take()
                    .map_or(ClientError::NoAnswer, ClientError::Wire));
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(ClientError::Timeout(timeout));
            }
            answered = self
                .shared
                .came
                .wait_timeout(answered, left)
                .unwrap_or_else(PoisonError::into_inner)
                .0;
        }
    }

    fn finish_early(&self) {
        // Who is cancelled is not asked for an answer any more.
        let _ = self
            .shared
            .ending
            .0
            .compare_exchange(0, 1, Ordering::Relaxed, Ordering::Relaxed);
    }

    fn sent(&self, _columns: &Columns) -> Option<Vec<f64>> {
        None
    }
}

impl Drop for Answering {
    fn drop(&mut self) {
        self.shared.ending.0.store(2, Ordering::Relaxed);
    }
}

fn work(
    service: &dyn Service,
    header: RequestHeader,
    words: &[u64],
    shared: &Shared,
    columns: &Arc<Columns>,
) {
    let tell = |answer: &ResponseHeader, body: &ResponseBody<'_>| {
        if shared.ending.asked() == Some(false) {
            return;
        }
        let mut answered = shared.lock();
        let answer = ResponseHeader {
            request_id: header.request_id,
            seq: answered.told,
            ..*answer
        };
        answered.told += 1;
        match Best::made(&answer, body, columns.clone()) {
            Ok(best) => {
                // As of a daemon: who does not read has the newest.
                if answered.waiting.len() == RESPONSE_BUFFER {
                    answered.waiting.pop_front();
                }
                answered.waiting.push_back(best);
            }
            Err(error) => answered.broken = Some(error),
        }
        answered.ended |= answer.status == u32::from(Status::Final);
        shared.came.notify_all();
    };
    let _end = End(shared);
    match RequestView::parse(header, bytemuck::cast_slice(words)) {
        Ok(view) => service.answer(&view, &shared.ending, &tell),
        Err(error) => shared.lock().broken = Some(error),
    }
}

/// Ends the stream when it is dropped, also by a panic of the service: who waits is not left
/// waiting.
struct End<'a>(&'a Shared);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.lock().ended = true;
        self.0.came.notify_all();
    }
}

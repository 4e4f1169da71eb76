//! Who answers a planner without a thread of its own for each request, and where the answers go.

use crate::client_error::ClientError;
use crate::control::{ControlReply, ControlRequest};
use crate::limits::{RESPONSE_BUFFER, WIRE_VERSION};
use crate::wire::{RequestHeader, RequestView, ResponseBody, ResponseHeader, Status, WireError};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::Thread;
use std::time::{Duration, Instant};

/// Something that has requests answered elsewhere.
pub trait Carrier: Send + Sync + std::fmt::Debug {
    /// Answers a control message.
    fn control(&self, message: ControlRequest) -> ControlReply;

    /// Sends a request on and does not wait for its answers: improvements, and a final one last.
    ///
    /// # Errors
    /// What keeps it from being sent.
    fn send(&self, asked: Asked, inbox: Inbox) -> Result<(), ClientError>;
}

/// A request: a header, and sections in memory that is aligned as the wire asks for.
#[derive(Clone, Debug)]
pub struct Asked {
    /// The header.
    pub header: RequestHeader,
    /// The sections.
    pub words: Vec<u64>,
}

impl Asked {
    /// The sections as bytes.
    pub fn payload(&self) -> &[u8] {
        bytemuck::cast_slice(&self.words)
    }

    /// The request, checked.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn view(&self) -> Result<RequestView<'_>, WireError> {
        RequestView::parse(self.header, self.payload())
    }
}

/// An answer: a header, and sections in memory that is aligned as the wire asks for.
#[derive(Clone, Debug)]
pub struct Answered {
    /// The header.
    pub header: ResponseHeader,
    /// The sections.
    pub words: Vec<u64>,
}

impl Answered {
    /// Of these parts.
    ///
    /// # Errors
    /// [`WireError::PayloadSize`] if no daemon could send it.
    pub fn made(header: &ResponseHeader, body: &ResponseBody<'_>) -> Result<Self, WireError> {
        let mut header = ResponseHeader {
            wire_version: WIRE_VERSION,
            header_len: size_of::<ResponseHeader>() as u32,
            ..*header
        };
        let bytes = body.lay_out(&mut header)?;
        let mut words = vec![0_u64; bytes.div_ceil(8)];
        body.write(&header, bytemuck::cast_slice_mut(&mut words));
        Ok(Self { header, words })
    }
}

/// Whether a request is to end before it is done.
#[derive(Debug, Default)]
pub struct Ending {
    asked: AtomicU8,
    sleeper: Mutex<Option<Thread>>,
}

impl Ending {
    /// `Some(true)` where the best so far is wanted now, `Some(false)` where nobody waits for an
    /// answer any more.
    pub fn asked(&self) -> Option<bool> {
        match self.asked.load(Ordering::Relaxed) {
            0 => None,
            asked => Some(asked == 1),
        }
    }

    /// Has a thread unparked when something is asked for.
    pub fn wakes(&self, thread: Thread) {
        *self.sleeper() = Some(thread);
    }

    fn sleeper(&self) -> MutexGuard<'_, Option<Thread>> {
        self.sleeper
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    fn wake(&self) {
        if let Some(thread) = &*self.sleeper() {
            thread.unpark();
        }
    }

    /// Who is cancelled is not asked for an answer any more.
    fn ask_for_best(&self) {
        let order = Ordering::Relaxed;
        let _ = self.asked.compare_exchange(0, 1, order, order);
        self.wake();
    }

    fn cancel(&self) {
        self.asked.store(2, Ordering::Relaxed);
        self.wake();
    }
}

#[derive(Debug, Default)]
struct Shared {
    ending: Ending,
    answers: Mutex<Waiting>,
    came: Condvar,
}

#[derive(Debug, Default)]
struct Waiting {
    answers: VecDeque<Answered>,
    told: u32,
    broken: Option<WireError>,
    ended: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.answers
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

/// Where the answers to a request go. Dropping it says that no more come, also by a panic of who
/// answers.
#[derive(Debug)]
pub struct Inbox {
    shared: Arc<Shared>,
    request_id: u64,
}

/// Who reads the answers to a request. Dropping it cancels the request.
#[derive(Debug)]
pub struct Outcome {
    shared: Arc<Shared>,
    finished: bool,
}

/// Both ends of the answers to a request.
pub fn answers(request_id: u64) -> (Inbox, Outcome) {
    let shared = Arc::new(Shared::default());
    let outcome = Outcome {
        shared: shared.clone(),
        finished: false,
    };
    (Inbox { shared, request_id }, outcome)
}

impl Inbox {
    /// Whether the request is to end before it is done.
    pub fn ending(&self) -> &Ending {
        &self.shared.ending
    }

    /// Puts an answer in. As of a daemon: who does not read has the newest, and its sections are
    /// checked when they are looked at.
    ///
    /// # Errors
    /// A status that is none: it is not put in.
    pub fn put(&self, answered: Answered) -> Result<(), WireError> {
        let Answered { header, words } = answered;
        let status = Status::try_from(header.status)?;
        let mut waiting = self.shared.lock();
        let header = ResponseHeader {
            request_id: self.request_id,
            seq: waiting.told,
            ..header
        };
        waiting.told += 1;
        if waiting.answers.len() == RESPONSE_BUFFER {
            waiting.answers.pop_front();
        }
        waiting
            .answers
            .push_back(Answered { header, words });
        waiting.ended |= status == Status::Final;
        drop(waiting);
        self.shared.came.notify_all();
        Ok(())
    }

    /// The stream ends with this error.
    pub fn broke(&self, error: WireError) {
        self.shared.lock().broken = Some(error);
    }
}

impl Drop for Inbox {
    fn drop(&mut self) {
        let was_ended = std::mem::replace(&mut self.shared.lock().ended, true);
        if !was_ended {
            self.shared.came.notify_all();
        }
    }
}

impl Outcome {
    /// The next answer; `None` after the final one.
    ///
    /// # Errors
    /// [`ClientError::Timeout`]; what broke the stream, [`ClientError::NoAnswer`] where it ended
    /// without a final answer.
    pub fn next(&mut self, timeout: Duration) -> Result<Option<Answered>, ClientError> {
        if self.finished {
            return Ok(None);
        }
        let end = Instant::now() + timeout;
        let mut waiting = self.shared.lock();
        loop {
            if let Some(answered) = waiting.answers.pop_front() {
                self.finished = answered.header.status == u32::from(Status::Final);
                return Ok(Some(answered));
            }
            if waiting.ended {
                self.finished = true;
                let broken = waiting.broken.take();
                return Err(broken.map_or(ClientError::NoAnswer, ClientError::Wire));
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(ClientError::Timeout(timeout));
            }
            waiting = self
                .shared
                .came
                .wait_timeout(waiting, left)
                .unwrap_or_else(PoisonError::into_inner)
                .0;
        }
    }

    /// Asks for the best so far, now.
    pub fn finish_early(&self) {
        self.shared.ending.ask_for_best();
    }
}

impl Drop for Outcome {
    fn drop(&mut self) {
        // Nobody is woken for a request that is over.
        if !self.finished {
            self.shared.ending.cancel();
        }
    }
}

//! One request of a client process, from its path to its count.

use std::time::Duration;

use taut_ipc::client::LoanedRequest;
use taut_ipc::wire::{Code, Mode, RequestBody, RequestFlags, RequestHeader, ResponseHeader};
use taut_ipc::{Client, ClientError, Pending, Response, monotonic_ns};

use super::orders::{Job, Pace, Window};
use super::tally::{Ending, Loss, Tally};

/// How long a request may take beyond its deadline before it counts as lost.
const PATIENCE_NS: u64 = 60_000_000_000;
/// How long a client waits before it tries again to reach a daemon that is gone.
const LOST_PAUSE: Duration = Duration::from_millis(5);
/// How often a wait looks up.
const LOOK_UP: Duration = Duration::from_secs(1);

fn is_other_scene(header: &ResponseHeader, job: &Job) -> bool {
    header.scene_version != 0 && header.scene_hash != job.scene_hash
}

/// When things happened to a request (ns).
#[derive(Clone, Copy)]
struct Times {
    arrived_ns: u64,
    sent_ns: u64,
    /// 0 = none.
    deadline_ns: u64,
}

/// Sends requests of one window and counts them.
pub(super) struct Asker<'a> {
    client: &'a Client,
    jobs: &'a [Job],
    window: &'a Window,
    random: fastrand::Rng,
    next: usize,
    /// What came of them so far.
    pub tally: Tally,
}

impl<'a> Asker<'a> {
    /// Nothing sent yet.
    pub(super) fn new(
        client: &'a Client,
        jobs: &'a [Job],
        window: &'a Window,
        number: u64,
    ) -> Self {
        let random = fastrand::Rng::with_seed(
            window
                .seed
                .wrapping_mul(0x9e37_79b9)
                .wrapping_add(number),
        );
        Self {
            client,
            jobs,
            window,
            random,
            next: (window.seed.wrapping_add(number) % jobs.len().max(1) as u64) as usize,
            tally: Tally::default(),
        }
    }

    /// From 0 to less than 1.
    pub(super) fn random(&mut self) -> f64 {
        self.random.f64()
    }

    /// The job of the next request.
    pub(super) fn choose(&mut self) -> usize {
        if self.window.in_order {
            self.next = (self.next + 1) % self.jobs.len();
            return self.next;
        }
        self.random.usize(..self.jobs.len())
    }

    /// Sends the next request now and waits for its end; tells how long to wait before the one
    /// after.
    pub(super) fn ask_next(&mut self) -> Duration {
        let job = self.choose();
        self.ask(job, monotonic_ns())
    }

    /// Sends a request for a job that arrived then, and waits for its end.
    pub(super) fn ask(&mut self, job: usize, arrived_ns: u64) -> Duration {
        let deadline_ns = match self.window.deadline_ns {
            0 => 0,
            time_ns => arrived_ns + time_ns,
        };
        let times = Times {
            arrived_ns,
            sent_ns: monotonic_ns(),
            deadline_ns,
        };
        self.end(job, times, |header| header.deadline_ns = deadline_ns)
    }

    /// Sends a request with a changed header, waits for its end and counts it.
    fn end(
        &mut self,
        job: usize,
        times: Times,
        change: impl FnOnce(&mut RequestHeader),
    ) -> Duration {
        self.tally.sent += 1;
        let request = self.loan_with(job, change);
        match request.and_then(LoanedRequest::send) {
            Ok(pending) => self.wait(pending, job, times),
            Err(error) => {
                self.tally.refuse(error.code());
                LOST_PAUSE
            }
        }
    }

    /// Memory for a request, with its path in it.
    pub(super) fn loan(&mut self, job: usize) -> Result<LoanedRequest, ClientError> {
        self.loan_with(job, |_| ())
    }

    fn loan_with(
        &mut self,
        job: usize,
        change: impl FnOnce(&mut RequestHeader),
    ) -> Result<LoanedRequest, ClientError> {
        let header = self.header(job);
        let job = &self.jobs[job];
        let body = RequestBody {
            weights: &job.weights,
            ..RequestBody::default()
        };
        let request = self
            .client
            .request(job.waypoints(), job.variables);
        let mut builder = request.with_body(body);
        builder.header = header;
        change(&mut builder.header);
        let mut loan = builder.loan()?;
        loan.path_mut().copy_from_slice(&job.path);
        self.tally.bytes[0] += size_of_val(&*job.path) as u64;
        Ok(loan)
    }

    fn header(&self, job: usize) -> RequestHeader {
        let window = self.window;
        RequestHeader {
            mode: window.mode,
            work_budget: window.budget,
            flags: window.flags,
            seed: window.request_seed.unwrap_or(job as u64),
            ..self.jobs[job].header()
        }
    }

    /// Waits for the end of a request; tells how long to wait before the next.
    fn wait(&mut self, mut pending: Pending, job: usize, times: Times) -> Duration {
        let give_up_ns = times.sent_ns.max(times.deadline_ns) + PATIENCE_NS;
        loop {
            match pending.next(LOOK_UP) {
                Ok(Some(response)) if response.is_final() => {
                    return self.ended(&response, job, times);
                }
                Ok(Some(_)) => self.tally.improvements += 1,
                Err(ClientError::Timeout(_)) if monotonic_ns() < give_up_ns => (),
                Err(ClientError::DaemonLost { .. }) => return self.cut_off(times.sent_ns),
                Ok(None) | Err(_) => {
                    self.tally.lost += 1;
                    return LOST_PAUSE;
                }
            }
        }
    }

    /// Counts a final response; tells when to try again.
    fn ended(&mut self, response: &Response, job: usize, times: Times) -> Duration {
        let ended_ns = monotonic_ns();
        let header = response.header();
        let served = self.tally.served;
        self.tally.end(&Ending {
            job: job as u64,
            arrived_ns: times.arrived_ns,
            sent_ns: times.sent_ns,
            ended_ns,
            deadline_ns: times.deadline_ns,
            header,
            path: response.path(),
        });
        if is_other_scene(header, &self.jobs[job]) {
            self.tally.other_scene += 1;
        }
        if matches!(self.window.pace, Pace::Cancel { .. }) {
            self.freed(ended_ns - times.arrived_ns, header);
        }
        if self.tally.served > served {
            self.tally.recovered(ended_ns);
        }
        Duration::from_millis(header.retry_after_ms.into())
    }

    /// Counts how long a cancelled request kept its worker.
    fn freed(&mut self, waited_ns: u64, header: &ResponseHeader) {
        let free_ns = waited_ns.saturating_sub(header.compute_ns);
        self.tally.cancel.add(free_ns);
    }

    /// Counts a request whose daemon went away.
    fn cut_off(&mut self, sent_ns: u64) -> Duration {
        self.tally.refuse(Code::DaemonLost);
        self.tally.losses.push(Loss {
            sent_ns,
            known_ns: monotonic_ns(),
            good_ns: 0,
        });
        LOST_PAUSE
    }

    /// Sends the next request, cancels it after a random time, and then has the same path checked:
    /// the answer to that says when the daemon had a worker free.
    pub(super) fn cancel_next(&mut self, within_ns: u64) {
        let job = self.choose();
        let after = Duration::from_nanos(self.random.u64(..within_ns.max(1)));
        match self.loan(job).and_then(LoanedRequest::send) {
            Ok(pending) => {
                std::thread::sleep(after);
                drop(pending);
                self.check_after(job, monotonic_ns());
            }
            Err(error) => {
                self.tally.sent += 1;
                self.tally.refuse(error.code());
            }
        }
    }

    fn check_after(&mut self, job: usize, cancelled_ns: u64) {
        let times = Times {
            arrived_ns: cancelled_ns,
            sent_ns: cancelled_ns,
            deadline_ns: 0,
        };
        self.end(job, times, |header| {
            header.mode = Mode::Check.into();
            header.seed = 0;
            header.flags |= RequestFlags::WITHOUT_CONTACTS;
        });
    }
}

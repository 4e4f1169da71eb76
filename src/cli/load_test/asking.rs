//! One request of a client process, from its path to its count.

use std::time::Duration;

use taut_ipc::client::LoanedRequest;
use taut_ipc::wire::{Mode, RequestBody, RequestFlags, RequestHeader};
use taut_ipc::{Client, ClientError, Pending, monotonic_ns};

use super::orders::{Job, Pace, Window};
use super::tally::{Ending, Loss, Tally};

/// How long a request may take beyond its deadline before it counts as lost.
const PATIENCE_NS: u64 = 60_000_000_000;
/// How long a client waits before it tries again to reach a daemon that is gone.
const LOST_PAUSE: Duration = Duration::from_millis(5);
/// How often a wait looks up.
const LOOK_UP: Duration = Duration::from_secs(1);

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
        let random =
            fastrand::Rng::with_seed(window.seed.wrapping_mul(0x9e37_79b9).wrapping_add(number));
        Self {
            client,
            jobs,
            window,
            random,
            next: number as usize,
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
        self.tally.sent += 1;
        let sent_ns = monotonic_ns();
        let deadline_ns = if self.window.deadline_ns == 0 {
            0
        } else {
            arrived_ns + self.window.deadline_ns
        };
        let request = self.loan_with(job, |header| header.deadline_ns = deadline_ns);
        let sent = request.and_then(LoanedRequest::send);
        match sent {
            Ok(pending) => self.wait(pending, job, [arrived_ns, sent_ns, deadline_ns]),
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
        let window = self.window;
        let number = job as u64;
        let job = &self.jobs[job];
        let body = RequestBody {
            weights: &job.weights,
            ..RequestBody::default()
        };
        let mut builder = self
            .client
            .request(job.waypoints(), job.variables)
            .with_body(body);
        builder.header = RequestHeader {
            mode: window.mode,
            work_budget: window.budget,
            flags: window.flags,
            seed: window.request_seed.unwrap_or(number),
            ..job.header()
        };
        change(&mut builder.header);
        let mut loan = builder.loan()?;
        loan.path_mut().copy_from_slice(&job.path);
        self.tally.bytes[0] += size_of_val(&*job.path) as u64;
        Ok(loan)
    }

    fn wait(
        &mut self,
        mut pending: Pending,
        job: usize,
        [arrived_ns, sent_ns, deadline_ns]: [u64; 3],
    ) -> Duration {
        let give_up_ns = sent_ns.max(deadline_ns) + PATIENCE_NS;
        loop {
            match pending.next(LOOK_UP) {
                Ok(Some(response)) if response.is_final() => {
                    let ended_ns = monotonic_ns();
                    let header = response.header();
                    let ending = Ending {
                        job: job as u64,
                        arrived_ns,
                        sent_ns,
                        ended_ns,
                        deadline_ns,
                        header,
                        path: response.path(),
                    };
                    let served = self.tally.served;
                    self.tally.end(&ending);
                    if header.scene_version != 0 && header.scene_hash != self.jobs[job].scene_hash {
                        self.tally.other_scene += 1;
                    }
                    if matches!(self.window.pace, Pace::Cancel { .. }) {
                        self.tally
                            .cancel
                            .add((ended_ns - arrived_ns).saturating_sub(header.compute_ns));
                    }
                    if self.tally.served > served {
                        self.tally
                            .losses
                            .iter_mut()
                            .filter(|loss| loss.good_ns == 0)
                            .for_each(|l| l.good_ns = ended_ns);
                    }
                    return Duration::from_millis(header.retry_after_ms.into());
                }
                Ok(Some(_)) => self.tally.improvements += 1,
                Err(ClientError::Timeout(_)) if monotonic_ns() < give_up_ns => (),
                Err(error @ ClientError::DaemonLost { .. }) => {
                    self.tally.refuse(error.code());
                    self.tally.losses.push(Loss {
                        sent_ns,
                        known_ns: monotonic_ns(),
                        good_ns: 0,
                    });
                    return LOST_PAUSE;
                }
                Ok(None) | Err(_) => {
                    self.tally.lost += 1;
                    return LOST_PAUSE;
                }
            }
        }
    }

    /// Sends the next request, cancels it after a random time, and then has the same path checked:
    /// the answer to that says when the daemon had a worker free.
    pub(super) fn cancel_next(&mut self, within_ns: u64) {
        let job = self.choose();
        let after = Duration::from_nanos(self.random.u64(..within_ns.max(1)));
        let sent = self.loan(job).and_then(LoanedRequest::send);
        let pending = match sent {
            Ok(pending) => pending,
            Err(error) => {
                self.tally.sent += 1;
                return self.tally.refuse(error.code());
            }
        };
        std::thread::sleep(after);
        drop(pending);
        let cancelled_ns = monotonic_ns();
        self.tally.sent += 1;
        let check = self.loan_with(job, |header| {
            header.mode = Mode::Check.into();
            header.seed = 0;
            header.flags |= RequestFlags::WITHOUT_CONTACTS;
        });
        let sent_ns = monotonic_ns();
        match check.and_then(LoanedRequest::send) {
            Ok(pending) => _ = self.wait(pending, job, [cancelled_ns, sent_ns, 0]),
            Err(error) => self.tally.refuse(error.code()),
        }
    }
}

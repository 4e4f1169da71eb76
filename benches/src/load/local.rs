//! The same requests in this process, on one thread: what they cost without a daemon.

use std::time::{Duration, Instant};

use taut::optimize::{Mode, Settings, Workspace};

use super::problems::Problem;
use crate::clock::thread_cpu;

/// What the optimizer does with these problems in this process.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Local {
    /// Requests computed.
    pub count: u64,
    /// CPU time of the thread (s).
    pub cpu_s: f64,
    /// Time on the clock (s).
    pub time_s: f64,
}

impl Local {
    /// CPU time of one request (s).
    pub(super) fn cpu_each(&self) -> f64 {
        self.cpu_s / self.count.max(1) as f64
    }

    /// Requests per second.
    pub(super) fn rate(&self) -> f64 {
        self.count as f64 / self.time_s.max(1e-9)
    }
}

/// The optimizer in this process; one thread, warm.
#[derive(Default)]
pub(super) struct Bench {
    workspace: Workspace,
    next: usize,
}

impl Bench {
    /// Computes one problem after another, round and round, for so long and to the end of the round.
    pub(super) fn run(
        &mut self,
        problems: &[Problem],
        mode: Mode,
        budget: u64,
        length: Duration,
    ) -> Local {
        let start = Instant::now();
        let cpu = thread_cpu();
        let mut count = 0;
        loop {
            // The daemon makes each answer too; what it costs to drop it belongs to the request.
            count += u64::from(self.next_one(problems, mode, budget));
            if self.next == 0 && start.elapsed() >= length {
                break;
            }
        }
        Local {
            count,
            cpu_s: thread_cpu() - cpu,
            time_s: start.elapsed().as_secs_f64(),
        }
    }

    /// Whether the next problem has an answer.
    fn next_one(&mut self, problems: &[Problem], mode: Mode, budget: u64) -> bool {
        self.next = (self.next + 1) % problems.len();
        let problem = &problems[self.next];
        let settings = Settings {
            mode,
            seed: self.next as u64,
            weights: problem.weights.clone(),
            work_budget: budget,
            ..Settings::default()
        };
        let answer = taut::optimize::run(
            &problem.model,
            &problem.path,
            &settings,
            &mut self.workspace,
            &mut || false,
            &mut |_| (),
        );
        answer.is_ok()
    }
}

//! Half of the clients are stopped (SIGSTOP) in the middle of their streams.

use std::time::Duration;

use rustix::process::Signal;
use taut::optimize::Mode;
use taut_ipc::monotonic_ns;

use super::row::Row;
use super::trial::{Trial, disturbed_over_calm, median, run};
use crate::error::Error;
use crate::load::fleet::Fleet;
use crate::load::orders::{Window, wire_mode};
use crate::load::site::Site;
use crate::load::tally::Tally;

const HALF: usize = 4;
/// From the beginning of a window until its requests are on their way.
const INTO_THE_STREAM: Duration = Duration::from_micros(500);
/// How long nobody reads before the readers are measured.
const UNREAD: Duration = Duration::from_millis(300);

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let site = Site::of_workers(2)?;
    let mut halves = Halves {
        readers: Fleet::start(site.instance(), &site.jobs, 0, HALF)?,
        stopped: Fleet::start(site.instance(), &site.jobs, HALF, HALF)?,
        length: trial.pick(Duration::from_secs(1), Duration::from_secs(2)),
        read: Tally::default(),
        late: Tally::default(),
    };
    let mut ratios = Vec::new();
    for number in 0..trial.windows() {
        let window = trial.window(number);
        ratios.push(disturbed_over_calm(number, |is_stopped| {
            halves.p99(window, is_stopped)
        })?);
    }
    Ok(vec![
        Row::none("daemon exits", u64::from(!site.is_alive())),
        halves.read.unserved("readers' requests"),
        Row::none(
            format!(
                "of {} stopped requests, without their final answer",
                halves.late.sent
            ),
            halves.late.sent - halves.late.served,
        ),
        Row::at_most(
            "readers' p99, with half stopped / without",
            1.1,
            median(&ratios),
        ),
    ])
}

/// Those that read and those that are stopped.
struct Halves {
    readers: Fleet,
    stopped: Fleet,
    length: Duration,
    /// What came of the readers' requests.
    read: Tally,
    /// What came of the others', once they went on.
    late: Tally,
}

impl Halves {
    /// The readers' p99 in a window (s).
    fn p99(&mut self, window: Window, is_stopped: bool) -> Result<f64, Error> {
        if is_stopped {
            self.stop(window)?;
        }
        let tally = run(&mut self.readers, window, self.length)?;
        if is_stopped {
            self.go_on()?;
        }
        self.read.merge(&tally);
        Ok(tally.latency.quantile(0.99))
    }

    /// Stops half of the clients while they stream: more improvements than fit the buffer of a client
    /// that does not read.
    fn stop(&mut self, window: Window) -> Result<(), Error> {
        let stream = Window {
            mode: wire_mode(Mode::RandomShortcut),
            budget: 0,
            count: 1,
            ..window
        };
        let begun = self.stopped.begin(stream, self.length)?;
        let left_ns = begun.start_ns.saturating_sub(monotonic_ns());
        std::thread::sleep(Duration::from_nanos(left_ns) + INTO_THE_STREAM);
        self.signal(Signal::STOP);
        // Their requests are then computed, and nobody reads the answers.
        std::thread::sleep(UNREAD);
        Ok(())
    }

    fn go_on(&mut self) -> Result<(), Error> {
        self.signal(Signal::CONT);
        let tallies = self.stopped.finish(self.length)?;
        self.late.merge(&Tally::of(&tallies));
        Ok(())
    }

    fn signal(&self, signal: Signal) {
        for member in &self.stopped.0 {
            member.signal(signal);
        }
    }
}

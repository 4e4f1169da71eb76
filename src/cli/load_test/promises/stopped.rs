//! Half of the clients are stopped (SIGSTOP) in the middle of their streams.

use std::time::Duration;

use rustix::process::Signal;
use taut::optimize::Mode;

use super::row::Row;
use super::trial::{Trial, median, ratio};
use crate::cli::error::CliError;
use crate::cli::load_test::fleet::{Fleet, timed};
use crate::cli::load_test::orders::{Order, Window};
use crate::cli::load_test::site::{Setup, Site};
use crate::cli::load_test::tally::Tally;
use crate::cli::load_test::wire_mode;

const HALF: usize = 4;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, CliError> {
    let site = Site::own(&Setup {
        workers: 2,
        ..Setup::default()
    })?;
    let mut readers = Fleet::start(site.instance(), &site.jobs, 0, HALF)?;
    let mut stopped = Fleet::start(site.instance(), &site.jobs, HALF, HALF)?;
    let length = trial.pick(Duration::from_secs(1), Duration::from_secs(2));
    let mut ratios = Vec::new();
    let mut all = Tally::default();
    let mut late = Tally::default();
    for number in 0..trial.windows() {
        let mut p99 = [0.0; 2];
        for turn in [number % 2, 1 - number % 2] {
            // A stream of many improvements: more than fit the buffer of a client that does not
            // read.
            let stream = Window {
                mode: wire_mode(Mode::RandomShortcut),
                budget: 0,
                count: 1,
                ..trial.window(number)
            };
            if turn == 1 {
                let stream = timed(stream, length);
                for member in &mut stopped.0 {
                    member.tell(&Order::Run(stream))?;
                }
                std::thread::sleep(Duration::from_nanos(
                    stream.start_ns.saturating_sub(taut_ipc::monotonic_ns()),
                ));
                std::thread::sleep(Duration::from_micros(500));
                stopped
                    .0
                    .iter()
                    .for_each(|member| member.signal(Signal::STOP));
                // Their requests are then computed, and nobody reads the answers.
                std::thread::sleep(Duration::from_millis(300));
            }
            let window = trial.window(number);
            let tally = Tally::of(&readers.run(window, length)?);
            p99[turn] = tally.latency.quantile(0.99);
            all.merge(&tally);
            if turn == 1 {
                stopped
                    .0
                    .iter()
                    .for_each(|member| member.signal(Signal::CONT));
                late.merge(&Tally::of(&stopped.finish(length)?));
            }
        }
        ratios.push(ratio(p99[1], p99[0]));
    }
    Ok(vec![
        Row::none("daemon exits", u64::from(!site.is_alive())),
        Row::none(
            format!("of {} readers' requests, without a proved answer", all.sent),
            all.sent - all.served,
        ),
        Row::none(
            format!(
                "of {} stopped requests, without their final answer",
                late.sent
            ),
            late.sent - late.served,
        ),
        Row::at_most(
            "readers' p99, with half stopped / without",
            1.1,
            median(&ratios),
        ),
    ])
}

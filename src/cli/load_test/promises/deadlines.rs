//! Requests that never end by themselves, with deadlines, beside a process that sleeps to the same
//! deadlines.

use std::time::Duration;

use taut_ipc::wire::Code;

use super::row::Row;
use super::trial::{FAULTS, HANG_SEED, Trial, run};
use crate::cli::error::CliError;
use crate::cli::load_test::fleet::Fleet;
use crate::cli::load_test::orders::{Pace, Window};
use crate::cli::load_test::site::{Setup, Site};
use crate::cli::load_test::tally::{LATE_NS, Tally};
use crate::cli::report;

const DEADLINES_MS: [u64; 4] = [1, 5, 20, 100];
/// Waypoints of the paths: more than the optimizer is done with in the longest deadline.
const WAYPOINTS: usize = 300;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, CliError> {
    let setup = Setup {
        workers: 2,
        waypoints: WAYPOINTS,
        lines: FAULTS.to_owned(),
        ..Setup::default()
    };
    let site = Site::own(&setup)?;
    let mut askers = Fleet::start(site.instance(), &site.jobs, 0, 1)?;
    let mut sleeper = Fleet::start(site.instance(), &site.jobs, 1, 1)?;
    let mut rows = Vec::new();
    let mut ours = Tally::default();
    let mut control = Tally::default();
    let length = trial.pick(Duration::from_millis(500), Duration::from_secs(4));
    for deadline in DEADLINES_MS {
        let mut asked = Tally::default();
        let mut slept = Tally::default();
        for number in 0..trial.windows() {
            let window = Window {
                budget: 0,
                deadline_ns: deadline * 1_000_000,
                ..trial.window(number)
            };
            sleeper.begin(
                Window {
                    pace: Pace::Sleep,
                    ..window
                },
                length,
            )?;
            asked.merge(&run(&mut askers, window, length)?);
            slept.merge(&Tally::of(&sleeper.finish(length)?));
        }
        let p99 = |tally: &Tally| report::time(tally.lateness.quantile(0.99));
        let [late, control_late] =
            [&asked, &slept].map(|tally| tally.lateness.share_above(LATE_NS));
        let told = format!(
            "{:.2} % / {:.2} %, p99 {} / {}",
            late * 1e2,
            control_late * 1e2,
            p99(&asked),
            p99(&slept)
        );
        rows.push(Row::told(
            format!("{deadline} ms: more than 1 ms late / a sleeping process"),
            told,
            late,
        ));
        ours.merge(&asked);
        control.merge(&slept);
    }
    // At its worst place: a request that stays where it is and is asked to stop.
    let hang = Window {
        request_seed: Some(HANG_SEED),
        deadline_ns: 20_000_000,
        budget: 0,
        ..trial.window(0)
    };
    let hung = run(&mut askers, hang, length)?;
    let excess = ours.lateness.share_above(LATE_NS) - control.lateness.share_above(LATE_NS);
    let expected = |tally: &Tally| {
        tally.served + tally.with(Code::TimedOut) + tally.refused.get("LATE").copied().unwrap_or(0)
    };
    let sent = ours.sent + hung.sent;
    rows.push(Row::none(
        format!("of {sent} answers, neither proved nor TIMED_OUT"),
        sent - expected(&ours) - expected(&hung),
    ));
    rows.push(Row::part(
        "answers more than 1 ms late, less the control's part",
        0.001,
        excess,
    ));
    Ok(rows)
}

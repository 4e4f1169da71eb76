//! From a request to its final answer, less computing, beside a bare Zenoh query of the same sizes and a
//! local client of the same daemon, in windows that take turns in being first.

use super::Trial;
use crate::error::Error;
use crate::fleet::Member;
use crate::gateway::{Attached, Station, endpoint};
use crate::jobs;
use crate::network::{Host, cable, hosts};
use crate::orders::{Asking, Exchange, Job};
use crate::process::Process;
use crate::programs::own;
use crate::row::Row;
use crate::statistics::{median, time};

const SIZES: [(usize, &str, u64); 3] = [
    (4 << 10, "4 KiB", 60),
    (64 << 10, "64 KiB", 30),
    (1 << 20, "1 MiB", 8),
];
/// How much dearer than Zenoh alone.
const FACTOR: f64 = 1.5;
/// Local round trips that a planner of an attached instance takes beside: its own, and the gateway's.
const LOCAL: f64 = 2.0;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let [host, planners] = hosts(["a", "planners"])?;
    cable(&host, &planners)?;
    let station = Station::start(&host, 1, &[])?;
    let _echo = echo(&host)?;
    let attached = Attached::start(&planners, "attached", &[endpoint(&host)], &[])?;
    let mut beside = Beside {
        ours: Member::planner(&planners, attached.instance())?,
        local: Member::planner(&host, station.daemon.instance())?,
        bare: Member::bare(&planners, &echo_endpoint(&host))?,
    };
    let mut rows = Vec::new();
    for (bytes, name, count) in SIZES {
        rows.extend(beside.sized(trial, bytes, name, count)?);
    }
    rows.extend(beside.first_progress(trial)?);
    Ok(rows)
}

fn echo_endpoint(host: &Host) -> String {
    format!("tcp/{}:7448", host.address())
}

/// Zenoh alone on a host, beside the gateway.
fn echo(host: &Host) -> Result<Process, Error> {
    let mut command = host.command(&own()?, &host.instance("none")?);
    command.args(["echo", "--listen", &echo_endpoint(host)]);
    crate::gateway::ready(host, "echo", command)
}

/// Who is compared.
struct Beside {
    ours: Member,
    local: Member,
    bare: Member,
}

/// Medians of a window (s).
struct Seen {
    ours: f64,
    local: f64,
    bare: f64,
}

impl Seen {
    /// What is promised of ours, over it.
    fn ratio(&self) -> f64 {
        self.ours / (FACTOR * self.bare + LOCAL * self.local)
    }
}

impl Beside {
    fn sized(
        &mut self,
        trial: &Trial,
        bytes: usize,
        name: &str,
        count: u64,
    ) -> Result<[Row; 2], Error> {
        let asking = asking(jobs::sized(bytes), count);
        let back = self.local.ask(&asking)?.bytes;
        self.ours.ask(&asking)?;
        let exchange = Exchange {
            there: bytes,
            back,
            count,
        };
        let seen = (0..trial.pick(3, 24))
            .map(|number| self.window(number, &asking, exchange))
            .collect::<Result<Vec<Seen>, Error>>()?;
        let of = |figure: fn(&Seen) -> f64| median(&seen.iter().map(figure).collect::<Vec<_>>());
        Ok([
            Row::at_most(
                format!(
                    "request to answer / ({FACTOR} bare + {LOCAL} local), {name} there, {back} B back"
                ),
                1.0,
                of(Seen::ratio),
            ),
            Row::told(
                "  medians: attached, bare, local",
                [
                    of(|seen| seen.ours),
                    of(|seen| seen.bare),
                    of(|seen| seen.local),
                ]
                .map(time)
                .join(", "),
            ),
        ])
    }

    /// The three take turns in being first.
    fn window(
        &mut self,
        number: usize,
        asking: &Asking,
        exchange: Exchange,
    ) -> Result<Seen, Error> {
        let mut medians = [0.0; 3];
        for turn in 0..3 {
            let which = (number + turn) % 3;
            let tally = match which {
                0 => self.ours.ask(asking)?,
                1 => self.local.ask(asking)?,
                _ => self.bare.exchange(exchange)?,
            };
            medians[which] = median(&tally.shares);
        }
        let [ours, local, bare] = medians;
        Ok(Seen { ours, local, bare })
    }

    /// Both compute the same, and the improvement leaves the daemon at the same time after the request
    /// came.
    fn first_progress(&mut self, trial: &Trial) -> Result<[Row; 2], Error> {
        let asking = asking(jobs::cut("rooms", 9)?, 20);
        let mut seen = [Vec::new(), Vec::new()];
        for number in 0..trial.pick(3, 24) {
            for turn in [number % 2, 1 - number % 2] {
                let member = if turn == 0 {
                    &mut self.ours
                } else {
                    &mut self.local
                };
                seen[turn].push(median(&member.ask(&asking)?.first));
            }
        }
        let [ours, local] = &seen;
        let later: Vec<f64> = ours
            .iter()
            .zip(local)
            .map(|(ours, local)| ours - local)
            .collect();
        Ok([
            Row::time(
                "first improvement of 4 KiB, later than locally",
                0.001,
                median(&later),
            ),
            Row::told(
                "  medians: attached, local",
                [median(ours), median(local)]
                    .map(time)
                    .join(", "),
            ),
        ])
    }
}

fn asking(job: Job, count: u64) -> Asking {
    Asking {
        jobs: vec![job],
        count,
        patience_ms: 30_000,
        ..Asking::default()
    }
}

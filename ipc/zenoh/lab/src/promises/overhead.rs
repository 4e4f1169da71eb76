//! From a request to its final answer, less computing, beside a bare Zenoh query of the same sizes and a
//! local client of the same daemon, in windows that take turns in being first.

use super::trial::Trial;
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
/// Local round trips that planners take beside: the gateway's, and with an attached instance its own.
const LOCAL: [f64; 2] = [1.0, 2.0];
/// How planners reach the gateway.
const WAYS: [&str; 2] = ["Rust transport", "attached"];

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let [host, planners] = hosts(["a", "planners"])?;
    cable(&host, &planners)?;
    let station = Station::start(&host, 1, &[])?;
    let _echo = echo(&host)?;
    let attached = Attached::start(&planners, "attached", &[endpoint(&host)], &[])?;
    let mut beside = Beside {
        ours: [
            Member::direct(&planners, &endpoint(&host))?,
            Member::planner(&planners, attached.instance())?,
        ],
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
    ours: [Member; 2],
    local: Member,
    bare: Member,
}

/// Medians of a window (s).
struct Seen {
    ours: [f64; 2],
    local: f64,
    bare: f64,
}

impl Seen {
    /// Of one of our ways, what it takes over what is promised.
    fn ratio(&self, way: usize) -> f64 {
        self.ours[way] / (FACTOR * self.bare + LOCAL[way] * self.local)
    }
}

impl Beside {
    fn sized(
        &mut self,
        trial: &Trial,
        bytes: usize,
        name: &str,
        count: u64,
    ) -> Result<Vec<Row>, Error> {
        let asking = asking(jobs::sized(bytes), count);
        let back = self.local.ask(&asking)?.bytes;
        for ours in &mut self.ours {
            ours.ask(&asking)?;
        }
        let exchange = Exchange {
            there: bytes,
            back,
            count,
        };
        let seen = (0..trial.pick(3, 24))
            .map(|number| self.window(number, &asking, exchange))
            .collect::<Result<Vec<Seen>, Error>>()?;
        let mut rows: Vec<Row> = (0..WAYS.len())
            .map(|way| judged(&seen, way, name))
            .collect();
        rows.push(told(&seen, bytes, back));
        Ok(rows)
    }

    /// All take turns in being first.
    fn window(
        &mut self,
        number: usize,
        asking: &Asking,
        exchange: Exchange,
    ) -> Result<Seen, Error> {
        let mut medians = [0.0; 4];
        for turn in 0..4 {
            let which = (number + turn) % 4;
            let tally = match which {
                0 | 1 => self.ours[which].ask(asking)?,
                2 => self.local.ask(asking)?,
                _ => self.bare.exchange(exchange)?,
            };
            medians[which] = median(&tally.shares);
        }
        let [direct, attached, local, bare] = medians;
        Ok(Seen {
            ours: [direct, attached],
            local,
            bare,
        })
    }

    /// Both compute the same, and the improvement leaves the daemon at the same time after the request
    /// came.
    fn first_progress(&mut self, trial: &Trial) -> Result<[Row; 3], Error> {
        let asking = asking(jobs::improved("rooms", 9)?, 20);
        let mut silent = 0;
        let mut seen = [Vec::new(), Vec::new()];
        for number in 0..trial.pick(3, 24) {
            for turn in [number % 2, 1 - number % 2] {
                let member = if turn == 0 {
                    &mut self.ours[1]
                } else {
                    &mut self.local
                };
                let tally = member.ask(&asking)?;
                silent += tally.sent - tally.first.len() as u64;
                seen[turn].push(median(&tally.first));
            }
        }
        let [ours, local] = &seen;
        let later: Vec<f64> = ours
            .iter()
            .zip(local)
            .map(|(ours, local)| ours - local)
            .collect();
        Ok([
            Row::none("answers without an improvement before them", silent),
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

fn judged(seen: &[Seen], way: usize, name: &str) -> Row {
    let ratios: Vec<f64> = seen
        .iter()
        .map(|seen| seen.ratio(way))
        .collect();
    let figure = format!(
        "{name}, {}: request to answer / ({FACTOR} bare + {} local)",
        WAYS[way], LOCAL[way]
    );
    Row::at_most(figure, 1.0, median(&ratios))
}

fn told(seen: &[Seen], there: usize, back: usize) -> Row {
    let of = |figure: fn(&Seen) -> f64| {
        let values: Vec<f64> = seen.iter().map(figure).collect();
        time(median(&values))
    };
    Row::told(
        format!("  {there} B there, {back} B back: direct, attached, bare, local"),
        [
            of(|seen| seen.ours[0]),
            of(|seen| seen.ours[1]),
            of(|seen| seen.bare),
            of(|seen| seen.local),
        ]
        .join(", "),
    )
}

fn asking(job: Job, count: u64) -> Asking {
    Asking {
        jobs: vec![job],
        count,
        patience_ms: 30_000,
        ..Asking::default()
    }
}

//! What a request costs by the daemon, beside the same requests on one thread without it.
//!
//! Both compute the same mix under the same work budgets, with all that a planner gets by default,
//! and take turns in being first in pairs of windows. The daemon's clients get its improvements,
//! too, which is part of what it is for.

use std::time::Duration;

use taut::optimize::Mode;

use super::row::Row;
use super::trial::{Trial, median, ratio, run};
use crate::error::Error;
use crate::load::fleet::Fleet;
use crate::load::local::{Bench, Local};
use crate::load::orders::Window;
use crate::load::process::cpu_ns_of;
use crate::load::site::Site;
use crate::load::tally::Tally;
use crate::units;

/// Work of a request that takes about 3 ms; its time is told.
const WORK: u64 = 12_000;
/// Planners at once, with one worker.
const PLANNERS: [usize; 4] = [1, 4, 16, 64];
/// With two.
const TWO_WORKERS: usize = 16;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    let site = Site::of_workers(1)?;
    for planners in PLANNERS {
        let against = Against::measure(trial, &site, planners, WORK)?;
        if planners == 1 {
            rows.extend(against.cpu_rows());
        }
        let figure = format!("throughput of 1 worker, {planners} planners / in this process");
        rows.push(Row::at_least(figure, 0.95, against.rate()));
        rows.push(against.told());
    }
    let half = Against::measure(trial, &site, 1, WORK / 2)?;
    rows.extend(half.both_told("throughput of 1 worker, 1 planner, requests half as long"));
    drop(site);
    let two = Against::measure(trial, &Site::of_workers(2)?, TWO_WORKERS, WORK)?;
    rows.extend(two.both_told(&format!("throughput of 2 workers, {TWO_WORKERS} planners")));
    Ok(rows)
}

/// The daemon's side of a pair of windows.
struct Served {
    tally: Tally,
    /// CPU time of the daemon (ns).
    cpu_ns: u64,
}

impl Served {
    /// CPU time of the daemon for each answer (s).
    fn cpu_each(&self) -> f64 {
        self.each(self.cpu_ns)
    }

    /// CPU time of the clients for each answer (s).
    fn clients_cpu_each(&self) -> f64 {
        self.each(self.tally.cpu_ns)
    }

    fn each(&self, ns: u64) -> f64 {
        ns as f64 * 1e-9 / self.tally.latency.len().max(1) as f64
    }
}

/// Daemon over local, of each pair of windows.
#[derive(Default)]
struct Against {
    cpu: Vec<f64>,
    rates: Vec<f64>,
    local_cpu: Vec<f64>,
    clients_cpu: Vec<f64>,
}

impl Against {
    fn measure(trial: &Trial, site: &Site, clients: usize, work: u64) -> Result<Self, Error> {
        let mut pair = Pair {
            length: trial.pick(Duration::from_millis(500), Duration::from_secs(1)),
            fleet: Fleet::start(site.instance(), &site.jobs, 0, clients)?,
            pid: site.serving()?,
            bench: Bench::default(),
            site,
            work,
        };
        pair.here();
        let mut against = Self::default();
        for number in 0..trial.windows() {
            let (served, local) = pair.look(number, trial.window(number))?;
            against.add(&served, local);
        }
        Ok(against)
    }

    fn add(&mut self, served: &Served, local: Local) {
        self.cpu
            .push(ratio(served.cpu_each(), local.cpu_each()));
        self.rates
            .push(ratio(served.tally.goodput(), local.rate()));
        self.local_cpu.push(local.cpu_each());
        self.clients_cpu.push(served.clients_cpu_each());
    }

    fn rate(&self) -> f64 {
        median(&self.rates)
    }

    fn cpu_rows(&self) -> [Row; 2] {
        let local_cpu = median(&self.local_cpu);
        [
            Row::told(
                "CPU of one request in this process",
                units::time(local_cpu),
                local_cpu,
            ),
            Row::at_most(
                "CPU by the daemon / in this process, 1 planner",
                1.05,
                median(&self.cpu),
            ),
        ]
    }

    fn both_told(&self, figure: &str) -> [Row; 2] {
        let rate = self.rate();
        let figure = format!("{figure} / in this process");
        [Row::told(figure, format!("{rate:.3}"), rate), self.told()]
    }

    /// What of it is not judged.
    fn told(&self) -> Row {
        let cpu = median(&self.cpu);
        let clients_cpu = units::time(median(&self.clients_cpu));
        Row::told(
            "  CPU by the daemon / in this process; of a client for a request",
            format!("{cpu:.3}; {clients_cpu}"),
            cpu,
        )
    }
}

/// Planners of a daemon, and the optimizer in this process.
struct Pair<'a> {
    length: Duration,
    fleet: Fleet,
    /// The daemon.
    pid: u32,
    bench: Bench,
    site: &'a Site,
    /// Of each request.
    work: u64,
}

impl Pair<'_> {
    fn look(&mut self, number: usize, window: Window) -> Result<(Served, Local), Error> {
        // Every client goes round all jobs, so that both do the same mix.
        let window = Window {
            in_order: true,
            budget: self.work,
            ..window
        };
        if number.is_multiple_of(2) {
            let served = self.served(window)?;
            return Ok((served, self.here()));
        }
        let local = self.here();
        Ok((self.served(window)?, local))
    }

    fn served(&mut self, window: Window) -> Result<Served, Error> {
        let before_ns = cpu_ns_of(self.pid);
        let tally = run(&mut self.fleet, window, self.length)?;
        Ok(Served {
            tally,
            cpu_ns: cpu_ns_of(self.pid) - before_ns,
        })
    }

    fn here(&mut self) -> Local {
        self.bench
            .run(&self.site.problems, Mode::Hybrid, self.work, self.length)
    }
}

//! What a request costs by the daemon, beside the same requests on one thread without it.

use std::time::Duration;

use taut::optimize::Mode;

use super::row::Row;
use super::trial::{BUDGET, Trial, median, ratio, run};
use crate::error::Error;
use crate::load::fleet::Fleet;
use crate::load::local::{Bench, Local};
use crate::load::orders::Window;
use crate::load::process::cpu_ns_of;
use crate::load::site::Site;
use crate::load::tally::Tally;
use crate::units;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    let site = Site::of_workers(1)?;
    for clients in [1, 4, 16, 64] {
        let against = Against::measure(trial, &site, clients)?;
        if clients == 1 {
            rows.extend(against.cpu_rows());
        }
        let figure = format!("throughput of 1 worker, {clients} clients / in this process");
        rows.push(Row::at_least(figure, 0.9, against.rate()));
    }
    drop(site);
    let rate = Against::measure(trial, &Site::of_workers(2)?, 8)?.rate();
    rows.push(Row::told(
        "throughput of 2 workers, 8 clients / in this process",
        format!("{rate:.3}"),
        rate,
    ));
    Ok(rows)
}

/// Daemon over local, of each window.
#[derive(Default)]
struct Against {
    cpu: Vec<f64>,
    rates: Vec<f64>,
    local_cpu: Vec<f64>,
}

impl Against {
    fn measure(trial: &Trial, site: &Site, clients: usize) -> Result<Self, Error> {
        let length = trial.pick(Duration::from_millis(500), Duration::from_secs(1));
        let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, clients)?;
        let pid = site.serving()?;
        let mut bench = Bench::default();
        let mut here = || bench.run(&site.problems, Mode::Hybrid, BUDGET, length);
        here();
        let mut against = Self::default();
        for number in 0..trial.windows() {
            let window = Window {
                // Every client goes round all jobs, so that both do the same mix.
                in_order: true,
                ..trial.window(number)
            };
            let before = cpu_ns_of(pid);
            let tally = run(&mut fleet, window, length)?;
            against.add(cpu_ns_of(pid) - before, &tally, here());
        }
        Ok(against)
    }

    fn add(&mut self, daemon_cpu_ns: u64, tally: &Tally, local: Local) {
        let daemon_cpu = daemon_cpu_ns as f64 * 1e-9 / tally.latency.len().max(1) as f64;
        self.cpu
            .push(ratio(daemon_cpu, local.cpu_each()));
        self.rates
            .push(ratio(tally.goodput(), local.rate()));
        self.local_cpu.push(local.cpu_each());
    }

    fn rate(&self) -> f64 {
        median(&self.rates)
    }

    fn cpu_rows(&self) -> [Row; 2] {
        let local_cpu = median(&self.local_cpu);
        let cpu = median(&self.cpu);
        [
            Row::told(
                "CPU of one request in this process",
                units::time(local_cpu),
                local_cpu,
            ),
            Row::at_most("CPU by the daemon / in this process", 1.1, cpu),
        ]
    }
}

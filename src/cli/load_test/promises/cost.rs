//! What a request costs by the daemon, beside the same requests on one thread without it.

use std::time::Duration;

use taut::optimize::Mode;

use super::row::Row;
use super::trial::{BUDGET, Trial, median, ratio, run};
use crate::cli::error::CliError;
use crate::cli::load_test::fleet::Fleet;
use crate::cli::load_test::local::Bench;
use crate::cli::load_test::orders::Window;
use crate::cli::load_test::process::cpu_ns_of;
use crate::cli::load_test::site::{Setup, Site};
use crate::cli::report;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, CliError> {
    let mut rows = Vec::new();
    let site = Site::own(&Setup {
        workers: 1,
        ..Setup::default()
    })?;
    for clients in [1, 4, 16, 64] {
        let against = Against::measure(trial, &site, clients)?;
        if clients == 1 {
            rows.push(Row::told(
                "CPU of one request in this process",
                report::time(against.local_cpu),
                against.local_cpu,
            ));
            rows.push(Row::at_most(
                "CPU by the daemon / in this process",
                1.1,
                against.cpu,
            ));
        }
        let figure = format!("throughput of 1 worker, {clients} clients / in this process");
        rows.push(Row::at_least(figure, 0.9, against.rate));
    }
    let site = Site::own(&Setup {
        workers: 2,
        ..Setup::default()
    })?;
    let against = Against::measure(trial, &site, 8)?;
    let measured = format!("{:.3}", against.rate);
    rows.push(Row::told(
        "throughput of 2 workers, 8 clients / in this process",
        measured,
        against.rate,
    ));
    Ok(rows)
}

/// Daemon over local, medians of windows.
struct Against {
    cpu: f64,
    rate: f64,
    local_cpu: f64,
}

impl Against {
    fn measure(trial: &Trial, site: &Site, clients: usize) -> Result<Self, CliError> {
        let length = trial.pick(Duration::from_millis(500), Duration::from_secs(1));
        let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, clients)?;
        let pid = site.pid().ok_or_else(|| site.gone())?;
        let mut bench = Bench::default();
        let mut cpu = Vec::new();
        let mut rates = Vec::new();
        let mut local_cpu = Vec::new();
        bench.run(&site.problems, Mode::Hybrid, BUDGET, length);
        for number in 0..trial.windows() {
            let before = cpu_ns_of(pid);
            // Every client goes round all jobs, so that both do the same mix.
            let tally = run(
                &mut fleet,
                Window {
                    in_order: true,
                    ..trial.window(number)
                },
                length,
            )?;
            let spent = (cpu_ns_of(pid) - before) as f64 * 1e-9;
            let local = bench.run(&site.problems, Mode::Hybrid, BUDGET, length);
            cpu.push(ratio(
                spent / tally.latency.len().max(1) as f64,
                local.cpu_each(),
            ));
            rates.push(ratio(tally.goodput(), local.rate()));
            local_cpu.push(local.cpu_each());
        }
        Ok(Self {
            cpu: median(&cpu),
            rate: median(&rates),
            local_cpu: median(&local_cpu),
        })
    }
}

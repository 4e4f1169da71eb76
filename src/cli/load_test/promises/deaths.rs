//! Clients are killed at random points of their requests while others, the witnesses, send on.

use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use taut::optimize::Mode;
use taut_ipc::monotonic_ns;

use super::row::Row;
use super::trial::{FAULTS, HANG_SEED, Trial, median, ratio};
use crate::cli::error::CliError;
use crate::cli::load_test::error::LoadError;
use crate::cli::load_test::fleet::{Fleet, Member};
use crate::cli::load_test::orders::{Point, Window};
use crate::cli::load_test::site::{Setup, Site, number, until};
use crate::cli::load_test::tally::{Tally, Times};
use crate::cli::load_test::{interrupt, wire_mode};
use crate::cli::report;

const WITNESSES: usize = 2;
const POINTS: [Point; 4] = [
    Point::Loaned,
    Point::Sent,
    Point::Streaming,
    Point::Anywhere,
];
/// How long shared memory may take to come back before it counts as lost.
const RECLAIM: Duration = Duration::from_secs(20);
/// The user that root measures as, too: nobody.
const USER: u32 = 65_534;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, CliError> {
    let mut rows = of_this_user(trial)?;
    if rustix::process::geteuid().is_root() {
        rows.extend(of_another_user(trial)?);
    }
    Ok(rows)
}

/// The same again by a process of an ordinary user.
fn of_another_user(trial: &Trial) -> Result<Vec<Row>, CliError> {
    let system = |source| LoadError::System {
        what: "process of another user",
        source,
    };
    let mut command = Command::new(std::env::current_exe().map_err(system)?);
    command.args([
        "promises",
        "--only",
        "deaths",
        "--format",
        "json",
        "--seed",
        &trial.seed.to_string(),
    ]);
    command
        .args(trial.long.then_some("--long"))
        .env_remove("TMPDIR")
        .env_remove("XDG_RUNTIME_DIR");
    let output = command
        .uid(USER)
        .gid(USER)
        .current_dir("/")
        .stderr(Stdio::inherit())
        .output();
    let output = match output {
        Ok(output) => output,
        // The program may lie where other users cannot read it.
        Err(error) => {
            return Ok(vec![Row::told(
                format!("as user {USER}"),
                format!("not measured: {error}"),
                0.0,
            )]);
        }
    };
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
    let rows = report["rows"].as_array().cloned().unwrap_or_default();
    let text =
        |row: &serde_json::Value, name: &str| row[name].as_str().unwrap_or_default().to_owned();
    let same = |row: &serde_json::Value| Row {
        promise: "",
        figure: format!("user {USER}: {}", text(row, "figure")),
        promised: text(row, "promised"),
        measured: text(row, "measured"),
        value: row["value"].as_f64().unwrap_or(f64::NAN),
        kept: row["kept"] == true,
        certain: row["certain"] == true,
        judged: false,
        is_promise: row["is_promise"] == true,
    };
    let ended = Row::is(
        format!("as user {USER}"),
        "a result",
        format!("exit {:?}", output.status.code()),
        0.0,
        !rows.is_empty(),
    );
    Ok(if rows.is_empty() {
        vec![ended]
    } else {
        rows.iter().map(same).collect()
    })
}

fn of_this_user(trial: &Trial) -> Result<Vec<Row>, CliError> {
    let site = Site::own(&Setup {
        workers: 2,
        lines: FAULTS.to_owned(),
        ..Setup::default()
    })?;
    let mut killer = Killer {
        random: fastrand::Rng::with_seed(trial.seed),
        number: 1000,
        kills: 0,
    };
    let mut witnesses = Fleet::start(site.instance(), &site.jobs, 0, WITNESSES)?;
    let client = site.client()?;
    until(RECLAIM, || {
        Ok(number(&client, "clients")? <= (WITNESSES + 1) as f64)
    })?;
    let (files, _) = site.shared_memory();

    let wanted = trial.pick(40, 2000);
    let length = trial.pick(Duration::from_secs(1), Duration::from_secs(3));
    let mut ratios = Vec::new();
    let mut all = Tally::default();
    let mut pairs = 0;
    while killer.kills < wanted || pairs < trial.windows() {
        // Turn by turn, and each first as often as the other.
        let mut p99 = [0.0; 2];
        for turn in [pairs % 2, 1 - pairs % 2] {
            let window = witnesses.begin(trial.window(pairs), length)?;
            killer.work(&site, window.end_ns, turn == 1)?;
            let tally = Tally::of(&witnesses.finish(length)?);
            p99[turn] = tally.latency.quantile(0.99);
            all.merge(&tally);
        }
        ratios.push(ratio(p99[1], p99[0]));
        pairs += 1;
    }
    let killed = killer.kills;
    let freed = killer.freed(trial, &site)?;
    let back = until(RECLAIM, || Ok(site.shared_memory().0 <= files))?;
    let (left, _) = site.shared_memory();
    let alive = site.is_alive();
    drop(witnesses);
    Ok(vec![
        Row::none(
            format!("daemon exits after {killed} killed clients"),
            u64::from(!alive),
        ),
        Row::none(
            format!(
                "of {} witnesses' requests, without a proved answer",
                all.sent
            ),
            all.sent - all.served,
        ),
        Row::none(
            "shared-memory files left over",
            left.saturating_sub(files) as u64,
        ),
        Row::told(
            "  until the last of them was gone",
            report::time(back.unwrap_or(RECLAIM).as_secs_f64()),
            back.is_some().into(),
        ),
        Row::time(
            "a killed client's worker and quota are free, p99",
            0.3,
            freed.quantile(0.99),
        ),
        Row::at_most("witnesses' p99, with kills / without", 1.1, median(&ratios)),
    ])
}

/// Starts clients and ends them at random points.
struct Killer {
    random: fastrand::Rng,
    number: usize,
    kills: u64,
}

impl Killer {
    /// Until then; where `kills` is false they end by themselves, so that the two differ in nothing
    /// else.
    fn work(&mut self, site: &Site, end_ns: u64, kills: bool) -> Result<(), CliError> {
        while monotonic_ns() < end_ns {
            interrupt::check()?;
            let victim = self.victim(site, None)?;
            match kills {
                true => victim.kill(),
                false => victim.let_go()?,
            }
            self.kills += u64::from(kills);
        }
        Ok(())
    }

    /// A client at a point of its request.
    fn victim(&mut self, site: &Site, point: Option<Point>) -> Result<Member, CliError> {
        self.number += 1;
        let mut victim = Member::start(site.instance(), &site.jobs, self.number)?;
        let point = point.unwrap_or_else(|| POINTS[self.random.usize(..POINTS.len())]);
        let window = Window {
            seed: self.random.u64(..),
            budget: super::trial::BUDGET,
            ..Window::closed()
        };
        let window = match point {
            Point::Streaming => Window {
                mode: wire_mode(Mode::RandomShortcut),
                request_seed: Some(HANG_SEED),
                ..window
            },
            _ => window,
        };
        victim.stay_at(point, window)?;
        if point == Point::Anywhere {
            std::thread::sleep(Duration::from_micros(self.random.u64(..20_000)));
        }
        Ok(victim)
    }

    /// From the kill of a client whose request runs until nothing runs.
    fn freed(&mut self, trial: &Trial, site: &Site) -> Result<Times, CliError> {
        let client = site.client()?;
        let mut times = Times::default();
        for _ in 0..trial.pick(10, 200) {
            let victim = self.victim(site, Some(Point::Streaming))?;
            let start = Instant::now();
            victim.kill();
            until(RECLAIM, || Ok(number(&client, "requests_running")? == 0.0))?;
            times.add(start.elapsed().as_nanos() as u64);
        }
        Ok(times)
    }
}

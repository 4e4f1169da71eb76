//! Clients are killed at random points of their requests while others, the witnesses, send on.
//!
//! The control has the same clients: as many processes start at the same pace and go to the same
//! points of the same requests, but end in good order. So the two differ by deaths alone, not by
//! what it costs to start processes and to connect. The pace is what the machine can do.

use std::os::unix::process::CommandExt;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use taut::optimize::Mode;
use taut_ipc::monotonic_ns;

use super::row::Row;
use super::trial::{FAULTS, HANG_SEED, Trial, disturbed_over_calm, median};
use crate::error::Error;
use crate::load::control::number;
use crate::load::fleet::{Fleet, Member};
use crate::load::interrupt;
use crate::load::orders::{Point, Window, wire_mode};
use crate::load::process::sleep_until;
use crate::load::site::{Setup, Site, until};
use crate::load::tally::Tally;
use crate::load::times::Times;
use crate::{program, units};

const WITNESSES: usize = 2;
/// Number of the first client that is killed.
const FIRST: usize = 1000;
const POINTS: [Point; 4] = [
    Point::Loaned,
    Point::Sent,
    Point::Streaming,
    Point::Anywhere,
];
/// From the start of one client to that of the next, as part of the time that one takes in the mean
/// that starts and ends in good order.
const PACE: f64 = 1.2;
/// How long shared memory may take to come back before it counts as lost.
const RECLAIM: Duration = Duration::from_secs(20);
/// The user that root measures as, too: nobody.
const USER: u32 = 65_534;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let mut rows = of_this_user(trial)?;
    if rustix::process::geteuid().is_root() {
        rows.extend(of_another_user(trial)?);
    }
    Ok(rows)
}

/// The same again by a process of an ordinary user.
fn of_another_user(trial: &Trial) -> Result<Vec<Row>, Error> {
    let output = match as_another_user(trial)?.output() {
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
    let report: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
    let rows = report["rows"]
        .as_array()
        .cloned()
        .unwrap_or_default();
    Ok(match rows.is_empty() {
        true => vec![no_result(output.status)],
        false => rows.iter().map(said).collect(),
    })
}

fn as_another_user(trial: &Trial) -> Result<Command, Error> {
    let seed = trial.seed.to_string();
    let mut command = Command::new(program::own()?);
    command
        .args(["promises", "--only", "deaths", "--format", "json"])
        .args(["--seed", &seed])
        .args(trial.long.then_some("--long"))
        .env_remove("TMPDIR")
        .env_remove("XDG_RUNTIME_DIR")
        .uid(USER)
        .gid(USER)
        .current_dir("/")
        .stderr(Stdio::inherit());
    Ok(command)
}

fn no_result(status: ExitStatus) -> Row {
    let measured = format!("exit {:?}", status.code());
    Row::is(format!("as user {USER}"), "a result", measured, 0.0, false)
}

/// A row of the other process's report.
fn said(row: &Value) -> Row {
    let text = |name: &str| {
        row[name]
            .as_str()
            .unwrap_or_default()
            .to_owned()
    };
    Row {
        promise: "",
        figure: format!("user {USER}: {}", text("figure")),
        promised: text("promised"),
        measured: text("measured"),
        value: row["value"].as_f64().unwrap_or(f64::NAN),
        kept: row["kept"] == true,
        certain: row["certain"] == true,
        judged: false,
        is_promise: row["is_promise"] == true,
    }
}

fn of_this_user(trial: &Trial) -> Result<Vec<Row>, Error> {
    let site = Site::own(&Setup {
        workers: 2,
        lines: FAULTS.to_owned(),
        ..Setup::default()
    })?;
    let mut scene = Scene {
        trial,
        witnesses: Fleet::start(site.instance(), &site.jobs, 0, WITNESSES)?,
        killer: Killer::default(),
        seen: Tally::default(),
        site: &site,
    };
    settle(&site)?;
    let (files, _) = site.shared_memory();
    let ratio = scene.pass()?;
    let mut rows = scene.counts();
    let freed = scene.killer.freed(trial, &site)?;
    rows.extend(left_over(&site, files)?);
    rows.push(Row::time(
        "a killed client's worker and quota are free, p99",
        0.3,
        freed.quantile(0.99),
    ));
    let figure = "witnesses' p99, with kills / without";
    rows.push(Row::at_most(figure, 1.1, ratio));
    Ok(rows)
}

/// Waits until nobody but the witnesses is connected.
fn settle(site: &Site) -> Result<(), Error> {
    let client = site.client()?;
    let is_quiet = || Ok(number(&client, "clients")? <= (WITNESSES + 1) as f64);
    until(RECLAIM, is_quiet).map(|_| ())
}

/// Files in shared memory that do not go with the killed.
fn left_over(site: &Site, files: usize) -> Result<[Row; 2], Error> {
    let back = until(RECLAIM, || Ok(site.shared_memory().0 <= files))?;
    let (left, _) = site.shared_memory();
    Ok([
        Row::none(
            "shared-memory files left over",
            left.saturating_sub(files) as u64,
        ),
        Row::told(
            "  until the last of them was gone",
            units::time(back.unwrap_or(RECLAIM).as_secs_f64()),
            back.is_some().into(),
        ),
    ])
}

/// Who kills and who sees it.
struct Scene<'a> {
    trial: &'a Trial,
    site: &'a Site,
    witnesses: Fleet,
    killer: Killer,
    /// What came of the witnesses' requests.
    seen: Tally,
}

impl Scene<'_> {
    /// The witnesses' p99 with kills over that without, the median of windows.
    fn pass(&mut self) -> Result<f64, Error> {
        let wanted = self.trial.pick(40, 2000);
        // How long one takes in good order.
        self.p99(0, false)?;
        self.killer.find_pace(self.window_length());
        let mut ratios = Vec::new();
        while self.killer.kills < wanted || ratios.len() < self.trial.windows() {
            let number = ratios.len();
            ratios.push(disturbed_over_calm(number, |kills| {
                self.p99(number, kills)
            })?);
        }
        Ok(median(&ratios))
    }

    fn counts(&self) -> Vec<Row> {
        let exits = format!("daemon exits after {} killed clients", self.killer.kills);
        vec![
            Row::none(exits, u64::from(!self.site.is_alive())),
            self.seen.unserved("witnesses' requests"),
            self.killer.told(),
        ]
    }

    fn window_length(&self) -> Duration {
        self.trial
            .pick(Duration::from_secs(1), Duration::from_secs(3))
    }

    fn p99(&mut self, number: usize, kills: bool) -> Result<f64, Error> {
        let length = self.window_length();
        let window = self
            .witnesses
            .begin(self.trial.window(number), length)?;
        self.killer.work(self.site, window, kills)?;
        let tally = Tally::of(&self.witnesses.finish(length)?);
        self.seen.merge(&tally);
        Ok(tally.latency.quantile(0.99))
    }
}

/// Starts clients and ends them at random points.
#[derive(Default)]
struct Killer {
    random: fastrand::Rng,
    /// Clients started so far.
    started: usize,
    kills: u64,
    /// Clients that ended in good order.
    let_go: u64,
    /// From the start of one to that of the next; 0 = at once.
    pace: Duration,
}

impl Killer {
    /// In this window; where `kills` is false the same clients end by themselves.
    fn work(&mut self, site: &Site, window: Window, kills: bool) -> Result<(), Error> {
        // Of both windows of a pair.
        self.random = fastrand::Rng::with_seed(window.seed);
        let mut due_ns = window.start_ns;
        while due_ns.max(monotonic_ns()) < window.end_ns {
            interrupt::check()?;
            sleep_until(due_ns);
            self.end_one(site, kills)?;
            due_ns += self.pace.as_nanos() as u64;
        }
        Ok(())
    }

    /// From a window of this length in which nobody was killed; it is not counted.
    fn find_pace(&mut self, length: Duration) {
        self.pace = length.mul_f64(PACE / self.let_go.max(1) as f64);
        self.let_go = 0;
    }

    fn end_one(&mut self, site: &Site, kills: bool) -> Result<(), Error> {
        let victim = self.victim(site, None)?;
        if kills {
            self.kills += 1;
            victim.kill();
            return Ok(());
        }
        self.let_go += 1;
        victim.let_go()
    }

    fn told(&self) -> Row {
        let figure = "clients killed / let go in the windows compared, one each";
        let pace = units::time(self.pace.as_secs_f64());
        let measured = format!("{} / {}, {pace}", self.kills, self.let_go);
        Row::told(figure, measured, self.kills as f64)
    }

    /// A client at a point of its request.
    fn victim(&mut self, site: &Site, point: Option<Point>) -> Result<Member, Error> {
        self.started += 1;
        let number = FIRST + self.started;
        let mut victim = Member::start(site.instance(), &site.jobs, number)?;
        let point = point.unwrap_or_else(|| POINTS[self.random.usize(..POINTS.len())]);
        victim.stay_at(point, self.window(point))?;
        if point == Point::Anywhere {
            std::thread::sleep(Duration::from_micros(self.random.u64(..20_000)));
        }
        Ok(victim)
    }

    /// With a request that lasts until it is at its point.
    fn window(&mut self, point: Point) -> Window {
        let window = Window {
            seed: self.random.u64(..),
            budget: super::trial::BUDGET,
            ..Window::closed()
        };
        match point {
            Point::Streaming => Window {
                mode: wire_mode(Mode::RandomShortcut),
                request_seed: Some(HANG_SEED),
                ..window
            },
            _ => window,
        }
    }

    /// From the kill of a client whose request runs until nothing runs.
    fn freed(&mut self, trial: &Trial, site: &Site) -> Result<Times, Error> {
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

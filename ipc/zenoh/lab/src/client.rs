//! `taut-zenoh-lab client`, hidden: a process that asks as it is told, line by line.

use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use taut_ipc::control::RobotSource;
use taut_ipc::planner::{Answers, Best, Planner, PlannerError, Request};
use taut_ipc::wire::{CertificateSegment, Code, Mode};
use taut_ipc::{ClientError, Instance, monotonic_ns};
use taut_zenoh::{Network, Zenoh};

use crate::bare::Caller;
use crate::error::Error;
use crate::orders::{Asking, Exchange, Job, Order, Said, Tally};
use crate::{model, mutate};

/// How long a first improvement may take.
const PATIENCE: Duration = Duration::from_secs(20);
/// Requests that take longer are told of one by one (s).
const SLOW_S: f64 = 1.0;
/// How long a client waits before it tries again what was refused.
const PAUSE: Duration = Duration::from_millis(5);

/// Obeys standard input until it is closed.
pub(crate) fn run() -> Result<u8, Error> {
    let mut asks = Asks::default();
    let mut line = String::new();
    while std::io::stdin()
        .read_line(&mut line)
        .is_ok_and(|bytes| bytes > 0)
    {
        let said = asks
            .obey(&line)
            .unwrap_or_else(|error| Said::Failed(error.to_string()));
        say(&said);
        line.clear();
    }
    Ok(0)
}

/// A parent that is gone does not read; then there is nobody to tell.
fn say(said: &Said) {
    let line = serde_json::to_string(said).expect("a line holds only strings, numbers and lists");
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// Whom this process asks.
#[derive(Default)]
struct Asks {
    echo: Option<Caller>,
    planner: Option<Planner>,
    held: Option<Answers>,
}

impl Asks {
    fn obey(&mut self, line: &str) -> Result<Said, Error> {
        let order = serde_json::from_str(line).map_err(|error| nobody(error.to_string()))?;
        match order {
            Order::Bare(connect) => self.echo = Some(Caller::open(&connect)?),
            Order::Planner => self.planner = Some(planner()?),
            Order::Direct(connect) => self.planner = Some(direct(&connect)?),
            Order::Load(folder) => load(self.planner()?, &folder)?,
            Order::Ask(asking) => {
                return Ok(Said::Done(Box::new(ask(self.planner()?, &asking))));
            }
            Order::Hold(job) => {
                self.held = Some(hold(self.planner()?, &job)?);
                return Ok(Said::At(monotonic_ns()));
            }
            Order::Cancel => {
                let at = monotonic_ns();
                drop(self.held.take());
                return Ok(Said::At(at));
            }
            Order::Mutate(mutating) => {
                return Ok(Said::Done(Box::new(mutate::send(&mutating)?)));
            }
            Order::Exchange(exchange) => {
                let echo = self.echo.as_ref();
                let echo = echo.ok_or_else(|| nobody("it has no echo"))?;
                return Ok(Said::Done(Box::new(rounds(echo, exchange)?)));
            }
        }
        Ok(Said::Ready)
    }

    fn planner(&self) -> Result<&Planner, Error> {
        self.planner
            .as_ref()
            .ok_or_else(|| nobody("it has no planner"))
    }
}

fn nobody(reason: impl Into<String>) -> Error {
    Error::Process {
        what: "client".to_owned(),
        reason: reason.into(),
    }
}

fn planner() -> Result<Planner, Error> {
    Ok(Planner::connect(&Instance::from_environment()?)?)
}

fn direct(connect: &str) -> Result<Planner, Error> {
    let transport = Zenoh::connect(&Network::to(&[connect]))
        .map_err(|error| Error::Zenoh(error.to_string()))?;
    Ok(Planner::through(transport))
}

/// The robot and the scene of the model, under its labels.
fn load(planner: &Planner, folder: &Path) -> Result<(), Error> {
    let source = RobotSource {
        urdf: folder.join("cart.urdf"),
        ..RobotSource::default()
    };
    planner.load_robot(model::ROBOT, &source, false)?;
    planner.load_scene(model::SCENE, model::SCENE_TEXT, Some(folder), false)?;
    Ok(())
}

fn rounds(echo: &Caller, exchange: Exchange) -> Result<Tally, Error> {
    let mut tally = Tally::default();
    for _ in 0..exchange.count {
        tally.sent += 1;
        match echo.round(exchange.there, exchange.back)? {
            Some(time) => tally.shares.push(time),
            None => tally.endless += 1,
        }
    }
    Ok(tally)
}

/// A request whose first improvement has come.
fn hold(planner: &Planner, job: &Job) -> Result<Answers, Error> {
    let mut answers = planner.ask(&request(&Asking::default(), job), &job.path)?;
    answers.next(PATIENCE)?;
    Ok(answers)
}

/// One request after another.
fn ask(planner: &Planner, asking: &Asking) -> Tally {
    let mut tally = Tally::default();
    let start = Instant::now();
    let length = Duration::from_millis(asking.length_ms);
    let is_over = |sent| {
        (asking.count != 0 && sent >= asking.count)
            || (asking.length_ms != 0 && start.elapsed() >= length)
    };
    for job in asking.jobs.iter().cycle() {
        if is_over(tally.sent) {
            break;
        }
        let sent = start.elapsed().as_secs_f64();
        one(planner, asking, job, &mut tally);
        let took = start.elapsed().as_secs_f64() - sent;
        if took > SLOW_S {
            tally.slow.push((sent, took));
        }
    }
    tally
}

/// One request, from its sending to its count.
fn one(planner: &Planner, asking: &Asking, job: &Job, tally: &mut Tally) {
    tally.sent += 1;
    let start = Instant::now();
    let patience = Duration::from_millis(asking.patience_ms);
    let end = planner
        .ask(&request(asking, job), &job.path)
        .and_then(|answers| last(answers, start, start + patience, tally));
    match end {
        Ok(Some(best)) => count(&best, start, job, tally),
        Ok(None) => tally.endless += 1,
        Err(error) => {
            tally.times.push(start.elapsed().as_secs_f64());
            *tally.ends.entry(in_words(&error)).or_default() += 1;
            std::thread::sleep(PAUSE);
        }
    }
}

fn request(asking: &Asking, job: &Job) -> Request {
    let deadline = Duration::from_millis(asking.deadline_ms);
    Request {
        mode: Mode::named(&job.mode).unwrap_or(Mode::Hybrid),
        work_budget: job.budget,
        seed: job.seed,
        deadline: (asking.deadline_ms != 0).then_some(deadline),
        ..Request::new(&job.robot, job.scene.as_deref())
    }
}

/// The final answer; `None` where it does not come in time.
fn last(
    mut answers: Answers,
    start: Instant,
    end: Instant,
    tally: &mut Tally,
) -> Result<Option<Best>, PlannerError> {
    let mut is_first = true;
    loop {
        let left = end.saturating_duration_since(Instant::now());
        let best = match answers.next(left) {
            Ok(Some(best)) => best,
            Ok(None) => return Err(ClientError::NoAnswer.into()),
            Err(PlannerError::Client(ClientError::Timeout(_))) => return Ok(None),
            Err(error) => return Err(error),
        };
        if best.is_final() {
            return Ok(Some(best));
        }
        tally.improvements += 1;
        if std::mem::take(&mut is_first) {
            tally.first.push(start.elapsed().as_secs_f64());
        }
    }
}

/// Time since sending that nobody computed and nothing waited in a queue (s).
fn share(best: &Best, start: Instant) -> f64 {
    let header = best.header();
    let busy = Duration::from_nanos(header.queue_ns + header.compute_ns);
    start
        .elapsed()
        .saturating_sub(busy)
        .as_secs_f64()
}

fn count(best: &Best, start: Instant, job: &Job, tally: &mut Tally) {
    let code = best.code();
    tally.bytes = tally.bytes.max(bytes(best));
    tally.shares.push(share(best, start));
    tally.times.push(start.elapsed().as_secs_f64());
    *tally
        .ends
        .entry(format!("{code:?}"))
        .or_default() += 1;
    if code == Code::Success {
        let header = best.header();
        tally
            .scenes
            .insert((header.scene_version, header.scene_hash));
        tally
            .answers
            .entry(job.name.clone())
            .or_default()
            .insert(hash(best));
    }
}

/// Of an answer's path and its proof.
fn bytes(best: &Best) -> usize {
    let segments = best.header().certificate.count as usize;
    size_of_val(best.path()) + segments * size_of::<CertificateSegment>()
}

/// Of all that has to be equal in equal answers (FNV-1a).
fn hash(best: &Best) -> u64 {
    let header = best.header();
    let numbers = [
        header.robot_hash,
        header.scene_hash,
        header.length_after.to_bits(),
        header.lower_bound.to_bits(),
        header.work,
        header.iterations,
    ];
    let path = best
        .path()
        .iter()
        .map(|number| number.to_bits());
    let words = numbers.into_iter().chain(path);
    words
        .flat_map(u64::to_le_bytes)
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
        })
}

fn in_words(error: &PlannerError) -> String {
    format!("{:?}", error.code())
}

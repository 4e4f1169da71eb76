//! `taut replay`: a recorded run computed again.

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use indicatif::ProgressBar;
use serde::Serialize;
use taut::optimize::Workspace;

use super::error::CliError;
use super::format::{Format, print};
use super::progress::progress_bar;
use super::report;
use crate::daemon::recording::{Recorded, Recording, Replay, Verdict};
use taut_ipc::wire::Code;

/// Compute a recorded run again, in this process
///
/// Every request is computed from the same bits, and ended where it was ended then. Exit code: 0, 1
/// with --verify where an answer differs, 65 a file that is damaged or of another version, 66 an unreadable one.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// File of `taut record` or `taut why --bundle`
    file: PathBuf,
    /// Compare each answer with the recorded one, bit by bit
    #[arg(long)]
    verify: bool,
    /// Only the requests whose id, in hexadecimal digits, starts or ends like this
    #[arg(long, value_name = "ID", default_value = "")]
    only: String,
    /// Threads that compute [default: one for each core]
    #[arg(long)]
    threads: Option<std::num::NonZero<usize>>,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// One request beside its record.
#[derive(Serialize)]
struct Line {
    request_id: String,
    robot: String,
    scene: String,
    scene_version: u64,
    mode: &'static str,
    waypoints: usize,
    code: Option<&'static str>,
    length_before: Option<f64>,
    length_after: Option<f64>,
    recorded_compute_s: Option<f64>,
    compute_s: Option<f64>,
    /// `equal`, or what differs, or why there is nothing to compare.
    verdict: String,
    #[serde(skip)]
    text: String,
    #[serde(skip)]
    kind: Verdict,
}

#[derive(Serialize)]
struct Report<'a> {
    written: &'a std::collections::BTreeMap<String, String>,
    requests: usize,
    equal: usize,
    different: usize,
    not_compared: usize,
    missed: Option<u64>,
    torn_bytes: usize,
    answers: Vec<Line>,
}

/// Replays.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let run = Recording::read(&arguments.file)?;
    let meant = meant(arguments, &run)?;
    let lines = replayed(&run, &meant, arguments.threads.map(Into::into));
    let report = Report::of(&run, lines);
    for warning in warnings(&run) {
        eprintln!("warning: {warning}");
    }
    let text = match arguments.format {
        Format::Json => {
            serde_json::to_string(&report).expect("a report holds only plain values") + "\n"
        }
        Format::Table => table(&report, arguments.verify),
    };
    print(&text)?;
    Ok(u8::from(arguments.verify && report.different > 0))
}

/// Which requests are to be computed.
///
/// # Errors
/// An id that none has.
fn meant(arguments: &Arguments, run: &Recording) -> Result<Vec<usize>, CliError> {
    let id = arguments
        .only
        .trim_start_matches("0x")
        .to_ascii_lowercase();
    let meant = named(&run.requests, &id);
    match meant.is_empty() && !id.is_empty() {
        true => Err(CliError::Choice(format!(
            "no request {id} in {}; without --only all are replayed",
            arguments.file.display()
        ))),
        false => Ok(meant),
    }
}

/// The numbers of the requests with such an id.
fn named(requests: &[Recorded], id: &str) -> Vec<usize> {
    let numbered = requests.iter().enumerate();
    numbered
        .filter(|(_, recorded)| is_named(recorded, id))
        .map(|(index, _)| index)
        .collect()
}

/// Whether a request's id starts or ends like this.
fn is_named(recorded: &Recorded, id: &str) -> bool {
    let full = format!("{:016x}", recorded.request_id());
    full.starts_with(id) || full.ends_with(id)
}

impl<'a> Report<'a> {
    fn of(run: &'a Recording, answers: Vec<Line>) -> Self {
        let equal = count(&answers, |verdict| *verdict == Verdict::Equal);
        let different = count(&answers, |verdict| matches!(verdict, Verdict::Differs(_)));
        Self {
            written: &run.written,
            requests: answers.len(),
            equal,
            different,
            not_compared: answers.len() - equal - different,
            missed: run.missed,
            torn_bytes: run.torn,
            answers,
        }
    }
}

fn count(lines: &[Line], is_such: fn(&Verdict) -> bool) -> usize {
    lines
        .iter()
        .filter(|line| is_such(&line.kind))
        .count()
}

/// What the reader has to know of the file.
fn warnings(run: &Recording) -> Vec<String> {
    other_release(run)
        .into_iter()
        .chain(missing(run))
        .collect()
}

fn other_release(run: &Recording) -> Option<String> {
    let release = run
        .written
        .get("taut")
        .map_or("?", String::as_str);
    let now = env!("CARGO_PKG_VERSION");
    (release != now).then(|| {
        format!(
            "recorded by taut {release}, replayed by {now}: only the same release has to give the same bits"
        )
    })
}

fn missing(run: &Recording) -> Option<String> {
    match run.missed {
        None => Some(format!(
            "the recording did not end in order; {} bytes at its end are no record",
            run.torn
        )),
        Some(0) => None,
        Some(missed) => Some(format!(
            "{missed} requests and answers were left out when it was recorded"
        )),
    }
}

fn replayed(run: &Recording, meant: &[usize], threads: Option<usize>) -> Vec<Line> {
    let cores = std::thread::available_parallelism().map_or(1, Into::into);
    let work = Work {
        run,
        replay: Replay::new(run),
        meant,
        next: AtomicUsize::new(0),
        bar: progress_bar(meant.len() as u64),
        lines: Mutex::new(Vec::with_capacity(meant.len())),
    };
    std::thread::scope(|scope| {
        for _ in 0..threads.unwrap_or(cores).min(meant.len()) {
            scope.spawn(|| work.take());
        }
    });
    work.done()
}

/// What the threads share.
struct Work<'a> {
    run: &'a Recording,
    replay: Replay<'a>,
    /// Requests to compute.
    meant: &'a [usize],
    /// How many of them are taken.
    next: AtomicUsize,
    bar: ProgressBar,
    /// Those that are done, each with its number.
    lines: Mutex<Vec<(usize, Line)>>,
}

impl Work<'_> {
    /// Computes requests until all are taken.
    fn take(&self) {
        let mut workspace = Workspace::default();
        while let Some(&index) = self
            .meant
            .get(self.next.fetch_add(1, Ordering::Relaxed))
        {
            let recorded = &self.run.requests[index];
            let line = line(recorded, &self.replay, index, &mut workspace);
            self.bar.inc(1);
            let lines = self.lines.lock();
            let mut lines = lines.unwrap_or_else(PoisonError::into_inner);
            lines.push((index, line));
        }
    }

    /// All of them in the order of their numbers.
    fn done(self) -> Vec<Line> {
        self.bar.finish_and_clear();
        let lines = self.lines.into_inner();
        let mut lines = lines.unwrap_or_else(PoisonError::into_inner);
        lines.sort_by_key(|(index, _)| *index);
        lines
            .into_iter()
            .map(|(_, line)| line)
            .collect()
    }
}

fn line(recorded: &Recorded, replay: &Replay, index: usize, workspace: &mut Workspace) -> Line {
    let start = Instant::now();
    let replayed = replay.run(index, workspace);
    let compute_s = replayed
        .header
        .map(|_| start.elapsed().as_secs_f64());
    let header = replayed.header.as_ref();
    let (scene, scene_version) = recorded.scene();
    Line {
        request_id: format!("{:016x}", recorded.request_id()),
        robot: recorded.robot().to_owned(),
        scene: scene.to_owned(),
        scene_version,
        mode: recorded.mode(),
        waypoints: recorded.waypoints(),
        code: header.map(|header| Code::try_from(header.code).map_or("?", Code::name)),
        length_before: header.map(|header| header.length_before),
        length_after: header.map(|header| header.length_after),
        recorded_compute_s: recorded
            .header()
            .map(|header| header.compute_ns as f64 * 1e-9),
        compute_s,
        verdict: in_words(&replayed.verdict),
        text: recorded.to_string(),
        kind: replayed.verdict,
    }
}

/// With --verify what is not equal, else every request; then the sum.
fn table(report: &Report, verify: bool) -> String {
    let line = if verify { difference } else { line_of };
    let lines: String = report.answers.iter().filter_map(line).collect();
    lines + &sum(report, verify)
}

fn in_words(verdict: &Verdict) -> String {
    match verdict {
        Verdict::Equal => "equal".to_owned(),
        Verdict::Differs(what) => what.clone(),
        Verdict::NotCompared(why) => format!("not compared: {why}"),
    }
}

fn difference(line: &Line) -> Option<String> {
    match &line.kind {
        Verdict::Differs(what) => Some(format!("DIFFERS {}: {what}\n", line.text)),
        _ => None,
    }
}

fn line_of(line: &Line) -> Option<String> {
    let time = |seconds: Option<f64>| seconds.map_or_else(|| "-".to_owned(), report::time);
    Some(format!(
        "{}   {}   {}   {} (recorded: {})\n",
        line.text,
        line.code.unwrap_or("-"),
        lengths(line),
        time(line.compute_s),
        time(line.recorded_compute_s)
    ))
}

fn sum(report: &Report, verify: bool) -> String {
    let requests = report.requests;
    match verify {
        true => format!(
            "{requests} requests: {} bit-equal, {} different, {} not compared\n",
            report.equal, report.different, report.not_compared
        ),
        false => format!("{requests} requests; --verify compares the answers\n"),
    }
}

fn lengths(line: &Line) -> String {
    match (line.length_before, line.length_after) {
        (Some(before), Some(after)) => format!("length {before:.4} → {after:.4}"),
        _ => line.verdict.clone(),
    }
}

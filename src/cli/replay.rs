//! `taut replay`: a recorded run computed again.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use serde::Serialize;
use taut::optimize::Workspace;

use super::error::{CliError, stdout};
use super::format::Format;
use super::progress::progress_bar;
use super::report;
use crate::daemon::recording::{Recorded, Recording, Replay, Verdict};
use taut_ipc::wire::Code;

/// Compute a recorded run again, in this process
///
/// Every request is computed from the same bits, and ended where it was ended then. Exit code: 0, 1
/// with --verify where an answer differs, 65 a damaged file, 66 an unreadable one.
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
    let id = arguments.only.trim_start_matches("0x").to_ascii_lowercase();
    let is_meant = |recorded: &Recorded| {
        let full = format!("{:016x}", recorded.request_id());
        full.starts_with(&id) || full.ends_with(&id)
    };
    let meant: Vec<usize> = (0..run.requests.len())
        .filter(|&index| is_meant(&run.requests[index]))
        .collect();
    if meant.is_empty() && !id.is_empty() {
        let text = format!(
            "no request {id} in {}; without --only all are replayed",
            arguments.file.display()
        );
        return Err(CliError::Choice(text));
    }
    let mut lines = replayed(&run, &meant, arguments.threads.map(Into::into));
    let count = |kind: fn(&Verdict) -> bool| lines.iter().filter(|line| kind(&line.kind)).count();
    let equal = count(|verdict| *verdict == Verdict::Equal);
    let different = count(|verdict| matches!(verdict, Verdict::Differs(_)));
    let report = Report {
        written: &run.written,
        requests: lines.len(),
        equal,
        different,
        not_compared: lines.len() - equal - different,
        missed: run.missed,
        torn_bytes: run.torn,
        answers: std::mem::take(&mut lines),
    };
    for warning in warnings(&run) {
        eprintln!("warning: {warning}");
    }
    let text = match arguments.format {
        Format::Json => {
            serde_json::to_string(&report).expect("a report holds only plain values") + "\n"
        }
        Format::Table => table(&report, arguments.verify),
    };
    std::io::stdout()
        .lock()
        .write_all(text.as_bytes())
        .map_err(stdout)?;
    Ok(u8::from(arguments.verify && different > 0))
}

/// What the reader has to know of the file.
fn warnings(run: &Recording) -> Vec<String> {
    let mut warnings = Vec::new();
    let release = run.written.get("taut").map_or("?", String::as_str);
    if release != env!("CARGO_PKG_VERSION") {
        let now = env!("CARGO_PKG_VERSION");
        warnings.push(format!(
            "recorded by taut {release}, replayed by {now}: only the same release has to give the same bits"
        ));
    }
    match run.missed {
        None => warnings.push(format!(
            "the recording did not end in order; {} bytes at its end are no record",
            run.torn
        )),
        Some(0) => {}
        Some(missed) => warnings.push(format!(
            "{missed} requests and answers were left out when it was recorded"
        )),
    }
    warnings
}

fn replayed(run: &Recording, meant: &[usize], threads: Option<usize>) -> Vec<Line> {
    let cores = std::thread::available_parallelism().map_or(1, Into::into);
    let replay = Replay::new(run);
    let next = AtomicUsize::new(0);
    let bar = progress_bar(meant.len() as u64);
    let lines = Mutex::new(Vec::with_capacity(meant.len()));
    let work = || {
        let mut workspace = Workspace::default();
        while let Some(&index) = meant.get(next.fetch_add(1, Ordering::Relaxed)) {
            let line = line(&run.requests[index], &replay, index, &mut workspace);
            bar.inc(1);
            lines
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner)
                .push((index, line));
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..threads.unwrap_or(cores).min(meant.len()) {
            scope.spawn(work);
        }
    });
    bar.finish_and_clear();
    let mut lines = lines
        .into_inner()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    lines.sort_by_key(|(index, _)| *index);
    lines.into_iter().map(|(_, line)| line).collect()
}

fn line(recorded: &Recorded, replay: &Replay, index: usize, workspace: &mut Workspace) -> Line {
    let start = Instant::now();
    let replayed = replay.run(index, workspace);
    let compute_s = replayed.header.map(|_| start.elapsed().as_secs_f64());
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
        verdict: match &replayed.verdict {
            Verdict::Equal => "equal".to_owned(),
            Verdict::Differs(what) => what.clone(),
            Verdict::NotCompared(why) => format!("not compared: {why}"),
        },
        text: recorded.to_string(),
        kind: replayed.verdict,
    }
}

/// With --verify what is not equal, else every request; then the sum.
fn table(report: &Report, verify: bool) -> String {
    let mut text = String::new();
    for line in &report.answers {
        match &line.kind {
            Verdict::Differs(what) if verify => text += &format!("DIFFERS {}: {what}\n", line.text),
            _ if verify => {}
            _ => {
                let code = line.code.unwrap_or("-");
                let lengths = lengths(line);
                let now = line.compute_s.map_or_else(|| "-".to_owned(), report::time);
                let then = line
                    .recorded_compute_s
                    .map_or_else(|| "-".to_owned(), report::time);
                text += &format!(
                    "{}   {code}   {lengths}   {now} (recorded: {then})\n",
                    line.text
                );
            }
        }
    }
    let Report {
        requests,
        equal,
        different,
        not_compared,
        ..
    } = report;
    match verify {
        true => {
            text + &format!(
                "{requests} requests: {equal} bit-equal, {different} different, {not_compared} not compared\n"
            )
        }
        false => text + &format!("{requests} requests; --verify compares the answers\n"),
    }
}

fn lengths(line: &Line) -> String {
    match (line.length_before, line.length_after) {
        (Some(before), Some(after)) => format!("length {before:.4} → {after:.4}"),
        _ => line.verdict.clone(),
    }
}

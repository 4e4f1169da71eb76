//! `taut bench`: every problem below a folder, beside the recorded answers of others.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use taut::collision::CollisionModel;
use taut::files::{FileError, Kind};
use taut::optimize::{Mode, Workspace};

use super::bench_table::{self, Figures, PeerFigures, Row};
use super::error::{CliError, stdout};
use super::load::{self, Loaded};
use super::report::{geometry_name, termination_name, verdict};
use super::request::{self, Rules, Source};
use super::{Format, bench_check, progress_bar, run as runner};

/// Shorten every problem of a folder and compare with the recorded answers of others
///
/// Problems that cannot be read become rows with the reason. Exit code: 0 where all could be read and run,
/// whether their paths are proved or not; 65 otherwise.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Folder with problem files, at any depth
    folder: PathBuf,
    /// Optimizers to run, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "gradient,random-shortcut,partial-shortcut",
        value_parser = request::mode())]
    modes: Vec<Mode>,
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    rules: Rules,
    /// Measure the check instead: time to prove each path, to refuse the straight way, and to sample the path
    #[arg(long, conflicts_with_all = ["modes", "deadline", "seed", "strict", "weights"])]
    check: bool,
    /// Only problems whose folder or file name contains this text
    #[arg(long, value_name = "TEXT")]
    filter: Option<String>,
    /// At most this many problems of each folder
    #[arg(long, value_name = "N")]
    limit: Option<usize>,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Write the rows and the medians as JSON to this file too
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Runs every problem.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let files = problems(arguments)?;
    if arguments.check {
        return check(arguments, &files);
    }
    let mut reader = load::reader(&arguments.source);
    let mut workspace = Workspace::default();
    let bar = progress_bar(files.len() as u64);
    let mut rows = Vec::with_capacity(files.len());
    for file in &files {
        let mut row = Row { set: set_name(&arguments.folder, file), ..Row::default() };
        bar.set_message(format!("{}/{}", row.set, stem(file)));
        match load::load(&mut reader, file, &arguments.source, true) {
            Ok(loaded) => fill(&mut row, arguments, &loaded, &mut workspace),
            Err(error) => row.error = Some(error.to_string()),
        }
        row.name = stem(file);
        rows.push(row);
        bar.inc(1);
    }
    bar.finish_and_clear();

    let modes: Vec<&'static str> = arguments.modes.iter().map(|mode| mode.name()).collect();
    let report = bench_table::Report::new(rows, modes);
    show(arguments, &report.json(), || report.table())?;
    Ok(if report.has_errors() { 65 } else { 0 })
}

/// Measures the check on every problem.
fn check(arguments: &Arguments, files: &[PathBuf]) -> Result<u8, CliError> {
    let mut reader = load::reader(&arguments.source);
    let mut scratch = taut::validation::Scratch::default();
    let bar = progress_bar(files.len() as u64);
    let mut rows = Vec::with_capacity(files.len());
    for file in files {
        let (set, name) = (set_name(&arguments.folder, file), stem(file));
        bar.set_message(format!("{set}/{name}"));
        let measured = load::load(&mut reader, file, &arguments.source, true)
            .and_then(|loaded| bench_check::measure(&loaded, arguments.rules.clearance, &mut scratch));
        rows.push(bench_check::Row::new(set, name, measured));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let report = bench_check::Report::new(rows);
    show(arguments, &report.json(), || report.table())?;
    Ok(if report.has_errors() { 65 } else { 0 })
}

/// Writes a report where the arguments want it.
fn show(arguments: &Arguments, json: &str, table: impl FnOnce() -> String) -> Result<(), CliError> {
    let json = format!("{json}\n");
    if let Some(file) = &arguments.out {
        std::fs::write(file, &json).map_err(|source| CliError::Output { file: file.display().to_string(), source })?;
    }
    let text = match arguments.format {
        Format::Json => json,
        Format::Table => table(),
    };
    std::io::stdout().lock().write_all(text.as_bytes()).map_err(stdout)
}

/// Runs each mode and copies the figures of the peers.
fn fill(row: &mut Row, arguments: &Arguments, loaded: &Loaded, workspace: &mut Workspace) {
    row.geometry = geometry_name(loaded.geometry);
    let model = match loaded.model() {
        Ok(model) => model,
        Err(error) => return row.error = Some(error.to_string()),
    };
    for &mode in &arguments.modes {
        match answer(arguments, mode, loaded, &model, workspace) {
            Ok(timed) => {
                row.length_before = Some(timed.outcome.length_before);
                row.lower_bound = Some(timed.outcome.lower_bound);
                row.answers.insert(mode.name(), figures(&timed));
            }
            Err(error) => _ = row.error.get_or_insert_with(|| format!("{}: {error}", mode.name())),
        }
    }
    let Some(before) = row.length_before else { return };
    let relative =
        |peer: &taut::files::Peer| PeerFigures { ratio: peer.length / before, cpu_s: peer.cpu_s, honest: peer.honest };
    row.peers = loaded.peers.iter().map(|(name, peer)| (name.clone(), relative(peer))).collect();
    // Recorded as the best only because every check found it valid.
    let best = loaded.best_honest_peer.as_ref();
    row.best_honest_peer = best.map(|(name, peer)| (name.clone(), PeerFigures { honest: true, ..relative(peer) }));
}

fn answer(
    arguments: &Arguments,
    mode: Mode,
    loaded: &Loaded,
    model: &CollisionModel,
    workspace: &mut Workspace,
) -> Result<runner::Timed, CliError> {
    let nv = loaded.robot.space().nv();
    let settings = arguments.rules.settings(mode, loaded.weights.as_ref(), nv).map_err(CliError::Usage)?;
    runner::run(loaded, model, &settings, arguments.rules.deadline, workspace, &mut |_, _| {})
}

fn figures(timed: &runner::Timed) -> Figures {
    let outcome = &timed.outcome;
    let before = outcome.length_before;
    Figures {
        proved: outcome.proved,
        code: timed.code.name(),
        ratio: if before > 0.0 { outcome.length_after / before } else { 1.0 },
        length: outcome.length_after,
        cpu_s: timed.cpu_s,
        time_s: timed.time_s,
        floor_m: outcome.floor_m,
        floors_lowered: outcome.floors_lowered.len(),
        iterations: outcome.iterations,
        work: outcome.work,
        termination: termination_name(outcome.termination),
        refusal: outcome.refusal.is_some().then(|| verdict(timed)),
    }
}

/// The problem files to run, in order of their names.
fn problems(arguments: &Arguments) -> Result<Vec<PathBuf>, CliError> {
    let mut files = Vec::new();
    collect(&arguments.folder, &mut files)?;
    files.sort();
    if let Some(text) = &arguments.filter {
        files.retain(|file| format!("{}/{}", set_name(&arguments.folder, file), stem(file)).contains(text.as_str()));
    }
    // Bare paths lie about too; what cannot be read at all stays, to become a row.
    files.retain(|file| !matches!(Kind::of(file), Ok(Kind::BarePath)));
    if let Some(limit) = arguments.limit {
        let mut taken: BTreeMap<PathBuf, usize> = BTreeMap::new();
        files.retain(|file| {
            let count = taken.entry(file.parent().unwrap_or(Path::new("")).to_owned()).or_default();
            *count += 1;
            *count <= limit
        });
    }
    if files.is_empty() {
        let text = format!("no problem file (.json with a \"format\") below {}", arguments.folder.display());
        return Err(CliError::Usage(text));
    }
    Ok(files)
}

/// The `.json` files below a folder; a symbolic link to a folder is not followed, for it may lead in a circle.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), CliError> {
    let unreadable = |error: std::io::Error| {
        CliError::File(FileError::Unreadable { file: folder.to_owned(), reason: error.to_string() })
    };
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let path = entry.path();
        if entry.file_type().map_err(unreadable)?.is_dir() {
            collect(&path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "json") {
            files.push(path);
        }
    }
    Ok(())
}

/// Folder of a problem below the one given, which is the set that medians are taken of.
fn set_name(root: &Path, file: &Path) -> String {
    let folder = file.parent().unwrap_or(Path::new(""));
    let below = folder.strip_prefix(root).unwrap_or(folder).display().to_string();
    if below.is_empty() { folder.file_name().unwrap_or_default().to_string_lossy().into_owned() } else { below }
}

fn stem(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

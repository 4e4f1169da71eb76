//! Programs of all languages, untouched, whose robot and scene are meshes on another machine than the
//! daemon's: its files cannot be seen there.

use std::path::Path;
use std::process::Command;

use taut_ipc::Instance;

use super::required::is_all_required;
use super::trial::Trial;
use crate::daemon::Daemon;
use crate::error::Error;
use crate::fleet::Member;
use crate::gateway::{Attached, Station, endpoint};
use crate::model;
use crate::network::{Host, cable, hosts};
use crate::orders::Asking;
use crate::programs::{TAUT, built};
use crate::row::Row;

/// Length and path of an answer, a line each, or whatever else tells answers apart.
type Ask = fn(&Place) -> Result<String, Error>;

const LANGUAGES: [(&str, Ask); 4] = [
    ("Rust", in_rust),
    ("the command line", on_the_command_line),
    ("Python", in_python),
    ("C", in_c),
];

/// Where a program runs, and whom it asks.
struct Place<'a> {
    host: &'a Host,
    instance: &'a Instance,
    folder: &'a Path,
}

pub(super) fn measure(_: &Trial) -> Result<Vec<Row>, Error> {
    let [a, planners] = hosts(["a", "planners"])?;
    cable(&a, &planners)?;
    let _station = Station::start(&a, 1, &[])?;
    let attached = Attached::start(&planners, "attached", &[endpoint(&a)], &[])?;
    let local = Daemon::start(&planners, "local", 1)?;
    let folder = model::write(planners.folder())?;
    let place = |instance| Place {
        host: &planners,
        instance,
        folder: &folder,
    };
    let [remote, local] = [place(attached.instance()), place(local.instance())];
    LANGUAGES
        .into_iter()
        .map(|(name, ask)| compared(name, ask, [&remote, &local]))
        .collect()
}

/// A language whose program or library is not there is told, and a failure where all is required.
fn compared(name: &str, ask: Ask, [remote, local]: [&Place; 2]) -> Result<Row, Error> {
    let figure = format!("{name}: numbers of an answer that differ from a local daemon's");
    let remote = match ask(remote) {
        Err(error @ Error::NoProgram { .. }) => {
            return Ok(Row::is(
                figure,
                "0",
                format!("NOT RUN: {error}"),
                !is_all_required(),
            ));
        }
        remote => remote?,
    };
    let local = ask(local)?;
    let differing = remote
        .lines()
        .zip(local.lines())
        .filter(|(remote, local)| remote != local)
        .count();
    Ok(Row::is(
        figure,
        "0",
        format!("{differing} of {}", local.lines().count()),
        remote == local && !local.is_empty(),
    ))
}

fn in_rust(place: &Place) -> Result<String, Error> {
    let mut member = Member::planner(place.host, place.instance)?;
    member.load(place.folder)?;
    let tally = member.ask(&Asking {
        jobs: vec![model::job()],
        count: 1,
        patience_ms: 30_000,
        ..Asking::default()
    })?;
    let hashes = tally.answers.into_values().flatten();
    Ok(hashes
        .map(|hash| format!("{hash:016x}\n"))
        .collect())
}

fn on_the_command_line(place: &Place) -> Result<String, Error> {
    let mut command = place
        .host
        .command(&TAUT.find()?, place.instance);
    command
        .arg("shorten")
        .arg(place.folder.join("problem.json"))
        .args(["--budget", "6000", "--seed", "7", "--format", "json"]);
    let said = said("the command line", command)?;
    // As text: whoever reads a number may round it.
    let parts = ["\"length_after\":", "\"path\":[["].map(|start| part(&said, start));
    Ok(parts.concat().replace(',', "\n"))
}

/// A line from where this stands to the end of the number or list that follows it.
fn part(json: &str, start: &str) -> String {
    let rest = json
        .split_once(start)
        .map_or("", |(_, rest)| rest);
    let end = if start.ends_with('[') { "]]" } else { "," };
    let text = rest
        .split_once(end)
        .map_or("", |(text, _)| text);
    format!("{text}\n")
}

fn in_python(place: &Place) -> Result<String, Error> {
    let python = needed("Python", "TAUT_PYTHON", &["target/tmp/python/bin/python"])?;
    let mut command = place.host.command(&python, place.instance);
    command
        .arg(place.folder.join("ask.py"))
        .arg(place.folder);
    said("Python", command)
}

fn in_c(place: &Place) -> Result<String, Error> {
    let places = ["target/release/libtaut.so", "target/debug/libtaut.so"];
    let library = needed("C", "TAUT_LIBRARY", &places)?;
    let folder = library.parent().unwrap_or(&library);
    let program = place.folder.join("ask");
    let mut compiler = Command::new("gcc");
    compiler
        .arg("-std=c11")
        .arg("-I")
        .arg(crate::programs::project().join("ipc/c/include"))
        .arg(place.folder.join("ask.c"))
        .arg("-L")
        .arg(folder)
        .arg("-ltaut")
        .arg(format!("-Wl,-rpath,{}", folder.display()))
        .arg("-o")
        .arg(&program);
    said("gcc", compiler)?;
    let mut command = place.host.command(&program, place.instance);
    command.arg(place.folder);
    said("C", command)
}

fn needed(
    name: &'static str,
    variable: &'static str,
    places: &[&str],
) -> Result<std::path::PathBuf, Error> {
    built(variable, places).ok_or(Error::NoProgram {
        name,
        variable,
        build: "`cargo test` in the project's folder builds it",
    })
}

/// What a program says that has to succeed.
fn said(name: &str, mut command: Command) -> Result<String, Error> {
    let failed = |reason: String| Error::Process {
        what: name.to_owned(),
        reason,
    };
    let output = command
        .output()
        .map_err(|error| failed(error.to_string()))?;
    let [said, errors] =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    match output.status.success() {
        true => Ok(said),
        false => Err(failed(errors.trim().replace('\n', "; "))),
    }
}

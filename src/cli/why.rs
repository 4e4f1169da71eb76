//! `taut why`: what happened to a request.

use std::path::{Path, PathBuf};

use taut_ipc::control::{ControlReply, ControlRequest, Story, StoryEvent};
use taut_ipc::planner::Planner;
use taut_ipc::wire::Code;

use super::error::{CliError, unexpected};
use super::format::{Format, print};
use super::instance::InstanceChoice;
use super::models::json;
use super::record::{absolute, recording};
use super::report;

/// Tell what happened to a request, step by step
///
/// The daemon remembers its last 4096 requests. Exit code: 0 found, 65 no such request, 69 no
/// daemon.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Id of the request in hexadecimal digits, or how it starts or ends; without it the newest
    /// requests are listed
    #[arg(default_value = "")]
    id: String,
    /// Write the request with its robot, scene and answer to this file, to send with a report and
    /// for `taut replay`
    #[arg(long, value_name = "FILE")]
    bundle: Option<PathBuf>,
    #[command(flatten)]
    instance: InstanceChoice,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Tells it.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let id = id_of(arguments)?;
    let planner = arguments.instance.connect()?;
    let stories = stories(&planner, &id)?;
    if let Some(file) = &arguments.bundle {
        bundle(&planner, id, file)?;
    }
    print(&match arguments.format {
        Format::Json => json(&stories) + "\n",
        Format::Table if arguments.id.is_empty() => stories.iter().map(line).collect(),
        Format::Table => stories
            .iter()
            .map(tell)
            .collect::<Vec<_>>()
            .join("\n"),
    })?;
    Ok(0)
}

/// The digits of the id.
///
/// # Errors
/// What is no digit; no id where one is needed.
fn id_of(arguments: &Arguments) -> Result<String, CliError> {
    let id = arguments
        .id
        .trim_start_matches("0x")
        .to_ascii_lowercase();
    if let Some(other) = id.chars().find(|c| !c.is_ascii_hexdigit()) {
        return Err(no_digit(&arguments.id, other));
    }
    if id.is_empty() && arguments.bundle.is_some() {
        return Err(CliError::Usage(
            "--bundle needs the id of a request; `taut why` lists the newest".to_owned(),
        ));
    }
    Ok(id)
}

fn no_digit(id: &str, other: char) -> CliError {
    CliError::Usage(format!(
        "request id {id:?} has {other:?}; valid: hexadecimal digits"
    ))
}

/// What the daemon remembers of requests with such an id.
fn stories(planner: &Planner, id: &str) -> Result<Vec<Story>, CliError> {
    let message = ControlRequest::Stories { id: id.to_owned() };
    match planner.control(&message)? {
        ControlReply::Stories(stories) if stories.is_empty() && !id.is_empty() => {
            Err(CliError::Choice(format!(
                "no request {id} among the last ones; `taut why` without an id lists the newest"
            )))
        }
        ControlReply::Stories(stories) => Ok(stories),
        other => Err(unexpected(&other)),
    }
}

/// Has the daemon write a request to a file.
fn bundle(planner: &Planner, id: String, file: &Path) -> Result<(), CliError> {
    let file = absolute(file)?;
    let name = file.display().to_string();
    let state = recording(planner.control(&ControlRequest::Bundle { id, file })?)?;
    eprintln!(
        "{name}: {} request, {} kB; try it with `taut replay {name} --verify`",
        state.requests,
        state.bytes.div_ceil(1000)
    );
    Ok(())
}

fn result(story: &Story) -> String {
    match story.code {
        0 => "runs".to_owned(),
        code => Code::try_from(code)
            .map_or_else(|_| format!("code {code}"), |code| code.name().to_owned()),
    }
}

fn line(story: &Story) -> String {
    let Story {
        request_id,
        pid,
        robot,
        scene,
        mode,
        waypoints,
        ..
    } = story;
    format!(
        "{request_id:016x}   pid {pid}{}   {mode} {robot} in {scene}   {waypoints} waypoints   {}\n",
        client(story),
        result(story)
    )
}

fn tell(story: &Story) -> String {
    let mut text = head(story);
    let middle = story.events.len() / 2;
    for (index, event) in story.events.iter().enumerate() {
        if index == middle && story.left_out > 0 {
            text += &format!("  {:>12}  {} more\n", "…", story.left_out);
        }
        text += &step(event);
    }
    text
}

fn step(event: &StoryEvent) -> String {
    let after_ms = event.after_ns as f64 / 1e6;
    format!("  {after_ms:>9.3} ms  {}\n", event.what)
}

/// Whose request it was, and what for.
fn head(story: &Story) -> String {
    let Story {
        request_id,
        pid,
        robot,
        scene,
        mode,
        waypoints,
        variables,
        priority,
        ..
    } = story;
    format!(
        "request {request_id:016x} of process {pid}{}   {}\n  {mode} of {waypoints} × {variables} for {robot} in {scene}{}, priority {priority}, {}\n",
        client(story),
        result(story),
        version(story),
        deadline(story)
    )
}

/// Whom its process asks for, if it says so.
fn client(story: &Story) -> String {
    match story.client.as_str() {
        "" => String::new(),
        name => format!(" for {name}"),
    }
}

fn version(story: &Story) -> String {
    match story.scene_version {
        0 => String::new(),
        version => format!(" v{version}"),
    }
}

fn deadline(story: &Story) -> String {
    match story.deadline_ns {
        0 => "no deadline".to_owned(),
        ns => format!("deadline after {}", report::time(ns as f64 * 1e-9)),
    }
}

//! `taut why`: what happened to a request.

use std::io::Write;
use std::path::PathBuf;

use taut_ipc::control::{ControlReply, ControlRequest, Story};
use taut_ipc::wire::Code;

use super::error::{CliError, stdout, unexpected};
use super::format::Format;
use super::instance::InstanceChoice;
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
    let id = arguments.id.trim_start_matches("0x").to_ascii_lowercase();
    if let Some(other) = id.chars().find(|c| !c.is_ascii_hexdigit()) {
        return Err(CliError::Usage(format!(
            "request id {:?} has {other:?}; valid: hexadecimal digits",
            arguments.id
        )));
    }
    if id.is_empty() && arguments.bundle.is_some() {
        return Err(CliError::Usage(
            "--bundle needs the id of a request; `taut why` lists the newest".to_owned(),
        ));
    }
    let planner = arguments.instance.connect()?;
    let stories = match planner.control(&ControlRequest::Stories { id: id.clone() })? {
        ControlReply::Stories(stories) => stories,
        other => return Err(unexpected(&other)),
    };
    if stories.is_empty() && !id.is_empty() {
        let text = format!(
            "no request {id} among the last ones; `taut why` without an id lists the newest"
        );
        return Err(CliError::Choice(text));
    }
    if let Some(file) = &arguments.bundle {
        let file = absolute(file)?;
        let state = recording(planner.control(&ControlRequest::Bundle {
            id,
            file: file.clone(),
        })?)?;
        let name = file.display();
        let kilobytes = state.bytes.div_ceil(1000);
        eprintln!(
            "{name}: {} request, {kilobytes} kB; try it with `taut replay {name} --verify`",
            state.requests
        );
    }
    let text = match arguments.format {
        Format::Json => {
            serde_json::to_string(&stories).expect("control replies hold only plain values") + "\n"
        }
        Format::Table if arguments.id.is_empty() => stories.iter().map(line).collect(),
        Format::Table => stories.iter().map(tell).collect::<Vec<_>>().join("\n"),
    };
    std::io::stdout()
        .lock()
        .write_all(text.as_bytes())
        .map_err(stdout)?;
    Ok(0)
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
        "{request_id:016x}   pid {pid}   {mode} {robot} in {scene}   {waypoints} waypoints   {}\n",
        result(story)
    )
}

fn tell(story: &Story) -> String {
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
    let version = if story.scene_version == 0 {
        String::new()
    } else {
        format!(" v{}", story.scene_version)
    };
    let deadline = match story.deadline_ns {
        0 => "no deadline".to_owned(),
        ns => format!("deadline after {}", report::time(ns as f64 * 1e-9)),
    };
    let mut text = format!(
        "request {request_id:016x} of process {pid}   {}\n  {mode} of {waypoints} × {variables} for {robot} in {scene}{version}, priority {priority}, {deadline}\n",
        result(story)
    );
    let middle = story.events.len() / 2;
    for (index, event) in story.events.iter().enumerate() {
        if index == middle && story.left_out > 0 {
            text += &format!("  {:>12}  {} more\n", "…", story.left_out);
        }
        text += &format!(
            "  {:>9.3} ms  {}\n",
            event.after_ns as f64 / 1e6,
            event.what
        );
    }
    text
}

//! Requests that are wrong in every way there is, while others send on.

use std::time::Duration;

use taut_ipc::control::{ControlReply, ControlRequest};
use taut_ipc::planner::Planner;
use taut_ipc::wire::{Code, Mode, RequestFlags, RequestHeader, Section};
use taut_ipc::{Client, ClientError, limits};

use super::row::Row;
use super::trial::{FAULTS, PANIC_SEED, Trial};
use crate::cli::error::CliError;
use crate::cli::error::unexpected;
use crate::cli::load_test::bare::Bare;
use crate::cli::load_test::fleet::Fleet;
use crate::cli::load_test::interrupt;
use crate::cli::load_test::orders::Job;
use crate::cli::load_test::site::{Setup, Site, number};
use crate::cli::load_test::tally::Tally;

const WITNESSES: usize = 2;
const PATIENCE: Duration = Duration::from_secs(20);

/// A wrong request and the codes that are right for it.
type Poison = (
    &'static str,
    fn(&mut RequestHeader, &mut Vec<f64>),
    &'static [Code],
);

/// What the wire itself forbids, sent past the client library.
const POISONS: [Poison; 17] = {
    use Code::*;
    [
        ("panic", |header, _| header.seed = PANIC_SEED, &[Crash]),
        ("NaN", |_, path| path[0] = f64::NAN, &[InvalidRobotState]),
        (
            "infinity",
            |_, path| *path.last_mut().expect("not empty") = f64::INFINITY,
            &[InvalidRobotState],
        ),
        (
            "far outside the limits",
            |_, path| path[0] = 1e300,
            &[InvalidRobotState],
        ),
        (
            "a million waypoints",
            |header, _| header.waypoints = 1_000_000,
            &[ResourceExhausted, MalformedRequest],
        ),
        (
            "no waypoint",
            |header, _| header.waypoints = 0,
            &[ResourceExhausted, MalformedRequest],
        ),
        (
            "4 billion columns",
            |header, _| header.variables = u32::MAX,
            &[ResourceExhausted, MalformedRequest],
        ),
        (
            "a path beyond its bytes",
            |header, _| header.path.offset = 1 << 20,
            &[MalformedRequest],
        ),
        (
            "an odd offset",
            |header, _| header.path.offset = 3,
            &[MalformedRequest],
        ),
        (
            "weights beyond the end",
            |header, _| {
                header.weights = Section {
                    offset: 0,
                    count: 1 << 30,
                }
            },
            &[ResourceExhausted, MalformedRequest],
        ),
        (
            "another wire version",
            |header, _| header.wire_version = 99,
            &[MalformedRequest],
        ),
        (
            "another header length",
            |header, _| header.header_len = 8,
            &[MalformedRequest],
        ),
        (
            "an unknown mode",
            |header, _| header.mode = 77,
            &[MalformedRequest],
        ),
        (
            "an unknown flag",
            |header, _| header.flags = 1 << 31,
            &[MalformedRequest],
        ),
        (
            "an unknown robot",
            |header, _| header.robot_id = 1,
            &[UnknownRobot],
        ),
        (
            "an unknown scene",
            |header, _| header.scene_id = 1,
            &[UnknownScene],
        ),
        (
            "a clearance that is no number",
            |header, _| header.clearance_m = f64::NAN,
            &[MalformedRequest],
        ),
    ]
};

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, CliError> {
    let site = Site::own(&Setup {
        workers: 2,
        lines: FAULTS.to_owned(),
        ..Setup::default()
    })?;
    let client = site.client()?;
    let mut witnesses = Fleet::start(site.instance(), &site.jobs, 0, WITNESSES)?;
    let bare = Bare::open(site.instance())?;
    let length = trial.pick(Duration::from_secs(4), Duration::from_secs(120));
    let window = witnesses.begin(trial.window(0), length)?;
    let mut wrong = Vec::new();
    let mut hurt = 0_u64;
    let mut rounds = 0_u64;
    while taut_ipc::monotonic_ns() < window.end_ns {
        let job = &site.jobs[rounds as usize % site.jobs.len()];
        for (name, spoil, right) in POISONS {
            interrupt::check()?;
            let code = send(&bare, job, rounds, spoil)?;
            if !code.is_some_and(|code| right.contains(&code)) {
                wrong.push(format!("{name}: {}", code.map_or("no answer", Code::name)));
            }
            hurt += u64::from(!serves(&client, job));
        }
        wrong.extend(meshes(
            &client,
            site.folder().unwrap_or(std::path::Path::new("/")),
            job,
        )?);
        rounds += 1;
    }
    let tally = Tally::of(&witnesses.finish(length)?);
    let panics = number(&client, "worker_panics")?;
    let kinds = POISONS.len() + MESHES.len();
    let said = wrong
        .first()
        .cloned()
        .unwrap_or_else(|| format!("{} requests", rounds * kinds as u64));
    Ok(vec![
        Row::none("daemon exits", u64::from(!site.is_alive())),
        Row::is(
            format!("each of {kinds} kinds gets its code"),
            "all",
            said,
            wrong.len() as f64,
            wrong.is_empty(),
        ),
        Row::none("good requests that fail right after one", hurt),
        Row::none(
            format!(
                "of {} witnesses' requests, without a proved answer",
                tally.sent
            ),
            tally.sent - tally.served,
        ),
        Row::none("witnesses' unequal answers", tally.unequal),
        Row::is(
            "workers made anew, one for each panic",
            &rounds.to_string(),
            panics.to_string(),
            panics,
            panics == rounds as f64,
        ),
    ])
}

fn send(
    bare: &Bare,
    job: &Job,
    round: u64,
    spoil: fn(&mut RequestHeader, &mut Vec<f64>),
) -> Result<Option<Code>, CliError> {
    let mut path = job.path.clone();
    let mut header = RequestHeader {
        wire_version: limits::WIRE_VERSION,
        header_len: size_of::<RequestHeader>() as u32,
        request_id: 1,
        mode: Mode::Hybrid.into(),
        // Another content each time: what crashed often is not tried again.
        work_budget: super::trial::BUDGET + round,
        path: Section {
            offset: 0,
            count: path.len() as u32,
        },
        ..job.header()
    };
    spoil(&mut header, &mut path);
    let bytes: Vec<u8> = path
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect();
    let answer = bare.exchange(header, &bytes, PATIENCE)?;
    Ok(answer.and_then(|(header, _)| Code::try_from(header.code).ok()))
}

/// Whether the daemon proves a good path.
fn serves(client: &Client, job: &Job) -> bool {
    ask(client, job, job.scene_id, job.scene_hash).is_ok_and(|code| code == Code::Success)
}

fn ask(client: &Client, job: &Job, scene_id: u64, scene_hash: u64) -> Result<Code, ClientError> {
    let mut request = client.request(job.waypoints(), job.variables);
    let mode = Mode::Check.into();
    let flags = RequestFlags::WITHOUT_CONTACTS;
    request.header = RequestHeader {
        mode,
        flags,
        scene_id,
        scene_hash,
        ..job.header()
    };
    let mut loan = request.loan()?;
    loan.path_mut().copy_from_slice(&job.path);
    Ok(loan.send()?.wait(PATIENCE)?.code())
}

/// Meshes that are none: a point, a needle, no triangle, numbers that are none, and one that goes
/// on for ever.
const MESHES: [(&str, &str); 5] = [
    ("point", "v 9 9 9\nv 9 9 9\nv 9 9 9\nf 1 2 3\n"),
    ("needle", "v 9 9 9\nv 10 9 9\nv 11 9 9\nf 1 2 3\n"),
    ("empty", "# nothing\n"),
    ("nan", "v nan 9 9\nv 9 9 inf\nv 9 9 9\nf 1 2 3\n"),
    ("dangling", "v 9 9 9\nv 8 9 9\nv 8 8 9\nf 1 2 900000\n"),
];

/// Loads each as a scene and, where that is taken, has a path checked in it: either is refused by a
/// code, or answered.
fn meshes(client: &Client, folder: &std::path::Path, job: &Job) -> Result<Vec<String>, CliError> {
    let mut wrong = Vec::new();
    for (name, text) in MESHES {
        let file = format!("{name}.obj");
        let written = std::fs::write(folder.join(&file), text);
        written.map_err(|source| CliError::Output {
            file: file.clone(),
            source,
        })?;
        let json = format!(
            r#"{{"objects": [{{"id": "m", "meshes": [{{"file": "{file}"}}], "mesh_poses": [{{}}]}}]}}"#
        );
        let base_dir = Some(folder.to_owned());
        let message = ControlRequest::LoadScene {
            label: format!("mesh_{name}"),
            json,
            base_dir,
            replace: true,
        };
        match Planner::new(client.clone())
            .control(&message)
            .map_err(CliError::from)
        {
            Ok(ControlReply::Scene(scene)) => {
                if let Err(error) = ask(client, job, scene.scene_id, scene.scene_hash) {
                    wrong.push(format!("mesh {name}: {error}"));
                }
            }
            Ok(other) => return Err(unexpected(&other)),
            Err(CliError::Refused {
                code: Code::InvalidModel | Code::UnreadableFile,
                ..
            }) => (),
            Err(error) => wrong.push(format!("mesh {name}: {error}")),
        }
    }
    Ok(wrong)
}

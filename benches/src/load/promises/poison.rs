//! Requests that are wrong in every way there is, while others send on.

use std::path::Path;
use std::time::Duration;

use taut_ipc::control::ControlRequest;
use taut_ipc::wire::{Code, Mode, RequestFlags, RequestHeader, Section};
use taut_ipc::{Client, ClientError, limits, monotonic_ns};

use super::row::Row;
use super::trial::{FAULTS, PANIC_SEED, Trial};
use crate::error::Error;
use crate::load::bare::Bare;
use crate::load::control::{number, scene};
use crate::load::fleet::Fleet;
use crate::load::interrupt;
use crate::load::orders::Job;
use crate::load::site::{Setup, Site};
use crate::load::tally::Tally;
use crate::output::write;

const WITNESSES: usize = 2;
const PATIENCE: Duration = Duration::from_secs(20);

/// Makes a good request wrong.
type Spoil = fn(&mut RequestHeader, &mut Vec<f64>);
/// A wrong request and the codes that are right for it.
type Poison = (&'static str, Spoil, &'static [Code]);

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

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let site = Site::own(&Setup {
        workers: 2,
        lines: FAULTS.to_owned(),
        ..Setup::default()
    })?;
    let mut witnesses = Fleet::start(site.instance(), &site.jobs, 0, WITNESSES)?;
    let mut poisoner = Poisoner {
        site: &site,
        client: site.client()?,
        bare: Bare::open(site.instance())?,
        wrong: Vec::new(),
        hurt: 0,
        rounds: 0,
    };
    let length = trial.pick(Duration::from_secs(4), Duration::from_secs(120));
    let window = witnesses.begin(trial.window(0), length)?;
    while monotonic_ns() < window.end_ns {
        poisoner.round()?;
    }
    let witnessed = Tally::of(&witnesses.finish(length)?);
    poisoner.rows(&witnessed)
}

/// Sends every wrong request, round after round.
struct Poisoner<'a> {
    site: &'a Site,
    client: Client,
    bare: Bare,
    /// Poisons that had a wrong code, and which.
    wrong: Vec<String>,
    /// Good requests that failed right after one.
    hurt: u64,
    rounds: u64,
}

impl Poisoner<'_> {
    fn round(&mut self) -> Result<(), Error> {
        let job = &self.site.jobs[self.rounds as usize % self.site.jobs.len()];
        for poison in POISONS {
            interrupt::check()?;
            self.poison(job, poison)?;
            self.hurt += u64::from(!serves(&self.client, job));
        }
        let folder = self.site.folder().unwrap_or(Path::new("/"));
        self.wrong
            .extend(meshes(&self.client, folder, job)?);
        self.rounds += 1;
        Ok(())
    }

    fn poison(&mut self, job: &Job, (name, spoil, right): Poison) -> Result<(), Error> {
        let code = send(&self.bare, job, self.rounds, spoil)?;
        if !code.is_some_and(|code| right.contains(&code)) {
            let code = code.map_or("no answer", Code::name);
            self.wrong.push(format!("{name}: {code}"));
        }
        Ok(())
    }

    fn rows(&self, witnessed: &Tally) -> Result<Vec<Row>, Error> {
        let panics = number(&self.client, "worker_panics")?;
        let rounds = self.rounds;
        Ok(vec![
            Row::none("daemon exits", u64::from(!self.site.is_alive())),
            self.codes(),
            Row::none("good requests that fail right after one", self.hurt),
            witnessed.unserved("witnesses' requests"),
            Row::none("witnesses' unequal answers", witnessed.unequal),
            Row::is(
                "workers made anew, one for each panic",
                &rounds.to_string(),
                panics.to_string(),
                panics,
                panics == rounds as f64,
            ),
        ])
    }

    fn codes(&self) -> Row {
        let kinds = POISONS.len() + MESHES.len();
        let sent = format!("{} requests", self.rounds * kinds as u64);
        Row::is(
            format!("each of {kinds} kinds gets its code"),
            "all",
            self.wrong.first().cloned().unwrap_or(sent),
            self.wrong.len() as f64,
            self.wrong.is_empty(),
        )
    }
}

fn send(bare: &Bare, job: &Job, round: u64, spoil: Spoil) -> Result<Option<Code>, Error> {
    let mut path = job.path.clone();
    let mut header = good(job, round);
    spoil(&mut header, &mut path);
    let bytes: Vec<u8> = path
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect();
    let answer = bare.exchange(header, &bytes, PATIENCE)?;
    Ok(answer.and_then(|(header, _)| Code::try_from(header.code).ok()))
}

/// The header before it is spoilt.
fn good(job: &Job, round: u64) -> RequestHeader {
    RequestHeader {
        wire_version: limits::WIRE_VERSION,
        header_len: size_of::<RequestHeader>() as u32,
        request_id: 1,
        mode: Mode::Hybrid.into(),
        // Another content each time: what crashed often is not tried again.
        work_budget: super::trial::BUDGET + round,
        path: Section {
            offset: 0,
            count: job.path.len() as u32,
        },
        ..job.header()
    }
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
/// code, or answered. Tells which are neither.
fn meshes(client: &Client, folder: &Path, job: &Job) -> Result<Vec<String>, Error> {
    let mut wrong = Vec::new();
    for (name, text) in MESHES {
        let file = format!("{name}.obj");
        write(&folder.join(&file), text)?;
        match scene(client, &load(name, &file, folder)) {
            Ok(scene) => {
                let code = ask(client, job, scene.scene_id, scene.scene_hash);
                wrong.extend(
                    code.err()
                        .map(|error| format!("mesh {name}: {error}")),
                );
            }
            Err(Error::Refused {
                code: Code::InvalidModel | Code::UnreadableFile,
                ..
            }) => (),
            Err(error) => wrong.push(format!("mesh {name}: {error}")),
        }
    }
    Ok(wrong)
}

/// A scene of one mesh.
fn load(name: &str, file: &str, folder: &Path) -> ControlRequest {
    ControlRequest::LoadScene {
        label: format!("mesh_{name}"),
        json: format!(
            r#"{{"objects": [{{"id": "m", "meshes": [{{"file": "{file}"}}], "mesh_poses": [{{}}]}}]}}"#
        ),
        base_dir: Some(folder.to_owned()),
        replace: true,
        files: None,
        version: None,
    }
}

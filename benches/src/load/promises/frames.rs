//! A camera at 30 Hz: each frame is its scene's next version soon, watched paths hear of it, and
//! planners hardly notice.

use std::time::{Duration, Instant};

use taut_ipc::control::{CloudFrame, ControlReply, ControlRequest, PointField, PointLayout};
use taut_ipc::planner::Planner;
use taut_ipc::wire::{Mode, RequestFlags, RequestHeader};
use taut_ipc::{Client, monotonic_ns};

use super::row::Row;
use super::trial::{Trial, run};
use crate::error::Error;
use crate::load::fleet::Fleet;
use crate::load::interrupt;
use crate::load::orders::{Job, Window};
use crate::load::process::private_bytes;
use crate::load::site::{Setup, Site};
use crate::load::tally::Tally;
use crate::load::times::Times;

/// The problem that is looked at.
const PROBLEM: &str = "arm_shelf";
/// Its sensed object.
const OBJECT: &str = "camera";
/// Rows and columns of a picture.
const PICTURE: [u32; 2] = [480, 640];
/// Part of the pixels that have a depth, as of real frames.
const SEEN: f64 = 0.62;
/// Time from a frame to the next.
const PERIOD: Duration = Duration::from_nanos(33_333_333);
/// Planners, and each's deadline.
const PLANNERS: usize = 8;
const DEADLINE_NS: u64 = 3_000_000;
/// Watched paths: as many on a connection as there may be.
const WATCHERS: usize = 25;
const WATCHES: usize = 4;
/// How long a verdict may take.
const PATIENCE: Duration = Duration::from_secs(5);

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let site = Site::own(&Setup {
        workers: 1,
        ..Setup::default()
    })?;
    let camera = Camera::new(&site, trial.seed)?;
    camera.see(0)?;
    let jobs: Vec<Job> = site
        .jobs
        .iter()
        .filter(|job| job.name == PROBLEM)
        .map(|job| Job {
            scene_hash: 0,
            ..job.clone()
        })
        .collect();
    let mut rows = beside_planners(trial, &site, &jobs, &camera)?;
    rows.extend(watched(trial, &site, &jobs[0], &camera)?);
    rows.push(Row::none("daemon exits", u64::from(!site.is_alive())));
    Ok(rows)
}

/// Frames while planners ask, and planners without frames as the control.
fn beside_planners(
    trial: &Trial,
    site: &Site,
    jobs: &[Job],
    camera: &Camera,
) -> Result<Vec<Row>, Error> {
    let length = trial.pick(Duration::from_secs(3), Duration::from_secs(600));
    let window = Window {
        budget: 0,
        deadline_ns: DEADLINE_NS,
        ..trial.window(0)
    };
    let mut fleet = Fleet::start(site.instance(), jobs, 0, PLANNERS)?;
    let calm = run(&mut fleet, window, length.min(Duration::from_secs(20)))?;
    let pid = site.serving()?;
    fleet.begin(window, length)?;
    let warm = frames_for(camera, length / 10)?;
    let before = private_bytes(pid);
    let mut seen = frames_for(camera, length - length / 10)?;
    let grown = private_bytes(pid).saturating_sub(before);
    let disturbed = Tally::of(&fleet.finish(length)?);
    seen.extend(warm);
    let wall = times(seen.iter().map(|taken| taken.wall_ns));
    let cpu = times(seen.iter().map(|taken| taken.cpu_ns));
    let two_periods = 2 * PERIOD.as_nanos() as u64;
    let old = seen
        .iter()
        .filter(|taken| taken.wall_ns > two_periods);
    let p99 = |tally: &Tally| tally.latency.quantile(0.99);
    let points = camera.points;
    Ok(vec![
        Row::time(
            format!("CPU from frame to version, {points} points, p50"),
            0.010,
            cpu.quantile(0.5),
        ),
        Row::time(
            format!(
                "wall from loan to usable version, {} frames, p99",
                seen.len()
            ),
            0.033,
            wall.quantile(0.99),
        ),
        Row::none("frames older than two periods", old.count() as u64),
        Row::at_most(
            "planners' p99 beside frames / without",
            1.5,
            p99(&disturbed) / p99(&calm),
        ),
        disturbed.endless("requests beside frames"),
        Row::is(
            "private memory that ten minutes of frames add",
            "<= 32 MiB",
            format!("{} MiB", grown >> 20),
            grown as f64,
            grown <= 32 << 20,
        ),
    ])
}

/// What it took until a frame was a version.
struct Taken {
    wall_ns: u64,
    cpu_ns: u64,
}

fn times(all: impl Iterator<Item = u64>) -> Times {
    let mut times = Times::default();
    all.for_each(|time_ns| times.add(time_ns));
    times
}

fn frames_for(camera: &Camera, length: Duration) -> Result<Vec<Taken>, Error> {
    let end = Instant::now() + length;
    let mut taken = Vec::new();
    while Instant::now() < end {
        interrupt::check()?;
        let next = Instant::now() + PERIOD;
        taken.push(camera.see(taken.len())?);
        std::thread::sleep(next.saturating_duration_since(Instant::now()));
    }
    Ok(taken)
}

/// Watched paths hear of each frame that changes their verdict, as each second one here does.
fn watched(trial: &Trial, site: &Site, job: &Job, camera: &Camera) -> Result<Vec<Row>, Error> {
    let clients: Vec<Client> = (0..WATCHERS)
        .map(|_| site.client())
        .collect::<Result<_, _>>()?;
    let mut watches = Vec::new();
    for client in &clients {
        for _ in 0..WATCHES {
            let mut request = client.request(job.waypoints(), job.variables);
            request.header = RequestHeader {
                mode: Mode::Check.into(),
                flags: RequestFlags::WATCH,
                ..job.header()
            };
            let mut loan = request.loan()?;
            loan.path_mut().copy_from_slice(&job.path);
            watches.push(loan.send()?);
        }
    }
    let mut proved = Vec::new();
    for watch in &mut watches {
        proved.push(verdict(watch)?);
    }
    let mut late = Times::default();
    let mut wrong = proved.iter().filter(|proved| !**proved).count() as u64;
    for number in 0..trial.pick(30, 900) {
        interrupt::check()?;
        let is_free = number % 2 == 1;
        let start = Instant::now();
        camera.see_with(if is_free { Sight::Free } else { Sight::Blocked })?;
        for watch in &mut watches {
            wrong += u64::from(verdict(watch)? != is_free);
        }
        late.add(start.elapsed().as_nanos() as u64);
        std::thread::sleep((start + PERIOD).saturating_duration_since(Instant::now()));
    }
    let count = watches.len();
    Ok(vec![
        Row::time(
            format!("from a frame to the last of {count} watchers' verdicts, p50"),
            PERIOD.as_secs_f64(),
            late.quantile(0.5),
        ),
        Row::none("of these, verdicts that are wrong or missing", wrong),
    ])
}

fn verdict(watch: &mut taut_ipc::client::Pending) -> Result<bool, Error> {
    let answer = watch.next(PATIENCE)?;
    let answer = answer.ok_or(taut_ipc::ClientError::NoAnswer)?;
    let view = answer
        .view()
        .map_err(taut_ipc::ClientError::from)?;
    Ok(view.is_proved())
}

/// What is in the picture besides wall and robot.
#[derive(Clone, Copy, PartialEq)]
enum Sight {
    Free,
    Blocked,
}

/// A camera that looks at the robot, before a wall, with noise.
struct Camera {
    planner: Planner,
    pid: u32,
    joints: Vec<(String, f64)>,
    pictures: [Vec<u8>; 2],
    blocked: Vec<u8>,
    points: usize,
}

impl Camera {
    fn new(site: &Site, seed: u64) -> Result<Self, Error> {
        let client = site.client()?;
        let diff = format!(
            r#"{{"is_diff": true, "objects": [{{"id": "{OBJECT}", "operation": "ADD", "sensed": {{"radius": 0.003, "self_padding": 0.02}}}}]}}"#
        );
        let message = ControlRequest::DiffScene {
            label: PROBLEM.to_owned(),
            json: diff,
            base_dir: None,
            base_version: 0,
            files: None,
            version: None,
        };
        let reply = client.control(&message, PATIENCE)?;
        if let ControlReply::Refused(refusal) = reply {
            return Err(Error::DaemonGone(refusal.message));
        }
        let planner = Planner::new(client);
        let robot = planner.robot(PROBLEM)?;
        let job = site.jobs.iter().find(|job| job.name == PROBLEM);
        let path = job.map_or(&[][..], |job| &job.path);
        let names = robot
            .variables
            .iter()
            .map(|variable| variable.name.clone());
        let joints = names.zip(path.iter().copied()).collect();
        let mut random = fastrand::Rng::with_seed(seed);
        let pictures = [0, 1].map(|_| picture(&mut random, Sight::Free));
        let points = pictures[0]
            .chunks_exact(16)
            .filter(|point| {
                f32::from_le_bytes([point[0], point[1], point[2], point[3]]).is_finite()
            })
            .count();
        Ok(Self {
            planner,
            pid: site.serving()?,
            joints,
            blocked: picture(&mut random, Sight::Blocked),
            pictures,
            points,
        })
    }

    fn see(&self, number: usize) -> Result<Taken, Error> {
        self.send(&self.pictures[number % 2])
    }

    fn see_with(&self, sight: Sight) -> Result<Taken, Error> {
        match sight {
            Sight::Free => self.send(&self.pictures[0]),
            Sight::Blocked => self.send(&self.blocked),
        }
    }

    /// Writes a picture into shared memory, as a driver would; the clock runs from the loan on.
    fn send(&self, picture: &[u8]) -> Result<Taken, Error> {
        let [height, width] = PICTURE;
        let start = Instant::now();
        let before_ns = frames_cpu_ns(self.pid);
        let frame = CloudFrame {
            taken_ns: monotonic_ns(),
            pose: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            robot: PROBLEM.to_owned(),
            link: String::new(),
            joints: self.joints.clone(),
            layout: PointLayout {
                height,
                width,
                point_step: 16,
                row_step: 16 * width,
                ..PointLayout::packed(1, PointField::FLOAT32)
            },
        };
        let mut loan = self
            .planner
            .loan_frame(PROBLEM, OBJECT, frame, picture.len())?;
        loan.body_mut().copy_from_slice(picture);
        self.planner.send_frame(loan)?;
        Ok(Taken {
            wall_ns: start.elapsed().as_nanos() as u64,
            cpu_ns: frames_cpu_ns(self.pid) - before_ns,
        })
    }
}

/// CPU time of the thread that reads frames (ns).
fn frames_cpu_ns(pid: u32) -> u64 {
    let tasks = std::fs::read_dir(format!("/proc/{pid}/task"));
    let folders = tasks
        .into_iter()
        .flatten()
        .flatten()
        .map(|task| task.path());
    let is_reader = |folder: &std::path::PathBuf| {
        let name = std::fs::read_to_string(folder.join("comm"));
        name.is_ok_and(|name| name.trim() == "taut-frames")
    };
    let spent = folders.filter(is_reader).map(|folder| {
        let text = std::fs::read_to_string(folder.join("schedstat")).unwrap_or_default();
        text.split(' ')
            .next()
            .and_then(|ns| ns.parse::<u64>().ok())
            .unwrap_or(0)
    });
    spent.sum()
}

/// Points of 16 bytes, row by row: a wall with noise behind everything that moves, a third without
/// a depth; blocked, a board where the robot is to go.
fn picture(random: &mut fastrand::Rng, sight: Sight) -> Vec<u8> {
    let [height, width] = PICTURE;
    let mut bytes = Vec::with_capacity((height * width * 16) as usize);
    for row in 0..height {
        for column in 0..width {
            let across = f64::from(column) / f64::from(width) - 0.5;
            let up = 1.0 - f64::from(row) / f64::from(height);
            let noise = 0.004 * (random.f64() - 0.5);
            let is_board = sight == Sight::Blocked && across.abs() < 0.25;
            let x = if is_board { 0.45 } else { 1.6 };
            let point = match random.f64() < SEEN {
                true => [x + noise, 2.4 * across, 1.6 * up + 0.05],
                false => [f64::NAN; 3],
            };
            bytes.extend(
                point
                    .iter()
                    .flat_map(|value| (*value as f32).to_le_bytes()),
            );
            bytes.extend([0; 4]);
        }
    }
    bytes
}

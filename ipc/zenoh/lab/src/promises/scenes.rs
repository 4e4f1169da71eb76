//! A scene that is changed at its home is the same at those that follow it, whoever joins, leaves or is
//! cut off meanwhile.

use std::collections::BTreeMap;
use std::time::Duration;

use taut_ipc::planner::words::{Pose, moved};
use taut_ipc::planner::{Planner, PlannerError};

use super::trial::Trial;
use crate::daemon::Daemon;
use crate::error::Error;
use crate::fleet::Member;
use crate::gateway::{Attached, Station, endpoint, serve};
use crate::jobs::job;
use crate::model;
use crate::network::{Host, Link, Weather, cable, hosts};
use crate::orders::{Asking, Job, Tally};
use crate::process::{Process, until};
use crate::row::Row;
use crate::statistics::time;

const LABEL: &str = "lab";
/// A box that is moved, and a mesh whose file is on one machine alone.
const SCENE: &str = r#"{"name": "lab", "objects": [{"id": "box",
    "primitives": [{"type": "box", "dimensions": [0.2, 0.2, 0.2]}],
    "primitive_poses": [{"position": [6, 6, 0], "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}]},
    {"id": "block", "meshes": [{"file": "cube.obj"}],
    "mesh_poses": [{"position": [9, 9, 0], "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}]}]}"#;
const PATIENCE: Duration = Duration::from_secs(20);
/// How long whoever leaves is away.
const AWAY: Duration = Duration::from_millis(300);

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let [home, cut, leaving, planners] = hosts(["home", "cut", "leaving", "planners"])?;
    let link = Link::between(&home, &cut, trial.seed)?;
    cable(&home, &leaving)?;
    cable(&home, &planners)?;
    let _home = Station::start(&home, 1, &[])?;
    let attached = Attached::start(&planners, "attached", &[endpoint(&home)], &[])?;
    let writer = Planner::connect(attached.instance())?;
    let folder = model::write(planners.folder())?;
    writer.load_scene(LABEL, SCENE, Some(&folder), false)?;
    let mut site = Site {
        cut: Follower::start(&cut, &home)?,
        leaving: Follower::start(&leaving, &home)?,
        home_planner: Planner::connect(_home.daemon.instance())?,
        changes: Changes::of(writer)?,
        link,
    };
    let reader = Member::planner(&cut, site.cut.daemon.instance())?;
    site.run(trial, reader, [&leaving, &home])
}

/// A daemon whose gateway follows the home's scenes.
struct Follower {
    // Before the daemon: fields are dropped in order.
    gateway: Process,
    planner: Planner,
    daemon: Daemon,
}

impl Follower {
    fn start(host: &Host, home: &Host) -> Result<Self, Error> {
        let daemon = Daemon::start(host, "daemon", 1)?;
        Ok(Self {
            gateway: follow(host, home, &daemon)?,
            planner: Planner::connect(daemon.instance())?,
            daemon,
        })
    }

    /// Time until it has what the home has (s).
    fn is_equal_after(&self, home: &Planner) -> Option<Duration> {
        until(PATIENCE, || {
            let own = hash(&self.planner);
            own.is_some() && own == hash(home)
        })
    }
}

fn follow(host: &Host, home: &Host, daemon: &Daemon) -> Result<Process, Error> {
    serve(
        host,
        daemon,
        &["--follow", home.name(), "--connect", &endpoint(home)],
    )
}

/// Version and content of the scene; `None` where there is none.
fn hash(planner: &Planner) -> Option<(u64, u64)> {
    let listing = planner.list().ok()?;
    let scene = listing
        .scenes
        .iter()
        .find(|scene| scene.label == LABEL)?;
    Some((scene.version, scene.scene_hash))
}

/// Who changes the scene, and what was acknowledged: content by version.
struct Changes {
    writer: Planner,
    acknowledged: BTreeMap<u64, u64>,
    refused: u64,
}

impl Changes {
    fn of(writer: Planner) -> Result<Self, Error> {
        let first = hash(&writer).into_iter().collect();
        Ok(Self {
            writer,
            acknowledged: first,
            refused: 0,
        })
    }

    fn make(&mut self, count: usize, pause: Duration) {
        for number in 0..count {
            let place = [
                6.0 + 0.001 * number as f64,
                6.0,
                0.1 * self.acknowledged.len() as f64,
            ];
            let diff = moved("box", None, &Pose::at(place));
            match self.writer.change_scene(LABEL, &diff, None, 0) {
                Ok(scene) => {
                    _ = self
                        .acknowledged
                        .insert(scene.version, scene.scene_hash)
                }
                Err(error) => self.refuse(&error),
            }
            std::thread::sleep(pause);
        }
    }

    fn refuse(&mut self, error: &PlannerError) {
        self.refused += 1;
        eprintln!("a change is refused: {error}");
    }

    /// Answers that name a version with another content than was acknowledged.
    fn contradicted(&self, tally: &Tally) -> u64 {
        let other = tally
            .scenes
            .iter()
            .filter(|(version, hash)| self.acknowledged.get(version) != Some(hash));
        other.count() as u64
    }
}

struct Site {
    cut: Follower,
    leaving: Follower,
    home_planner: Planner,
    changes: Changes,
    link: Link,
}

impl Site {
    fn run(
        &mut self,
        trial: &Trial,
        mut reader: Member,
        [leaving, home]: [&Host; 2],
    ) -> Result<Vec<Row>, Error> {
        let [before, during] = trial.pick([60, 60], [300, 700]);
        let pause = Duration::from_millis(trial.pick(20, 35));
        let joined = self.cut.is_equal_after(&self.home_planner);
        let asking = Asking {
            jobs: vec![asked()?],
            length_ms: (before + during) as u64 * pause.as_millis() as u64,
            patience_ms: 30_000,
            ..Asking::default()
        };
        reader.begin(&asking)?;
        self.come_and_go(before, pause, leaving, home)?;
        self.link.set(Weather::CUT);
        self.changes.make(during, pause);
        std::thread::sleep(Duration::from_secs(trial.pick(0, 5)));
        self.link.set(Weather::CLEAR);
        let healed = self.cut.is_equal_after(&self.home_planner);
        let left = self.leaving.is_equal_after(&self.home_planner);
        let read = reader.done(&asking)?;
        Ok(self.rows(&read, [joined, healed, left]))
    }

    /// Changes while one that follows leaves and joins again.
    fn come_and_go(
        &mut self,
        changes: usize,
        pause: Duration,
        leaving: &Host,
        home: &Host,
    ) -> Result<(), Error> {
        for _ in 0..3 {
            self.changes.make(changes / 6, pause);
            self.leaving.gateway.end();
            std::thread::sleep(AWAY);
            self.changes.make(changes / 6, pause);
            self.leaving.gateway = follow(leaving, home, &self.leaving.daemon)?;
        }
        Ok(())
    }

    fn rows(&self, read: &Tally, [joined, healed, left]: [Option<Duration>; 3]) -> Vec<Row> {
        let made = self.changes.acknowledged.len() as u64 - 1;
        let never = |equal: Option<Duration>| u64::from(equal.is_none());
        let seconds = |equal: Option<Duration>| equal.unwrap_or(PATIENCE).as_secs_f64();
        let newest = self.changes.acknowledged.last_key_value();
        let home = hash(&self.home_planner);
        let is_kept = home == newest.map(|(version, hash)| (*version, *hash));
        vec![
            Row::none(
                format!("changes refused, of {}", made + self.changes.refused),
                self.changes.refused,
            ),
            Row::none(
                "acknowledged changes that the home lost",
                u64::from(!is_kept),
            ),
            Row::none("late joiners that never get equal", never(joined)),
            Row::none("those cut off that never get equal", never(healed)),
            Row::none(
                "those that left and came again that never get equal",
                never(left),
            ),
            Row::time("from healing to equal content", 3.0, seconds(healed)),
            Row::told(
                "  from joining, from coming again",
                [joined, left].map(seconds).map(time).join(", "),
            ),
            Row::none(
                format!(
                    "of {} answers' scenes, another content than acknowledged",
                    read.scenes.len()
                ),
                self.changes.contradicted(read),
            ),
            Row::none(
                format!("of {} requests there, without an end", read.sent),
                read.endless,
            ),
            Row::told("  how they ended", read.told()),
        ]
    }
}

/// What is asked at the follower that is cut off.
fn asked() -> Result<Job, Error> {
    Ok(Job {
        scene: Some(LABEL.to_owned()),
        ..job("rooms")?
    })
}

//! What was loaded through an attached instance is there for requests that another gateway answers,
//! also one that comes later; or a code says what is missing.

use std::time::Duration;

use super::trial::Trial;
use crate::daemon::Daemon;
use crate::error::Error;
use crate::fleet::Member;
use crate::gateway::{Attached, Station, endpoint, serve};
use crate::model;
use crate::network::{cable, hosts};
use crate::orders::{Asking, Job, Tally};
use crate::row::Row;

/// Until planners know that a gateway is there or gone.
const KNOWN: Duration = Duration::from_millis(1_500);

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let [a, b, planners] = hosts(["a", "b", "planners"])?;
    cable(&a, &planners)?;
    cable(&b, &planners)?;
    let mut first = Station::start(&a, 1, &[])?;
    let later = Daemon::start(&b, "daemon", 1)?;
    let connect = [endpoint(&a), endpoint(&b)];
    let best_first = ["--daemon", "a", "--daemon", "b"];
    let attached = Attached::start(&planners, "attached", &connect, &best_first)?;
    let mut member = Member::planner(&planners, attached.instance())?;
    member.load(&model::write(planners.folder())?)?;
    let count = trial.pick(8, 80);
    let with_scene = asking(model::job(), count);
    let without = asking(alone(), count);
    let before = member.ask(&with_scene)?;
    let _gateway = serve(&b, &later, &[])?;
    std::thread::sleep(KNOWN);
    first.gateway.end();
    let robot = member.ask(&without)?;
    let scene = member.ask(&asking(model::job(), 1))?;
    first.gateway = serve(&a, &first.daemon, &[])?;
    std::thread::sleep(KNOWN);
    let after = member.ask(&with_scene)?;
    Ok(vec![
        unserved("where they were loaded", &before),
        unserved("of the robot where nobody loaded it", &robot),
        Row::is(
            "a request with the scene there, which has its home elsewhere",
            "UnknownScene",
            scene.told(),
            scene.ended("UnknownScene") == 1,
        ),
        unserved("of both when the home is back", &after),
    ])
}

fn unserved(which: &str, tally: &Tally) -> Row {
    Row::none(
        format!(
            "of {} requests {which}, without a proved answer",
            tally.sent
        ),
        tally.sent - tally.served(),
    )
}

/// The robot in the open.
fn alone() -> Job {
    Job {
        name: "alone".to_owned(),
        scene: None,
        ..model::job()
    }
}

fn asking(job: Job, count: u64) -> Asking {
    Asking {
        jobs: vec![job],
        count,
        patience_ms: 30_000,
        ..Asking::default()
    }
}

use std::sync::Arc;

use taut::optimize::Settings;
use taut::path::Path;
use taut::robot::{LinkDescription, RobotDescription, RobotModel};
use taut::scene::Scene;
use taut::store::{PreparedModel, Snapshot};

use super::*;
use crate::daemon::service::client::Client;

const MILLISECOND: u64 = 1_000_000;

fn job(id: u64, client: u128, priority: u32, deadline_ns: Option<u64>) -> Job {
    let links = vec![LinkDescription {
        name: "base".to_owned(),
        collision: Vec::new(),
    }];
    let robot = Arc::new(
        RobotModel::new(RobotDescription {
            links,
            ..RobotDescription::default()
        })
        .unwrap(),
    );
    let scene = Arc::new(Scene::default());
    let model = Arc::new(PreparedModel::new(robot.clone(), scene.clone()));
    model.give_up();
    Job {
        id,
        request_id: id,
        client: Client { id: client, pid: 0 },
        snapshot: Snapshot {
            robot,
            weights: Arc::new([]),
            scene,
            model,
            scene_id: 0,
            scene_hash: 0,
            scene_version: 1,
        },
        path: Path::from_rows(1, vec![0.0]).unwrap().into(),
        settings: Settings::default().into(),
        timing: None,
        deadline_ns,
        received_ns: 0,
        priority,
        stop: Arc::default(),
        asked: Default::default(),
    }
}

/// When all begins.
const NOW: u64 = 1_000 * MILLISECOND;

/// A schedule of one slot, which a job of client 1 has.
fn busy() -> Schedule {
    let mut schedule = Schedule::new(1, Arc::default());
    schedule.push(job(1, 1, 0, None), NOW);
    assert_eq!(granted(&mut schedule), [1]);
    schedule
}

/// What has got a slot since this was last asked.
fn granted(schedule: &mut Schedule) -> Vec<u64> {
    let granted = schedule.granted().into_iter();
    granted
        .map(|granted| match granted {
            Granted::Begin(job) => job.id,
            Granted::GoOn(job) => job,
        })
        .collect()
}

#[test]
fn nobody_makes_room_for_nobody() {
    let mut schedule = busy();
    assert!(
        !schedule
            .pressure
            .is_felt(0, NOW, NOW + 1000 * MILLISECOND)
    );
    assert!(!schedule.makes_room(1, NOW + 1000 * MILLISECOND));
}

#[test]
fn a_long_job_makes_room_for_anothers_short_one_and_goes_on() {
    let mut schedule = busy();
    schedule.push(job(2, 2, 0, None), NOW);
    assert!(
        !schedule.pressure.is_felt(0, NOW, NOW + 1),
        "not before a look is due"
    );
    assert!(
        schedule
            .pressure
            .is_felt(0, NOW, NOW + MILLISECOND)
    );
    assert!(
        !schedule.makes_room(1, NOW + MILLISECOND),
        "it has a share too"
    );
    let late_ns = NOW + order::SHARE_NS + 2 * MILLISECOND;
    assert!(schedule.makes_room(1, late_ns));
    assert_eq!(granted(&mut schedule), [2]);
    schedule.finish(2, late_ns + MILLISECOND);
    assert_eq!(granted(&mut schedule), [1], "it goes on");
    let turn = schedule
        .finish(1, late_ns + 2 * MILLISECOND)
        .unwrap();
    assert_eq!(turn.pauses, 1);
    let most_ns = order::SHARE_NS + 3 * MILLISECOND;
    assert!(
        (order::SHARE_NS..=most_ns).contains(&turn.used_ns),
        "without its pause: {}",
        turn.used_ns
    );
    assert_eq!(schedule.free_slots, 1);
}

/// What a job has had is forgotten while it waits, so that short jobs of others, however many come,
/// hold it up for a while only.
#[test]
fn a_job_that_made_room_goes_on_beside_a_stream_of_short_ones() {
    let mut schedule = busy();
    let mut now_ns = NOW + 6 * order::SHARE_NS;
    schedule.push(job(2, 2, 0, None), now_ns);
    assert!(schedule.makes_room(1, now_ns));
    let mut short = 2;
    while granted(&mut schedule) != [1] {
        // One of eight other clients always has one that waits.
        now_ns += MILLISECOND;
        schedule.push(job(short + 1, u128::from(2 + short % 8), 0, None), now_ns);
        schedule.finish(short, now_ns);
        short += 1;
        assert!(now_ns < NOW + 1000 * MILLISECOND, "it waits for ever");
    }
}

#[test]
fn a_higher_class_goes_first_at_once() {
    let mut schedule = busy();
    schedule.push(job(2, 1, 1, None), NOW);
    assert!(schedule.pressure.is_felt(0, NOW, NOW + 1));
    assert!(schedule.makes_room(1, NOW + 1));
    assert_eq!(granted(&mut schedule), [2]);
}

#[test]
fn a_job_that_is_over_ends_without_a_slot() {
    let mut schedule = busy();
    schedule.push(job(2, 2, 1, None), NOW);
    assert!(schedule.makes_room(1, NOW + 1) && schedule.is_paused(1));
    assert_eq!(granted(&mut schedule), [2], "the slot is the other's");
    schedule.over(1, NOW + 2);
    assert_eq!(granted(&mut schedule), [1], "to its end");
    schedule.over(1, NOW + 2);
    schedule.finish(1, NOW + 3);
    assert_eq!(schedule.free_slots, 0);
    schedule.finish(2, NOW + 4);
    assert_eq!((schedule.free_slots, schedule.begun.len()), (1, 0));
    assert!(granted(&mut schedule).is_empty());
}

#[test]
fn so_many_make_room_and_no_more() {
    let mut schedule = busy();
    let mut now_ns = NOW;
    for id in 2..=20 {
        now_ns += order::SHARE_NS + 5 * MILLISECOND;
        schedule.push(job(id, id.into(), 0, None), now_ns);
        let running = schedule
            .begun
            .values()
            .find(|turn| turn.has_slot())
            .map(|turn| turn.job);
        schedule.makes_room(running.unwrap(), now_ns);
    }
    assert_eq!(schedule.begun.len(), PAUSED_PER_SLOT + 1);
    schedule.push(job(50, 50, 1, None), now_ns);
    let running = schedule
        .begun
        .values()
        .find(|turn| turn.has_slot())
        .map(|turn| turn.job);
    assert!(
        schedule.makes_room(running.unwrap(), now_ns),
        "for a higher class"
    );
    assert!(schedule.begun.len() <= most_begun(1));
}

#[test]
fn what_is_taken_out_leaves_nothing_behind() {
    let mut schedule = busy();
    schedule.push(job(2, 2, 0, Some(NOW)), NOW);
    schedule.push(job(3, 3, 0, Some(NOW + 1000 * MILLISECOND)), NOW);
    schedule.push(job(4, 4, 0, None), NOW);
    assert_eq!(schedule.next_deadline_ns(), Some(NOW));
    let expired = schedule.take_expired(NOW);
    assert_eq!(
        expired
            .iter()
            .map(|job| job.id)
            .collect::<Vec<_>>(),
        [2]
    );
    assert_eq!(schedule.remove(3, NOW).map(|job| job.id), Some(3));
    assert!(schedule.remove(3, NOW).is_none());
    assert_eq!(schedule.take_all(NOW).len(), 1);
    assert!(
        schedule
            .clients
            .iter()
            .all(|(client, share)| share.jobs == usize::from(*client == 1))
    );
}

#[test]
fn what_a_client_has_had_is_forgotten_in_time() {
    let mut schedule = busy();
    let used_ns = 8 * order::SHARE_NS;
    schedule.charge(1, NOW + used_ns);
    schedule.enter(2, NOW + used_ns);
    assert_eq!(
        (schedule.clients[&1].used_ns, schedule.clients[&2].used_ns),
        (used_ns, 0)
    );
    schedule.forget(NOW + used_ns + 3 * HALF_LIFE_NS as u64);
    assert_eq!(schedule.clients[&1].used_ns, order::SHARE_NS);
    schedule.leave(2);
    schedule.forget(NOW + used_ns + 60 * HALF_LIFE_NS as u64);
    assert_eq!(
        schedule.clients.len(),
        1,
        "who is away and has nothing is not remembered"
    );
}

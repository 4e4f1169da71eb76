use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc;

use taut::optimize::Settings;
use taut::path::Path;
use taut::robot::{RobotDescription, RobotModel};
use taut::scene::Scene;
use taut::store::{PreparedModel, Snapshot};

use super::*;

const MILLISECOND: u64 = 1_000_000;

fn job(id: u64, client: u128, priority: u32, deadline_ns: Option<u64>) -> Job {
    let links = vec![taut::robot::LinkDescription {
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
        client,
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
        deadline_ns,
        received_ns: 0,
        priority,
        stop: Arc::default(),
        asked: Default::default(),
    }
}

/// A schedule of one slot with a thread that computes a job of client 1, and others that wait.
fn busy(others: usize) -> (Arc<Schedule>, Turn) {
    let schedule = Arc::new(Schedule::new(1));
    schedule.push(job(1, 1, 0, None));
    let (taken, turn) = schedule.take(0).unwrap();
    assert_eq!(taken.id, 1);
    for thread in 1..=others {
        let schedule = Arc::clone(&schedule);
        std::thread::spawn(move || {
            while let Some((_, mut turn)) = schedule.take(thread) {
                schedule.finish(&mut turn);
            }
        });
    }
    while schedule.lock().idle.len() < others {
        std::thread::yield_now();
    }
    (schedule, turn)
}

#[test]
fn nobody_makes_room_for_nobody() {
    let (schedule, mut turn) = busy(1);
    let now_ns = turn.since_ns + 1000 * MILLISECOND;
    schedule.make_room(&mut turn, now_ns, || false);
    assert_eq!((turn.pauses, turn.computed_ns), (0, 0));
}

#[test]
fn a_long_job_makes_room_for_anothers_short_one_and_goes_on() {
    let (schedule, mut turn) = busy(1);
    schedule.push(job(2, 2, 0, None));
    let early_ns = turn.since_ns + LOOK_NS / 2;
    schedule.make_room(&mut turn, early_ns, || false);
    assert_eq!(turn.pauses, 0, "not before a look is due");
    let late_ns = turn.since_ns + order::SHARE_NS + 2 * MILLISECOND;
    schedule.make_room(&mut turn, late_ns, || false);
    assert_eq!(
        (turn.pauses, schedule.waiting()),
        (1, 0),
        "the other one is done"
    );
    assert!(turn.has_slot && turn.computed_ns > order::SHARE_NS);
    schedule.finish(&mut turn);
    assert_eq!(schedule.lock().free_slots, 1);
}

#[test]
fn a_higher_class_goes_first_at_once() {
    let (schedule, mut turn) = busy(1);
    schedule.push(job(2, 1, 1, None));
    let now_ns = turn.since_ns + 1;
    schedule.make_room(&mut turn, now_ns, || false);
    assert_eq!((turn.pauses, schedule.waiting()), (1, 0));
}

#[test]
fn a_job_that_is_over_ends_without_a_slot() {
    let (schedule, mut turn) = busy(0);
    schedule.push(job(2, 2, 1, None));
    let (sender, receiver) = mpsc::channel();
    let is_over = Arc::new(AtomicBool::new(false));
    // Takes the slot and keeps it.
    let holder = {
        let schedule = Arc::clone(&schedule);
        std::thread::spawn(move || {
            sender
                .send(schedule.take(1).unwrap().1)
                .unwrap()
        })
    };
    while schedule.lock().idle.is_empty() {
        std::thread::yield_now();
    }
    schedule.look_again();
    let paused = {
        let schedule = Arc::clone(&schedule);
        let is_over = Arc::clone(&is_over);
        std::thread::spawn(move || {
            let now_ns = turn.since_ns + 1;
            schedule.make_room(&mut turn, now_ns, || is_over.load(Ordering::Relaxed));
            turn
        })
    };
    let mut second = receiver.recv().unwrap();
    holder.join().unwrap();
    is_over.store(true, Ordering::Relaxed);
    schedule.wake(1);
    let mut first = paused.join().unwrap();
    assert!(!first.has_slot, "the slot is the other's");
    schedule.finish(&mut first);
    assert_eq!(schedule.lock().free_slots, 0);
    schedule.finish(&mut second);
    assert_eq!(schedule.lock().free_slots, 1);
}

#[test]
fn what_is_taken_out_leaves_nothing_behind() {
    let (schedule, _turn) = busy(0);
    let now_ns = monotonic_ns();
    schedule.push(job(2, 2, 0, Some(now_ns)));
    schedule.push(job(3, 3, 0, Some(now_ns + 1000 * MILLISECOND)));
    schedule.push(job(4, 4, 0, None));
    assert_eq!(schedule.next_deadline_ns(), Some(now_ns));
    assert_eq!(
        schedule
            .take_expired(now_ns)
            .iter()
            .map(|job| job.id)
            .collect::<Vec<_>>(),
        [2]
    );
    assert_eq!(schedule.remove(3).map(|job| job.id), Some(3));
    assert!(schedule.remove(3).is_none());
    assert_eq!(schedule.take_all().len(), 1);
    assert!(
        schedule
            .lock()
            .clients
            .iter()
            .all(|(client, share)| share.jobs == usize::from(*client == 1))
    );
}

#[test]
fn what_a_client_has_had_is_forgotten_in_time() {
    let (schedule, mut turn) = busy(0);
    let mut state = schedule.lock();
    let begun_ns = turn.since_ns;
    let used_ns = 8 * order::SHARE_NS;
    state.charge(&mut turn, begun_ns + used_ns);
    state.enter(2, begun_ns + used_ns);
    assert_eq!(
        (state.clients[&1].used_ns, state.clients[&2].used_ns),
        (used_ns, 0)
    );
    state.forget(begun_ns + used_ns + 3 * HALF_LIFE_NS as u64);
    assert_eq!(state.clients[&1].used_ns, order::SHARE_NS);
    state.leave(2);
    state.forget(begun_ns + used_ns + 60 * HALF_LIFE_NS as u64);
    assert_eq!(
        state.clients.len(),
        1,
        "who is away and has nothing is not remembered"
    );
}

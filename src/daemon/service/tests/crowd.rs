//! A thousand clients at once: what is promised of every daemon, in simulated time.

use std::collections::{BTreeMap, BTreeSet};

use fastrand::Rng;
use taut_ipc::wire::{Code, Mode, RequestFlags, RequestHeader};

use super::changes::change;
use super::world::{MS, World};
use crate::daemon::config::{Config, Quota};
use crate::daemon::service::event::{Event, Ticket};

const CLIENTS: u128 = 1000;
const WORKERS: usize = 4;
/// When (ns) a client that is refused sends again.
const RETRY_NS: u64 = 100 * MS;

fn config() -> Config {
    Config {
        workers: WORKERS,
        queue: 2 * CLIENTS as usize,
        ..Config::default()
    }
}

/// Clients that send their next request when the one before is answered.
struct Crowd {
    world: World,
    rng: Rng,
    /// Who waits for what, and since when (ns).
    open: BTreeMap<Ticket, (u128, u64)>,
    /// Who sends the next when (ns).
    again: BTreeSet<(u64, u128)>,
    /// What came of it, in order: request, code, time that it took (ns).
    ended: Vec<(Ticket, u128, i32, u64)>,
    /// How long (ns) a request of a client is computed.
    cost_ns: fn(u128, &mut Rng) -> u64,
    /// How long (ns) a client gives the daemon; 0 = for ever.
    patience_ns: fn(u128, &mut Rng) -> u64,
}

impl Crowd {
    fn new(config: &Config) -> Self {
        Self {
            world: World::new(config),
            rng: Rng::with_seed(14),
            open: BTreeMap::new(),
            again: BTreeSet::new(),
            ended: Vec::new(),
            cost_ns: |_, _| MS,
            patience_ns: |_, _| 0,
        }
    }

    fn ask(&mut self, client: u128) {
        let cost_ns = (self.cost_ns)(client, &mut self.rng);
        let deadline_ns = match (self.patience_ns)(client, &mut self.rng) {
            0 => 0,
            patience_ns => self.world.now_ns + patience_ns,
        };
        let header = RequestHeader {
            deadline_ns,
            ..self.world.header()
        };
        let since_ns = self.world.now_ns;
        let ticket = self
            .world
            .ask_that_costs(client, header, cost_ns);
        self.open.insert(ticket, (client, since_ns));
    }

    /// Time passes; clients whose requests have ended send the next.
    fn pass(&mut self, time_ns: u64) {
        let end_ns = self.world.now_ns + time_ns;
        while self.world.now_ns < end_ns {
            self.world.pass(MS);
            self.take_ended();
            while let Some(client) = self.next() {
                self.ask(client);
            }
        }
    }

    /// Who sends now.
    fn next(&mut self) -> Option<u128> {
        let (at_ns, _) = self.again.first()?;
        let is_due = *at_ns <= self.world.now_ns;
        let next = is_due.then(|| self.again.pop_first());
        next.flatten().map(|(_, client)| client)
    }

    fn take_ended(&mut self) {
        let world = &self.world;
        let ended = self
            .open
            .extract_if(.., |ticket, _| world.of(*ticket).last.is_some());
        let ended: Vec<_> = ended.collect();
        for (ticket, (client, since_ns)) in &ended {
            let (code, at_ns) = self.world.of(*ticket).last.unwrap();
            self.ended
                .push((*ticket, *client, code, at_ns - since_ns));
            let is_refused = code == i32::from(Code::Overloaded);
            let pause_ns = if is_refused { RETRY_NS } else { 0 };
            self.again.insert((at_ns + pause_ns, *client));
        }
    }

    /// How long requests of these clients took (ns), the shortest first.
    fn latencies(&self, is_meant: impl Fn(u128) -> bool) -> Vec<u64> {
        let ended = self.ended.iter();
        let mut latencies: Vec<u64> = ended
            .filter(|(_, client, ..)| is_meant(*client))
            .map(|(.., latency_ns)| *latency_ns)
            .collect();
        latencies.sort_unstable();
        latencies
    }
}

fn p99(latencies: &[u64]) -> u64 {
    latencies[latencies.len() * 99 / 100]
}

#[test]
fn no_slot_is_idle_and_all_get_the_same() {
    let mut crowd = Crowd::new(&config());
    (0..CLIENTS).for_each(|client| crowd.ask(client));
    crowd.pass(1_000 * MS);
    let computed_ns = &crowd.world.computed_ns;
    let total_ns: u64 = computed_ns.values().sum();
    assert_eq!(crowd.world.most_at_once, WORKERS);
    assert_eq!(
        total_ns,
        1_000 * MS * WORKERS as u64,
        "somebody always waits"
    );
    let least = computed_ns.values().min().unwrap();
    let most = computed_ns.values().max().unwrap();
    assert!(
        computed_ns.len() == CLIENTS as usize && most - least <= 2 * MS,
        "{least} to {most} ns"
    );
}

#[test]
fn whoever_asks_for_much_does_not_slow_the_others() {
    let run = |greedy_asks: bool| {
        let mut crowd = Crowd::new(&config());
        crowd.cost_ns = |client, _| if client == 0 { 80 * MS } else { MS };
        (1..8).for_each(|client| crowd.ask(client));
        if greedy_asks {
            (0..4).for_each(|_| crowd.ask(0));
        }
        crowd.pass(2_000 * MS);
        (
            p99(&crowd.latencies(|client| client != 0)),
            crowd.world.most_at_once,
        )
    };
    let (alone, _) = run(false);
    let (beside, most_at_once) = run(true);
    assert!(beside <= 2 * alone, "p99 {beside} ns, alone {alone} ns");
    assert_eq!(most_at_once, WORKERS);
}

#[test]
fn nobody_is_answered_after_its_deadline_and_what_is_hopeless_at_once() {
    let mut crowd = Crowd::new(&config());
    crowd.cost_ns = |_, rng| rng.u64(MS..20 * MS);
    crowd.patience_ns = |_, rng| rng.u64(5 * MS..50 * MS);
    (0..CLIENTS).for_each(|client| crowd.ask(client));
    crowd.pass(1_000 * MS);
    let latest = crowd.latencies(|_| true).pop().unwrap();
    assert!(latest <= 50 * MS + MS / 2, "{latest} ns");
    let codes = crowd.ended.iter().map(|(_, _, code, _)| *code);
    let known = [Code::Success, Code::TimedOut, Code::Overloaded].map(i32::from);
    assert!(codes.clone().all(|code| known.contains(&code)));
    let served = codes
        .filter(|code| *code == i32::from(Code::Success))
        .count();
    // 4 workers for a second, jobs of 10.5 ms at the mean.
    assert!(served > 300, "{served} of those that could be");
}

#[test]
fn a_quota_holds_whoever_floods() {
    let quota = Quota {
        in_flight: 2,
        ..Quota::default()
    };
    let mut crowd = Crowd::new(&Config { quota, ..config() });
    (1..CLIENTS).for_each(|client| crowd.ask(client));
    let flood: Vec<_> = (0..100)
        .map(|_| {
            let header = crowd.world.header();
            crowd.world.ask(0, header)
        })
        .collect();
    let over = flood
        .iter()
        .filter(|ticket| crowd.world.of(**ticket).code() == Some(Code::Quota))
        .count();
    assert_eq!(over, 98);
    crowd.pass(600 * MS);
    let served = crowd.ended.len();
    assert!(served >= 2_000, "{served} of the others");
}

#[test]
fn each_of_a_thousand_watches_hears_each_change_once() {
    let mut world = World::new(&config());
    let header = RequestHeader {
        mode: Mode::Check.into(),
        flags: RequestFlags::WATCH,
        ..world.header()
    };
    let watches: Vec<_> = (0..CLIENTS)
        .map(|client| world.ask(client, header))
        .collect();
    world.pass(CLIENTS as u64 * MS / 3);
    for round in 1..=4 {
        world.proved = round % 2 == 0;
        if round % 2 == 1 {
            change(&mut world);
        } else {
            super::changes::undo(&mut world);
        }
        world.pass(CLIENTS as u64 * MS / 3);
        assert!(
            watches
                .iter()
                .all(|ticket| world.of(*ticket).told.len() == round + 1),
            "round {round}"
        );
    }
}

#[test]
fn every_request_has_an_end_when_the_daemon_ends_and_the_next_takes_them() {
    let mut crowd = Crowd::new(&config());
    crowd.cost_ns = |_, rng| rng.u64(MS..8 * MS);
    (0..CLIENTS).for_each(|client| crowd.ask(client));
    crowd.pass(200 * MS);
    crowd.world.happens(Event::Stop);
    crowd.world.pass(MS);
    crowd.take_ended();
    assert!(crowd.open.is_empty(), "{} wait for ever", crowd.open.len());
    assert!(crowd.world.service.is_done());
    crowd.world = World::new(&config());
    (0..CLIENTS).for_each(|client| crowd.ask(client));
    crowd.pass(CLIENTS as u64 * 6 * MS / WORKERS as u64);
    let heard: BTreeSet<_> = crowd
        .ended
        .iter()
        .filter(|(_, _, code, _)| *code == i32::from(Code::Success))
        .map(|(_, client, ..)| *client)
        .collect();
    assert_eq!(heard.len(), CLIENTS as usize);
}

#[test]
fn clients_that_vanish_leave_nothing_behind() {
    let mut crowd = Crowd::new(&config());
    crowd.cost_ns = |_, rng| rng.u64(MS..40 * MS);
    (0..CLIENTS).for_each(|client| crowd.ask(client));
    for _ in 0..20 {
        crowd.pass(10 * MS);
        let tickets: Vec<_> = crowd.open.keys().copied().collect();
        for ticket in tickets {
            if crowd.rng.f64() < 0.2 {
                crowd.world.happens(Event::Gone(ticket));
                crowd.open.remove(&ticket);
            }
        }
    }
    let left: Vec<_> = crowd.open.keys().copied().collect();
    left.into_iter()
        .for_each(|ticket| crowd.world.happens(Event::Gone(ticket)));
    crowd.world.pass(50 * MS);
    crowd.world.happens(Event::Stop);
    assert!(crowd.world.service.is_done());
}

#[test]
fn the_same_events_have_the_same_effects() {
    let run = || {
        let mut crowd = Crowd::new(&config());
        crowd.cost_ns = |_, rng| rng.u64(MS..20 * MS);
        crowd.patience_ns = |_, rng| rng.u64(5 * MS..500 * MS);
        (0..CLIENTS).for_each(|client| crowd.ask(client));
        crowd.pass(200 * MS);
        crowd.ended
    };
    assert_eq!(run(), run());
}

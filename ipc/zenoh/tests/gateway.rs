//! A gateway, an attached instance and the transport on one machine, before a daemon that echoes.
#![allow(missing_docs)]

mod world;

use std::fs::File;
use taut_ipc::control::{ControlReply, ControlRequest};
use taut_ipc::planner::Carrier;
use taut_ipc::wire::{Code, EnvelopeKind, Mode, Status};
use taut_ipc::{Client, Instance};
use taut_zenoh::names::Wish;
use taut_zenoh::{Network, Zenoh, attach, doctor};
use world::common::{PATIENCE, Sandbox, request as local_request, until};
use world::{
    NAME, Until, World, answers, ask, attachment, free_port, gateway, line, listening, message,
    request, told,
};
use zenoh::Wait;
use zenoh::bytes::ZBytes;

/// An instance of this machine for the daemon of a world.
struct Attached {
    _thread: Until,
    near: Sandbox,
}

fn attached(world: &World) -> Attached {
    attached_to(world.network(), &[])
}

fn attached_to(network: Network, daemons: &[&str]) -> Attached {
    let near = Sandbox::new();
    let options = attach::Options {
        instance: near.instance.clone(),
        daemons: daemons
            .iter()
            .map(|name| (*name).to_owned())
            .collect(),
    };
    let thread = Until::stopped(move |stop| attach::attach(&network, &options, &stop).unwrap());
    let attached = Attached {
        _thread: thread,
        near,
    };
    until("the instance is there", || {
        Client::connect(&attached.near.instance).is_ok()
    });
    attached
}

/// Lengths and paths of all answers.
fn all(instance: &Instance, improvements: u64) -> Vec<(f64, Vec<f64>)> {
    let client = Client::connect(instance).unwrap();
    let mut builder = client.request(3, 4);
    builder.header.mode = Mode::Gradient.into();
    builder.header.work_budget = improvements;
    let mut loan = builder.loan().unwrap();
    loan.path_mut().fill(0.7);
    let mut pending = loan.send().unwrap();
    let mut all = Vec::new();
    while let Some(answer) = pending.next(PATIENCE).unwrap() {
        all.push((answer.header().length_after, answer.path().to_vec()));
    }
    all
}

fn running(instance: &Instance) -> impl FnMut() -> u32 {
    let client = Client::connect(instance).unwrap();
    let feed = client.status_feed().unwrap();
    let mut last = u32::MAX;
    move || {
        // Wakes the daemon, which tells then.
        drop(local_request(&client, Mode::Check, 1, 0.0).and_then(|loan| loan.send()));
        if let Some(status) = feed.latest().unwrap() {
            last = status.running;
        }
        last
    }
}

#[test]
fn answers_are_the_same_through_an_attached_instance() {
    let world = World::new();
    let attached = attached(&world);
    let far = all(&world.far.instance, 3);
    let near = all(&attached.near.instance, 3);
    assert_eq!(far.len(), 4);
    assert_eq!(near, far);
}

#[test]
fn the_transport_tells_of_all_answers() {
    let world = World::new();
    let zenoh = Zenoh::connect(&world.network()).unwrap();
    let mut gradient = request(Mode::Gradient, 5);
    gradient.0.work_budget = 2;
    let lengths = [1.0, 0.99, 0.5].map(|length| (Code::Success, length));
    assert_eq!(told(&zenoh, &gradient), lengths);
    let overloaded = told(&zenoh, &request(Mode::PartialShortcut, 6));
    assert_eq!(overloaded[0].0, Code::Overloaded);
}

#[test]
fn a_wish_for_the_best_and_a_cancellation_reach_the_daemon() {
    let world = World::new();
    let attached = attached(&world);
    let client = Client::connect(&attached.near.instance).unwrap();
    let mut running = running(&world.far.instance);
    let ask = || {
        let loan = local_request(&client, Mode::Hybrid, 4, 0.0).unwrap();
        loan.send().unwrap()
    };
    let pending = ask();
    until("it runs", || running() == 1);
    pending.finish_early();
    let best = pending.wait(PATIENCE).unwrap();
    assert_eq!(best.code(), Code::Success);
    let pending = ask();
    until("the second runs", || running() == 1);
    drop(pending);
    until("it is dropped", || running() == 0);
}

#[test]
fn a_request_outlives_its_daemon() {
    let mut first = World::called("a");
    let second = World::called("b");
    let endpoints = [&first.endpoint, &second.endpoint];
    let attached = attached_to(Network::to(&endpoints), &["a", "b"]);
    let client = Client::connect(&attached.near.instance).unwrap();
    let loan = local_request(&client, Mode::Hybrid, 4, 0.0).unwrap();
    let pending = loan.send().unwrap();
    let mut is_running = running(&first.far.instance);
    until("it runs", || is_running() == 1);
    drop(is_running);
    drop(first.echo.take());
    let mut is_running = running(&second.far.instance);
    until("it runs elsewhere", || is_running() == 1);
    pending.finish_early();
    let best = pending.wait(PATIENCE).unwrap();
    assert_eq!(best.code(), Code::Success);
}

#[test]
fn where_no_gateway_is_a_request_is_lost() {
    let near = World::new();
    let network = near.network();
    drop(near);
    let zenoh = Zenoh::connect(&network).unwrap();
    let told = told(&zenoh, &request(Mode::Check, 1));
    assert_eq!(
        told.iter()
            .map(|(code, _)| *code)
            .collect::<Vec<_>>(),
        [Code::DaemonLost]
    );
}

#[test]
fn a_request_that_comes_twice_runs_once_and_its_end_is_kept() {
    let world = World::new();
    let session = world.session();
    let mut running = running(&world.far.instance);
    let hybrid = message(&request(Mode::Hybrid, 9));
    let sender = || attachment(EnvelopeKind::Request, 1, 9);
    let _first = ask(&session, sender(), hybrid.clone());
    until("it runs", || running() == 1);
    let second = ask(&session, sender(), hybrid);
    let key = Wish::Finish.key(NAME, 1, 9);
    // The second may not have arrived: say it until it has.
    let finished = std::thread::spawn(move || answers(&second));
    until("the second ends", || {
        session.put(&key, ZBytes::new()).wait().unwrap();
        finished.is_finished()
    });
    let last = Some((Code::Success, Status::Final));
    assert_eq!(finished.join().unwrap(), [last]);
    assert_eq!(running(), 0);
    for (request, known) in [(9, last), (10, None)] {
        let again = attachment(EnvelopeKind::Again, 1, request);
        let again = ask(&session, again, ZBytes::new());
        assert_eq!(answers(&again), [known], "{request}");
    }
}

#[test]
fn a_refusal_is_not_the_answer_to_a_request_that_comes_again() {
    let world = World::new();
    let session = world.session();
    let refused = message(&request(Mode::PartialShortcut, 11));
    let sender = attachment(EnvelopeKind::Request, 1, 11);
    let replies = ask(&session, sender, refused);
    assert_eq!(answers(&replies), [Some((Code::Overloaded, Status::Final))]);
    let again = attachment(EnvelopeKind::Again, 1, 11);
    let again = ask(&session, again, ZBytes::new());
    assert_eq!(answers(&again), [None]);
}

#[test]
fn counts_of_both_sides_are_among_the_daemons() {
    let world = World::new();
    let zenoh = Zenoh::connect(&world.network()).unwrap();
    for id in 1..4 {
        told(&zenoh, &request(Mode::Check, id));
    }
    let ControlReply::Stats(stats) = zenoh.control(ControlRequest::Stats) else {
        panic!("no counts");
    };
    assert_eq!(stats.numbers["gateway_requests"], 3.0);
    assert_eq!(stats.numbers["gateway_finished"], 3.0);
    for name in [
        "gateway_begun_again",
        "network_sent_again",
        "network_answered_twice",
    ] {
        assert_eq!(stats.numbers[name], 0.0, "{name}");
    }
}

/// An instance whose daemon speaks another version: what its lock file says is all that others see.
fn of_version(instance: &Instance, version: u32) -> File {
    instance.prepare().unwrap();
    let path = instance.root().join("daemon.lock");
    let text = format!("1 {:016x} {:016x} {version}\n", 1, 1);
    std::fs::write(&path, text).unwrap();
    let file = File::open(path).unwrap();
    file.lock().unwrap();
    file
}

#[test]
fn a_daemon_of_another_version_is_named_to_whoever_asks() {
    let far = Sandbox::new();
    let _daemon = of_version(&far.instance, 9);
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let _gateway = gateway(NAME, listening(&endpoint), &far.instance);
    let network = Network::to(&[&endpoint]);
    let named = "cell is there and cannot be used: wire version 9";
    let report = doctor::doctor(&network).unwrap();
    assert!(!report.is_healthy);
    let lines = report.lines.join("\n");
    assert!(
        lines.contains("FAIL  cell: its daemon cannot be used: wire version 9"),
        "{lines}"
    );
    let zenoh = Zenoh::connect(&network).unwrap();
    let check = request(Mode::Check, 1);
    let said = line(&zenoh, &check);
    assert!(said.contains(named), "{said}");
    let ControlReply::Refused(refusal) = zenoh.control(ControlRequest::List) else {
        panic!("a daemon of another version answers");
    };
    assert!(refusal.message.contains(named), "{}", refusal.message);
    let codes = told(&zenoh, &check);
    assert_eq!(codes[0].0, Code::DaemonLost);
}

#[test]
fn what_a_client_left_behind_is_dropped() {
    let world = World::new();
    let mut running = running(&world.far.instance);
    let session = world.session();
    let token = session
        .liveliness()
        .declare_token(taut_zenoh::names::client_token(3))
        .wait()
        .unwrap();
    let sender = attachment(EnvelopeKind::Request, 3, 1);
    let _answers = ask(&session, sender, message(&request(Mode::Hybrid, 1)));
    until("it runs", || running() == 1);
    drop(token);
    until("it is dropped", || running() == 0);
}

#[test]
fn other_versions_are_refused_by_name() {
    let world = World::new();
    let session = world.session();
    let mut sender = attachment(EnvelopeKind::Request, 1, 1)
        .to_bytes()
        .to_vec();
    sender[0] = 7;
    let replies = ask(&session, sender.into(), message(&request(Mode::Check, 1)));
    let reply = replies.recv().unwrap();
    let bytes = reply.result().unwrap().payload().to_bytes();
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.contains("wire version 7"), "{text}");
}

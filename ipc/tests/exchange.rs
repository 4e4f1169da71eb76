//! Requests, streams and control messages between processes that live.

mod common;

use common::*;
use std::time::{Duration, Instant};
use taut_ipc::control::{ControlReply, ControlRequest, SceneText};
use taut_ipc::limits::{ACTIVE_REQUESTS_PER_CLIENT, CONTROL_REPLY_MAX};
use taut_ipc::server::{IncomingRequest, Server, ServerError};
use taut_ipc::wire::{Code, Mode, RequestBody, ResponseHeader};
use taut_ipc::{Client, ClientError, Instance};

#[test]
fn paths_of_all_sizes_come_back() {
    let sandbox = Sandbox::new();
    let _daemon = Echo::start(&sandbox.instance);
    let client = Client::connect(&sandbox.instance).unwrap();
    for waypoints in [1, 64, 1024, 16_384, 131_072] {
        let loan = request(&client, Mode::Check, waypoints, 3.0).unwrap();
        let response = loan.send().unwrap().wait(PATIENCE).unwrap();
        assert_eq!(response.code(), Code::Success);
        assert_eq!(response.path().len(), waypoints as usize * 8);
        assert!(
            (0..)
                .zip(response.path())
                .all(|(i, x)| *x == 3.0 + f64::from(i))
        );
    }
}

#[test]
fn optional_sections_arrive() {
    let sandbox = Sandbox::new();
    let server = Server::create(&sandbox.instance).unwrap();
    let client = Client::connect(&sandbox.instance).unwrap();
    let body = RequestBody {
        weights: &[2.0; 6],
        fixed_waypoints: &[1, 0, 1],
        group_mask: &[1; 7],
        held_values: &[0.5],
        constraints: "upright hand:x=0.1",
        timing: "acceleration=2/s",
    };
    let mut builder = client.request(3, 7).with_body(body);
    builder.header.request_id = 42;
    let _pending = builder.loan().unwrap().send().unwrap();
    let incoming = server.receive().unwrap().unwrap();
    let view = incoming.view().unwrap();
    assert_eq!(
        (view.weights, view.held_values),
        (&[2.0; 6][..], &[0.5][..])
    );
    assert_eq!(
        (view.fixed_waypoints, view.group_mask),
        (&[1, 0, 1][..], &[1; 7][..])
    );
    assert_eq!(
        (view.constraints, view.timing),
        ("upright hand:x=0.1", "acceleration=2/s")
    );
    assert_eq!((view.header.request_id, view.path.len()), (42, 21));
}

#[test]
fn a_slow_reader_gets_the_newest_and_the_final() {
    let sandbox = Sandbox::new();
    let _daemon = Echo::start(&sandbox.instance);
    let client = Client::connect(&sandbox.instance).unwrap();
    let mut builder = client.request(4, 8);
    builder.header.mode = Mode::Gradient.into();
    builder.header.work_budget = 20;
    let mut pending = builder.loan().unwrap().send().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    let mut seen = Vec::new();
    while let Some(response) = pending.next(PATIENCE).unwrap() {
        seen.push((response.header().seq, response.is_final()));
    }
    let kept: Vec<_> = (13..20)
        .map(|seq| (seq, false))
        .chain([(20, true)])
        .collect();
    assert_eq!(seen, kept, "the newest 8 of 21");
    assert!(
        pending.next(PATIENCE).unwrap().is_none(),
        "nothing follows the final one"
    );
}

#[test]
fn every_client_gets_its_own_answers() {
    let sandbox = Sandbox::new();
    let _daemon = Echo::start(&sandbox.instance);
    std::thread::scope(|scope| {
        for thread in 0..4 {
            let instance = &sandbox.instance;
            scope.spawn(move || {
                let client = Client::connect(instance).unwrap();
                for round in 0..100 {
                    let first = f64::from(thread * 1000 + round);
                    let pending = request(&client, Mode::Check, 4, first)
                        .unwrap()
                        .send()
                        .unwrap();
                    assert_eq!(pending.wait(PATIENCE).unwrap().path()[0], first);
                }
            });
        }
    });
}

#[test]
fn one_client_has_so_many_requests_in_flight_and_no_more() {
    let sandbox = Sandbox::new();
    let _daemon = Echo::start(&sandbox.instance);
    let client = Client::connect(&sandbox.instance).unwrap();
    let send = |first| request(&client, Mode::Hybrid, 4, first).and_then(|loan| loan.send());
    let one = send(1.0).unwrap();
    let two = send(2.0).unwrap();
    let _others: Vec<_> = (2..ACTIVE_REQUESTS_PER_CLIENT)
        .map(|_| send(3.0).unwrap())
        .collect();
    let error = send(4.0).unwrap_err();
    assert!(matches!(error, ClientError::TooManyRequests), "{error}");
    assert_eq!(error.code(), Code::Quota);
    std::thread::scope(|scope| {
        let waiting = scope.spawn(|| two.wait(Duration::from_millis(300)));
        let listing = client.control(&ControlRequest::List, PATIENCE);
        assert!(matches!(listing, Ok(ControlReply::Listing(_))));
        one.finish_early();
        assert_eq!(one.wait(PATIENCE).unwrap().path()[0], 1.0);
        assert!(
            matches!(waiting.join().unwrap(), Err(ClientError::Timeout(_))),
            "not the other's answer"
        );
    });
}

#[test]
fn finish_early_and_cancel_reach_the_daemon_at_once() {
    let sandbox = Sandbox::new();
    let _daemon = Echo::start(&sandbox.instance);
    let client = Client::connect(&sandbox.instance).unwrap();
    let feed = client.status_feed().unwrap();
    let send = || {
        request(&client, Mode::Hybrid, 4, 0.0)
            .unwrap()
            .send()
            .unwrap()
    };
    let start = Instant::now();
    let pending = send();
    pending.finish_early();
    assert_eq!(pending.wait(PATIENCE).unwrap().code(), Code::Success);
    assert!(
        start.elapsed() < Duration::from_millis(500),
        "{:?}",
        start.elapsed()
    );
    drop(send());
    let took = until("cancelled request is gone", || {
        feed.latest()
            .unwrap()
            .is_some_and(|status| status.running == 0)
    });
    assert!(took < Duration::from_millis(500), "{took:?}");
}

#[test]
fn a_refusal_and_a_dropped_request_end_the_stream() {
    let sandbox = Sandbox::new();
    let _daemon = Echo::start(&sandbox.instance);
    let client = Client::connect(&sandbox.instance).unwrap();
    let send = |mode| {
        request(&client, mode, 4, 0.0)
            .unwrap()
            .send()
            .unwrap()
    };
    let refused = send(Mode::PartialShortcut)
        .wait(PATIENCE)
        .unwrap();
    assert_eq!(
        (refused.code(), refused.header().retry_after_ms),
        (Code::Overloaded, 7)
    );
    assert_eq!(refused.message(), "queue full, 3 wait");
    let start = Instant::now();
    assert!(matches!(
        send(Mode::Contact).wait(PATIENCE),
        Err(ClientError::NoAnswer)
    ));
    assert!(
        start.elapsed() < Duration::from_millis(50),
        "woken, not timed out: {:?}",
        start.elapsed()
    );
}

#[test]
fn malformed_requests_are_refused_and_the_next_is_served() {
    let sandbox = Sandbox::new();
    let _daemon = Echo::start(&sandbox.instance);
    let client = Client::connect(&sandbox.instance).unwrap();
    let mut builder = client.request(4, 8);
    builder.header.mode = 99;
    let response = builder
        .loan()
        .unwrap()
        .send()
        .unwrap()
        .wait(PATIENCE)
        .unwrap();
    assert_eq!(response.code(), Code::MalformedRequest);
    assert!(
        response.message().contains("mode"),
        "{}",
        response.message()
    );
    assert!(matches!(
        client.request(0, 8).loan(),
        Err(ClientError::Wire(_))
    ));
    let fine = request(&client, Mode::Check, 4, 0.0)
        .unwrap()
        .send()
        .unwrap();
    assert_eq!(fine.wait(PATIENCE).unwrap().code(), Code::Success);
}

#[test]
fn control_answers_and_times_out() {
    let sandbox = Sandbox::new();
    let daemon = Echo::start(&sandbox.instance);
    let client = Client::connect(&sandbox.instance).unwrap();
    let large = ControlRequest::LoadScene {
        label: "kitchen".into(),
        json: "x".repeat(3 << 20),
        base_dir: None,
        replace: false,
        files: None,
        version: None,
    };
    for message in [ControlRequest::List, large, ControlRequest::List] {
        let reply = client.control(&message, PATIENCE).unwrap();
        let refused =
            matches!(&reply, ControlReply::Refused(r) if r.code == i32::from(Code::UnknownRobot));
        assert_eq!(refused, message != ControlRequest::List);
    }
    drop(daemon);
    let error = client
        .control(&ControlRequest::List, SECOND)
        .unwrap_err();
    assert_eq!(error.code(), Code::DaemonLost, "{error}");
    let _silent = Server::create(&sandbox.instance).unwrap();
    let error = client
        .control(&ControlRequest::List, Duration::from_millis(150))
        .unwrap_err();
    assert!(matches!(error, ClientError::Timeout(_)), "{error}");
}

#[test]
fn a_reply_that_is_too_large_becomes_a_refusal() {
    let sandbox = Sandbox::new();
    let server = Server::create(&sandbox.instance).unwrap();
    let client = Client::connect(&sandbox.instance).unwrap();
    std::thread::scope(|scope| {
        let asking = scope.spawn(|| {
            client
                .control(&ControlRequest::List, PATIENCE)
                .unwrap()
        });
        let mut received = None;
        until("the message is there", || {
            received = server.receive_control().unwrap();
            received.is_some()
        });
        let text = SceneText {
            json: "x".repeat(CONTROL_REPLY_MAX),
            ..SceneText::default()
        };
        received
            .unwrap()
            .reply(&ControlReply::SceneText(text))
            .unwrap();
        let reply = asking.join().unwrap();
        assert!(
            matches!(&reply, ControlReply::Refused(r) if r.code == i32::from(Code::ResourceExhausted)),
            "{reply:?}"
        );
    });
}

#[test]
fn cancelled_requests_still_held_block_only_their_client() {
    let sandbox = Sandbox::new();
    let server = Server::create(&sandbox.instance).unwrap();
    let a = Client::connect(&sandbox.instance).unwrap();
    let b = Client::connect(&sandbox.instance).unwrap();
    let send = |client, first| {
        request(client, Mode::Check, 4, first)
            .and_then(|loan| loan.send())
            .unwrap()
    };
    let first = |incoming: &IncomingRequest| incoming.view().unwrap().path[0];
    let cancelled: Vec<_> = (0..ACTIVE_REQUESTS_PER_CLIENT)
        .map(|_| send(&a, 1.0))
        .collect();
    let held: Vec<_> = std::iter::from_fn(|| server.receive().unwrap()).collect();
    assert_eq!(held.len(), ACTIVE_REQUESTS_PER_CLIENT);
    drop(cancelled);
    assert!(
        held.iter()
            .all(|incoming| !incoming.is_connected())
    );
    let _third = send(&a, 3.0);
    assert!(server.receive().unwrap().is_none());
    let _other = send(&b, 4.0);
    assert_eq!(server.receive().unwrap().as_ref().map(first), Some(4.0));
    drop(held);
    assert_eq!(server.receive().unwrap().as_ref().map(first), Some(3.0));
}

#[test]
fn whoever_lets_a_request_go_wakes_the_daemon_for_the_next() {
    let sandbox = Sandbox::new();
    let server = Server::create(&sandbox.instance).unwrap();
    let client = Client::connect(&sandbox.instance).unwrap();
    let send = || {
        let loan = request(&client, Mode::Check, 1, 1.0).unwrap();
        loan.send().unwrap()
    };
    let cancelled: Vec<_> = (0..ACTIVE_REQUESTS_PER_CLIENT)
        .map(|_| send())
        .collect();
    let mut held: Vec<IncomingRequest> = std::iter::from_fn(|| server.receive().unwrap()).collect();
    drop(cancelled);
    let _pending = send();
    assert!(server.receive().unwrap().is_none(), "one more is held back");
    while server.wait(Duration::ZERO).unwrap() {}
    // As another thread would that answers it.
    drop(held.pop());
    assert!(server.wait(PATIENCE).unwrap(), "somebody calls");
    assert!(server.receive().unwrap().is_some());
}

#[test]
fn a_daemon_that_takes_nothing_overloads_the_client_instead_of_hanging_it() {
    let sandbox = Sandbox::new();
    let server = Server::create(&sandbox.instance).unwrap();
    let client = Client::connect(&sandbox.instance).unwrap();
    let send = || request(&client, Mode::Check, 4, 0.0).and_then(|loan| loan.send());
    (0..ACTIVE_REQUESTS_PER_CLIENT).for_each(|_| drop(send().unwrap()));
    let error = send().unwrap_err();
    assert_eq!(error.code(), Code::Overloaded, "{error}");
    assert!(server.receive().unwrap().is_none(), "their client is gone");
    let _pending = send().unwrap();
    assert!(server.receive().unwrap().is_some());
}

#[test]
fn a_second_daemon_and_a_client_without_a_daemon_are_told_so() {
    let sandbox = Sandbox::new();
    let error = Client::connect(&sandbox.instance).unwrap_err();
    assert_eq!(error.code(), Code::DaemonLost, "{error}");
    let first = Server::create(&sandbox.instance).unwrap();
    let error = Server::create(&sandbox.instance).unwrap_err();
    assert!(
        matches!(error, ServerError::AlreadyRunning { .. }),
        "{error}"
    );
    drop(first);
    assert!(Client::connect(&sandbox.instance).is_err());
    Server::create(&sandbox.instance).unwrap();
}

#[test]
fn a_wake_before_the_wait_is_not_lost() {
    let sandbox = Sandbox::new();
    let server = Server::create(&sandbox.instance).unwrap();
    assert!(!server.wait(Duration::ZERO).unwrap());
    let waker = server.waker();
    std::thread::spawn(move || (0..100).for_each(|_| waker.wake()))
        .join()
        .unwrap();
    assert!(server.wait(PATIENCE).unwrap());
    assert!(
        !server.wait(Duration::from_millis(20)).unwrap(),
        "one wait takes all wakes"
    );
}

#[test]
fn names_and_roots_are_checked() {
    for name in ["", "UPPER", "a b", "a.b", "x".repeat(25).as_str()] {
        assert!(Instance::new(name, "/tmp/x").is_err(), "{name}");
    }
    assert!(Instance::new("main", "relative").is_err());
    let long = format!("/tmp/{}", "y".repeat(60));
    let error = Instance::new("main", long).unwrap_err();
    assert!(error.to_string().contains("42 fit"), "{error}");
    let one = Instance::new("main", "/tmp/a").unwrap();
    let two = Instance::new("main", "/tmp/b").unwrap();
    assert_ne!(one.prefix(), two.prefix());
}

#[test]
fn everything_is_private_to_the_user() {
    use std::os::unix::fs::PermissionsExt;
    let sandbox = Sandbox::new();
    let _daemon = Echo::start(&sandbox.instance);
    let _client = Client::connect(&sandbox.instance).unwrap();
    let mode = |path: &std::path::Path| {
        std::fs::metadata(path)
            .unwrap()
            .permissions()
            .mode()
            & 0o777
    };
    assert_eq!(mode(sandbox.instance.root()), 0o700);
    for file in taut_ipc::memory::shared_files(&sandbox.instance) {
        assert_eq!(mode(&file.path) & 0o077, 0, "{}", file.path.display());
    }
}

/// A gateway: what comes to one instance goes on to another as it is, and the answers back.
#[test]
fn what_is_relayed_stays_as_it_is() {
    let near = Sandbox::new();
    let far = Sandbox::new();
    let gateway = Server::create(&near.instance).unwrap();
    let _daemon = Echo::start(&far.instance);
    let planner = Client::connect(&near.instance).unwrap();
    let onward = Client::connect(&far.instance).unwrap();
    let relay = onward.relay().unwrap();
    let mut builder = planner.request(4, 8);
    builder.header.mode = Mode::Gradient.into();
    builder.header.work_budget = 3;
    builder.header.request_id = 77;
    let mut loan = builder.loan().unwrap();
    loan.path_mut().fill(0.25);
    let mut pending = loan.send().unwrap();
    let mut incoming = gateway.receive().unwrap().unwrap();
    let payload = incoming.payload();
    let fill = |place: &mut [u8]| place.copy_from_slice(payload);
    let mut relayed = relay
        .send(*incoming.header(), payload.len(), fill)
        .unwrap();
    let mut sent = Vec::new();
    let mut is_final = false;
    until("the final answer is relayed", || {
        relay.wait(PATIENCE).unwrap();
        while let Some(response) = relayed.try_next().unwrap() {
            let payload = response.payload();
            let fill = |place: &mut [u8]| place.copy_from_slice(payload);
            incoming
                .relay(response.header(), payload.len(), fill)
                .unwrap();
            sent.push((*response.header(), response.path().to_vec()));
            is_final |= response.is_final();
        }
        is_final
    });
    let mut received: Vec<(ResponseHeader, Vec<f64>)> = Vec::new();
    while let Some(response) = pending.next(PATIENCE).unwrap() {
        received.push((*response.header(), response.path().to_vec()));
    }
    assert_eq!(received, sent);
    assert_eq!((received.len(), received[3].0.request_id), (4, 77));
    assert!(received[3].1.iter().all(|x| *x == 0.125));
    // What is too large, or no message, is refused here already.
    for bytes in [taut_ipc::limits::MAX_PAYLOAD + 1, 8] {
        let again = relay.send(*incoming.header(), bytes, |_| ());
        assert!(again.is_err());
        let answer = incoming.relay(&received[3].0, bytes, |_| ());
        assert!(answer.is_err());
    }
}

#[test]
fn both_ports_of_a_client_are_one_connection() {
    let sandbox = Sandbox::new();
    let server = Server::create(&sandbox.instance).unwrap();
    let clients = [0; 2].map(|_| Client::connect(&sandbox.instance).unwrap());
    let connections = clients.map(|client| {
        let _pending = request(&client, Mode::Check, 1, 0.0)
            .unwrap()
            .send()
            .unwrap();
        let asked = server.receive().unwrap().unwrap();
        let by_request = server.peer(asked.client_id()).unwrap();
        assert_eq!(by_request.pid, std::process::id());
        std::thread::scope(|scope| {
            scope.spawn(|| {
                client
                    .control(&ControlRequest::List, PATIENCE)
                    .unwrap()
            });
            let mut control = None;
            until("a control message is there", || {
                control = server.receive_control().unwrap();
                control.is_some()
            });
            let control = control.unwrap();
            assert_ne!(control.client_id(), asked.client_id());
            assert_eq!(server.peer(control.client_id()), Some(by_request));
            control.reply(&ControlReply::Done).unwrap();
        });
        by_request.connection
    });
    assert_ne!(connections[0], connections[1]);
    assert_eq!(server.peer(1), None);
}

#[test]
fn requests_come_before_a_control_message_sent_after_them() {
    let sandbox = Sandbox::new();
    let server = Server::create(&sandbox.instance).unwrap();
    let client = Client::connect(&sandbox.instance).unwrap();
    let loan = request(&client, Mode::Check, 64, 0.0).unwrap();
    let pending = loan.send().unwrap();
    let asked = std::thread::spawn({
        let client = client.clone();
        move || client.control(&ControlRequest::List, PATIENCE)
    });
    let mut control = None;
    until("the control message is there", || {
        control = server.receive_control().unwrap();
        control.is_some()
    });
    // Received, though nobody has asked for it: the server does not sleep on it.
    assert!(server.wait(PATIENCE).unwrap());
    let request = server.receive().unwrap().unwrap();
    assert_eq!(request.header().request_id, pending.request_id());
    answer_control(control.unwrap());
    asked.join().unwrap().unwrap();
}

//! Many clients, few workers: nobody's long, many or wrong requests are felt by others.

mod common;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;
use std::thread::ScopedJoinHandle;

use common::*;
use taut_ipc::Client;
use taut_ipc::client::Pending;
use taut_ipc::control::{ControlReply, ControlRequest, Story};
use taut_ipc::wire::{Code, Mode, RequestBody, RequestHeader, Termination};

fn number(client: &Client, name: &str) -> f64 {
    stats(client).numbers[name]
}

fn send(arm: &Models, client: &Client, edit: impl FnOnce(&mut RequestHeader)) -> Pending {
    arm.request(client, RequestBody::default(), edit)
        .send()
        .unwrap()
}

/// A request that comes to its end without a deadline, with its answer's path.
fn answer(arm: &Models, client: &Client) -> Vec<f64> {
    let response = send(arm, client, |header| header.mode = Mode::Hybrid.into())
        .wait(PATIENCE)
        .unwrap();
    assert_eq!(response.code(), Code::Success);
    assert_eq!(
        response.header().termination,
        u32::from(Termination::Converged)
    );
    response.path().to_vec()
}

fn story(client: &Client, request_id: u64) -> Story {
    let message = ControlRequest::Stories {
        id: format!("{request_id:016x}"),
    };
    match client.control(&message, PATIENCE).unwrap() {
        ControlReply::Stories(mut stories) => stories.swap_remove(0),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_long_job_makes_room_and_every_answer_is_the_same() {
    let place = Place::new();
    let _daemon = place.serve("workers = 1");
    let greedy = place.client();
    let client = place.client();
    let arm = Models::of(&client, "arm_shelf");
    let alone = answer(&arm, &client);
    let mut long = send(&arm, &greedy, patient);
    assert!(!long.next(PATIENCE).unwrap().unwrap().is_final());
    for _ in 0..3 {
        assert_eq!(
            answer(&arm, &client),
            alone,
            "computed in turns with the long one, and the same"
        );
    }
    long.finish_early();
    let best = long.wait(PATIENCE).unwrap();
    assert_eq!(best.code(), Code::Success);
    let story = story(&client, best.header().request_id);
    assert!(
        story
            .events
            .iter()
            .any(|event| event.what.contains("made room")),
        "{story:?}"
    );
    assert!(number(&client, "job_pauses") >= 3.0);
}

#[test]
fn a_paused_job_ends_when_its_client_says_so() {
    let place = Place::new();
    let _daemon = place.serve("workers = 1");
    let greedy = place.client();
    let client = place.client();
    let arm = Models::of(&client, "arm_shelf");
    let mut paused = send(&arm, &greedy, patient);
    // It has something to show: asked to end before its input is proved, it would be PREEMPTED.
    assert!(
        !paused
            .next(PATIENCE)
            .unwrap()
            .unwrap()
            .is_final()
    );
    // Of a higher class: the first one gets no slot while this one runs.
    let running = send(&arm, &client, endless);
    until("it has made room", || {
        number(&client, "requests_running") == 2.0
    });
    paused.finish_early();
    let best = paused.wait(PATIENCE).unwrap();
    assert_eq!(best.code(), Code::Success, "{}", best.message());
    assert_eq!(
        best.header().termination,
        u32::from(Termination::FinishedEarly)
    );
    let dropped = send(&arm, &greedy, patient);
    until("it waits", || number(&client, "requests_queued") == 1.0);
    drop(dropped);
    until("it is gone", || number(&client, "requests_queued") == 0.0);
    drop(running);
}

#[test]
fn quotas_hold_for_each_client_alone() {
    let place = Place::new();
    let _daemon = place.serve("workers = 1\nquota = { in_flight = 1, cpu_share = 0.5 }");
    let greedy = place.client();
    let client = place.client();
    let arm = Models::of(&client, "arm_shelf");
    let running = send(&arm, &greedy, patient);
    let refused = send(&arm, &greedy, |_| ())
        .wait(PATIENCE)
        .unwrap();
    assert_eq!(refused.code(), Code::Quota);
    assert!(
        refused.header().retry_after_ms > 0 && refused.message().contains("in flight"),
        "{}",
        refused.message()
    );
    answer(&arm, &client);
    // A whole worker until more is used up than half of one and the burst.
    std::thread::sleep(std::time::Duration::from_millis(1500));
    running.finish_early();
    running.wait(PATIENCE).unwrap();
    let refused = send(&arm, &greedy, |_| ())
        .wait(PATIENCE)
        .unwrap();
    assert_eq!(refused.code(), Code::Quota, "{}", refused.message());
    assert!(refused.message().contains("50 %"), "{}", refused.message());
    std::thread::sleep(std::time::Duration::from_millis(
        refused.header().retry_after_ms.into(),
    ));
    answer(&arm, &greedy);
}

#[test]
fn what_crashed_twice_is_not_tried_again() {
    let place = Place::new();
    let _daemon = place.serve("workers = 1");
    let client = place.client();
    let arm = Models::of(&client, "arm_shelf");
    let crash = || {
        send(&arm, &client, |header| header.seed = PANIC_SEED)
            .wait(PATIENCE)
            .unwrap()
    };
    for _ in 0..3 {
        assert_eq!(crash().code(), Code::Crash);
        answer(&arm, &client);
    }
    assert_eq!(
        number(&client, "worker_panics"),
        2.0,
        "the third was refused"
    );
    assert!(crash().message().contains("2 times"));
}

#[test]
fn top_and_why_tell_who_had_what() {
    let place = Place::new();
    let _daemon = place.serve("workers = 1");
    let client = place.client();
    let arm = Models::of(&client, "arm_shelf");
    let id = send(&arm, &client, |_| ())
        .wait(PATIENCE)
        .unwrap()
        .header()
        .request_id;
    let refused = send(&arm, &client, |header| header.scene_id = 7)
        .wait(PATIENCE)
        .unwrap();
    assert_eq!(refused.code(), Code::UnknownScene);

    let view = place
        .taut(&["top", "--once", "--format", "json"])
        .json();
    let own = &view["clients"][0];
    assert_eq!(
        (own["pid"].as_u64(), own["served"].as_u64()),
        (Some(std::process::id().into()), Some(1))
    );
    assert_eq!(
        (own["refused"].as_u64(), own["in_flight"].as_u64()),
        (Some(1), Some(0))
    );
    assert!(own["computed_ns"].as_u64() > Some(0) && own["latency_p99_ns"].as_u64() > Some(0));
    assert!(
        place
            .taut(&["top", "--once"])
            .out
            .contains("served 1   refused 1")
    );

    let told = place.taut(&["why", &format!("{id:x}")]);
    assert!(
        told.out.contains("SUCCESS") && told.out.contains("in arm_shelf v1"),
        "{}",
        told.out
    );
    let told = place.taut(&["why", &format!("{:016x}", refused.header().request_id)[8..]]);
    assert!(
        told.out.contains("UNKNOWN_SCENE") && told.out.contains("refused: no scene"),
        "{}",
        told.out
    );
    assert_eq!(place.taut(&["why"]).out.lines().count(), 2);
    let unknown = place.taut(&["why", "00000000000000ff"]);
    assert_eq!(unknown.exit, 65, "{}", unknown.err);
    assert_eq!(place.taut(&["why", "xyz"]).exit, 64);
}

#[test]
fn prometheus_reads_what_was_counted() {
    let place = Place::new();
    let _daemon = place.serve("metrics = '127.0.0.1:0'");
    let client = place.client();
    answer(&Models::of(&client, "arm_shelf"), &client);
    let address = place
        .said("metrics at http://")
        .trim_end_matches("/metrics")
        .to_owned();
    let page = |path: &str| {
        let mut stream = TcpStream::connect(&address).unwrap();
        write!(
            stream,
            "GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"
        )
        .unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        text
    };
    let text = page("/metrics");
    assert!(
        text.starts_with("HTTP/1.1 200") && text.contains("openmetrics-text"),
        "{text}"
    );
    assert!(
        text.contains("taut_requests_ended_total{code=\"SUCCESS\"} 1\n"),
        "{text}"
    );
    assert!(
        text.contains("taut_compute_seconds_count 1\n") && text.ends_with("# EOF\n"),
        "{text}"
    );
    assert!(page("/").starts_with("HTTP/1.1 404"));
}

/// The port gives requests by client: with one worker that is never idle, the last would wait for
/// ever if it were asked for one at a time.
#[test]
fn nobody_is_left_at_the_port() {
    const CLIENTS: usize = 8;
    const ANSWERS: usize = 400;
    let place = Place::new();
    let _daemon = place.serve("workers = 1");
    let first = place.client();
    let arm = Models::of(&first, "arm_shelf");
    let left = AtomicUsize::new(ANSWERS);
    // All of them before any begins: who connects while others are being served comes too late.
    let clients: Vec<Client> = (0..CLIENTS).map(|_| place.client()).collect();
    let served: Vec<usize> = std::thread::scope(|scope| {
        let clients: Vec<_> = clients
            .iter()
            .map(|client| scope.spawn(|| served_until(&arm, client, &left)))
            .collect();
        let join = |client: ScopedJoinHandle<usize>| client.join().unwrap();
        clients.into_iter().map(join).collect()
    });
    let least = served.iter().min().unwrap();
    assert!(*least >= ANSWERS / CLIENTS / 4, "{served:?}");
}

/// Sends one check after the other until there were enough; gives how many were its own.
fn served_until(arm: &Models, client: &Client, left: &AtomicUsize) -> usize {
    let mut served = 0;
    let one_less = |left: usize| left.checked_sub(1);
    while left
        .try_update(Relaxed, Relaxed, one_less)
        .is_ok()
    {
        let pending = send(arm, client, |header| header.mode = Mode::Check.into());
        assert_eq!(pending.wait(PATIENCE).unwrap().code(), Code::Success);
        served += 1;
    }
    served
}

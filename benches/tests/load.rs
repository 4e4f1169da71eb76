//! `taut-bench load`: every request comes to an end, and the report adds up.

mod common;

use common::{Place, Run, config};

fn load(place: &Place, arguments: &[&str]) -> serde_json::Value {
    let run = place.run(
        &[
            &["load", "--format", "json", "--duration", "500ms"],
            arguments,
        ]
        .concat(),
    );
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    run.json()
}

fn count(report: &serde_json::Value, name: &str) -> u64 {
    report[name]
        .as_u64()
        .unwrap_or_else(|| panic!("{name} of {report}"))
}

/// Served, refused by code, and nothing else.
fn adds_up(report: &serde_json::Value) {
    let refused: u64 = report["refused"]
        .as_object()
        .unwrap()
        .values()
        .map(|count| count.as_u64().unwrap())
        .sum();
    assert_eq!(
        count(report, "sent"),
        count(report, "served") + refused,
        "{report}"
    );
    assert_eq!(
        (
            count(report, "lost"),
            count(report, "unequal"),
            count(report, "other_scene")
        ),
        (0, 0, 0)
    );
}

#[test]
fn closed_loop_clients_are_all_served() {
    let place = Place::new();
    let report = load(
        &place,
        &["--spawn-daemon", "--clients", "3", "--workers", "2"],
    );
    adds_up(&report);
    assert!(
        count(&report, "served") > 0 && count(&report, "served") == count(&report, "sent"),
        "{report}"
    );
    for name in ["latency", "compute", "overhead"] {
        let [p50, p99, max] =
            ["p50_s", "p99_s", "max_s"].map(|name2| report[name][name2].as_f64().unwrap());
        assert!(0.0 < p50 && p50 <= p99 && p99 <= max, "{name}: {report}");
    }
    assert!(
        report["daemon_cpu_s"].as_f64() > Some(0.0) && count(&report, "client_private_bytes") > 0
    );
    assert!(report["lateness"].is_null());
}

#[test]
fn arrivals_beyond_saturation_are_refused_by_code() {
    let place = Place::new();
    let arguments = [
        "--spawn-daemon",
        "--clients",
        "2",
        "--workers",
        "1",
        "--rate",
        "20000",
        "--deadline",
        "20ms",
    ];
    let report = load(&place, &arguments);
    adds_up(&report);
    assert!(report["refused"]["QUOTA"].as_u64() > Some(0), "{report}");
    assert!(!report["lateness"].is_null());
}

#[test]
fn a_daemon_that_serves_already_is_used_and_stays() {
    let place = Place::new();
    let mut daemon = place.serve();
    let problem = config("problems/corner.json");
    let arguments = [
        "--clients",
        "1",
        "--problems",
        &problem,
        "--waypoints",
        "60",
        "--mode",
        "check",
    ];
    adds_up(&load(&place, &arguments));
    assert!(daemon.is_alive());
    drop(daemon);
    let run = place.run(&["load", "--duration", "100ms"]);
    assert_eq!((run.exit, run.err.lines().count()), (69, 1), "{}", run.err);
}

/// What a killed planner leaves in shared memory is wiped with the test's own daemon.
#[test]
fn a_table_for_people_and_nothing_left_behind() {
    let place = Place::new();
    let tmp = place.folder.path().join("tmp");
    std::fs::create_dir(&tmp).unwrap();
    let mut command = place.command(&[
        "load",
        "--spawn-daemon",
        "--clients",
        "2",
        "--duration",
        "300ms",
    ]);
    let run = Run::of(command.env("TMPDIR", &tmp).output().unwrap());
    assert_eq!(run.exit, 0, "{}", run.err);
    assert!(
        run.out.starts_with("2 clients") && run.out.contains("fairness  Jain"),
        "{}",
        run.out
    );
    assert_eq!(std::fs::read_dir(&tmp).unwrap().count(), 0);
}

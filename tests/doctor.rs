//! `taut doctor`: what is well, what is not, and what to do.
#![cfg(feature = "daemon")]

mod common;

use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;

use common::*;

/// Verdict and text of a check.
fn check(place: &Place, what: &str) -> (String, String, i32) {
    let run = place.taut(&["doctor", "--format", "json"]);
    let report = run.json();
    let checks = report["checks"].as_array().unwrap().iter();
    let found = checks
        .into_iter()
        .find(|check| check["what"] == what)
        .unwrap();
    let text = |key: &str| found[key].as_str().unwrap().to_owned();
    assert_eq!(
        run.exit,
        if report["healthy"] == true { 0 } else { 1 },
        "{}",
        run.out
    );
    (text("verdict"), text("seen"), run.exit)
}

#[test]
fn it_tells_a_daemon_that_is_well_from_what_is_left_of_one() {
    let place = Place::new();
    let (verdict, seen, exit) = check(&place, "daemon");
    assert_eq!((verdict.as_str(), exit), ("WARN", 0), "{seen}");
    assert!(seen.contains("taut serve"), "{seen}");
    let daemon = place.serve("");
    let pid = daemon.pid();
    let (verdict, seen, _) = check(&place, "daemon");
    assert_eq!(verdict, "OK", "{seen}");
    assert!(
        seen.contains(&format!("process {pid}")) && seen.contains("release"),
        "{seen}"
    );
    until("everything is kept", || {
        check(&place, "state")
            .1
            .contains("7 robots and 7 scenes")
    });
    let run = place.taut(&["doctor"]);
    assert_eq!((run.exit, run.out.lines().count()), (0, 9), "{}", run.out);
    daemon.kill();
    let (verdict, seen, _) = check(&place, "left behind");
    assert_eq!(verdict, "WARN", "{seen}");
    assert!(seen.contains("removes them"), "{seen}");
    let daemon = place.serve("");
    assert_eq!(place.taut(&["stop"]).exit, 0);
    assert_eq!(daemon.wait(), 0);
    assert_eq!(check(&place, "left behind").0, "OK");
}

#[test]
fn it_finds_a_damaged_journal_and_a_root_that_others_may_use() {
    let place = Place::new();
    let state = place.instance.root().join("state");
    fs::create_dir_all(&state).unwrap();
    fs::set_permissions(place.instance.root(), Permissions::from_mode(0o700)).unwrap();
    assert_eq!(check(&place, "instance").0, "OK");
    fs::write(state.join("journal"), "something else").unwrap();
    let (verdict, seen, exit) = check(&place, "state");
    assert_eq!((verdict.as_str(), exit), ("FAIL", 1), "{seen}");
    assert!(
        seen.contains("it is no journal") && seen.contains("--no-state"),
        "{seen}"
    );
    fs::set_permissions(place.instance.root(), Permissions::from_mode(0o755)).unwrap();
    let (verdict, seen, _) = check(&place, "instance");
    assert_eq!(verdict, "FAIL", "{seen}");
    assert!(seen.contains("mode 755"), "{seen}");
}

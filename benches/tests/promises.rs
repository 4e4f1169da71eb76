//! The short form of `taut-bench promises`: what no noise of the machine can change has to hold, times
//! are only printed.
//!
//! The long form, about 90 minutes: `cargo run --release -p taut-bench -- promises --long`.

mod common;

use std::sync::{Mutex, PoisonError};

use common::Place;

/// One after the other: each wants the machine for itself.
static ALONE: Mutex<()> = Mutex::new(());

fn holds(promise: &str) {
    let _guard = ALONE
        .lock()
        .unwrap_or_else(PoisonError::into_inner);
    let place = Place::new();
    let run = place.run(&["promises", "--only", promise, "--format", "json"]);
    assert!([0, 1].contains(&run.exit), "{}{}", run.out, run.err);
    let report = run.json();
    let rows = report["rows"].as_array().unwrap();
    let text = |row: &serde_json::Value, name: &str| row[name].as_str().unwrap().to_owned();
    for row in rows {
        let [figure, promised, measured] =
            ["figure", "promised", "measured"].map(|name| text(row, name));
        println!("{promise}: {figure}   promised {promised}   measured {measured}");
    }
    let broken: Vec<String> = rows
        .iter()
        .filter(|row| row["judged"] == true && row["kept"] == false)
        .map(|row| {
            format!(
                "{}: promised {}, measured {}",
                text(row, "figure"),
                text(row, "promised"),
                text(row, "measured")
            )
        })
        .collect();
    assert!(broken.is_empty(), "seed {}: {broken:#?}", report["seed"]);
    assert!(
        rows.iter().any(|row| row["judged"] == true) || promise == "cost" || promise == "overhead",
        "{report}"
    );
    assert_eq!((run.exit, report["kept"].as_bool()), (0, Some(true)));
}

macro_rules! promises {
    ($($name:ident: $promise:literal;)*) => {
        $(#[test] fn $name() { holds($promise); })*
    };
}

promises! {
    equal_requests_have_equal_answers: "determinism";
    a_poisonous_request_hurts_only_itself: "poison";
    a_dying_client_harms_nobody: "deaths";
    the_daemon_may_die: "restarts";
    an_instance_whose_files_are_removed_heals: "removed";
    stopped_readers_hold_nobody_up: "stopped";
    overload_is_refused: "overload";
    a_greedy_client_does_not_starve_others: "fairness";
    answers_come_by_their_deadline: "deadlines";
    a_cancelled_request_frees_its_worker: "cancelling";
    an_idle_daemon_takes_no_processor: "idle";
    the_bare_echo_is_measured_beside: "overhead";
    the_optimizer_in_process_is_measured_beside: "cost";
    planners_stay_small: "planners";
    memory_is_bounded: "memory";
}

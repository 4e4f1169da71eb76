//! What rows amount to: medians, means, who wins at which moment, sets taken together.

use std::collections::BTreeMap;

use super::curve::Curve;
use super::row::{Figures, PeerFigures, Row};
use super::summary::Summary;
use crate::statistics::{Average, Tally};

const BUDGETS_S: [f64; 2] = [1e-3, 10e-3];

/// An answer to a path of length 1 by steps (s, length).
fn answer(steps: &[(f64, f64)], proved: bool) -> Figures {
    let mut curve = Curve::new(1.0);
    steps
        .iter()
        .for_each(|&(time_s, length)| curve.push(time_s, length));
    Figures {
        proved,
        code: "",
        ratio: curve.remaining_at_end(),
        length: curve.remaining_at_end(),
        runs: 1,
        cpu_s: 0.02,
        time_s: 0.02,
        first_improvement_s: curve.first_s(),
        ratio_at: BUDGETS_S
            .map(|budget| curve.remaining(budget))
            .into(),
        curve,
        over_best_honest_peer: BTreeMap::new(),
        idle_travel_before: 0.0,
        idle_travel: 0.0,
        path_hash: String::new(),
        floor_m: 1e-3,
        floors_lowered: 0,
        iterations: 0,
        work: 0,
        termination: "",
        refusal: None,
    }
}

/// A path that `a` shortens by these steps and `b` at once to 0.6, and whose best honest peer gets
/// to 0.5 in 0.1 s.
fn row(set: &str, name: &str, steps: &[(f64, f64)]) -> Row {
    let peer = PeerFigures {
        ratio: 0.5,
        cpu_s: 0.1,
        honest: true,
    };
    let mut row = Row {
        set: set.to_owned(),
        name: name.to_owned(),
        length_before: Some(1.0),
        lower_bound: Some(0.25),
        answers: BTreeMap::from([
            ("a", answer(steps, !steps.is_empty())),
            ("b", answer(&[(1e-4, 0.6)], true)),
        ]),
        peers: BTreeMap::from([("peer".to_owned(), peer.clone())]),
        best_honest_peer: Some(("peer".to_owned(), peer)),
        ..Row::default()
    };
    row.compare();
    row
}

fn rows() -> [Row; 3] {
    [
        row("s_1", "quick", &[(5e-4, 0.8), (2e-3, 0.4)]),
        row("s_1", "late", &[(0.2, 0.5)]),
        row("s_2", "refused", &[]),
    ]
}

fn summary() -> Summary {
    let rows = rows();
    Summary::of(
        "s (pooled)",
        &rows.iter().collect::<Vec<_>>(),
        &["a", "b"],
        BUDGETS_S.len(),
    )
}

#[test]
fn an_answer_counts_from_when_it_came_and_one_that_is_not_proved_never() {
    let summary = summary();
    let a = &summary.modes["a"];
    assert_eq!(
        (summary.problems, summary.lower_bound, a.answers, a.valid),
        (3, Some(0.25), 3, 2)
    );
    let close = |average: Average, median: f64, mean: f64| {
        assert_eq!(average.median, median);
        assert!((average.mean - mean).abs() < 1e-12, "{average:?}");
    };
    close(a.ratio_at[0], 1.0, (0.8 + 1.0 + 1.0) / 3.0);
    close(a.ratio_at[1], 1.0, (0.4 + 1.0 + 1.0) / 3.0);
    close(
        Average {
            median: a.ratio,
            mean: a.ratio_mean,
        },
        0.5,
        (0.4 + 0.5 + 1.0) / 3.0,
    );
    close(a.ratio_proved.unwrap(), 0.45, 0.45);
    assert_eq!(a.first_improvement_s, Some((5e-4 + 0.2) / 2.0));
}

#[test]
fn peers_are_beaten_or_not_at_each_moment() {
    let summary = summary();
    let tally = |wins, ties, losses| Tally { wins, ties, losses };
    let versus = &summary.modes["a"].over_best_honest_peer;
    assert_eq!(versus["end"].tally, tally(1, 1, 1));
    // A twentieth of 0.1 s sees the quick path's last step, a hundredth only its first.
    assert_eq!(versus["peer_cpu_20th"].tally, tally(1, 0, 2));
    assert_eq!(versus["peer_cpu_100th"].tally, tally(0, 0, 3));
    assert_eq!(
        (versus["end"].median, versus["end"].worst.value),
        (1.0, 2.0)
    );
    assert_eq!(versus["end"].worst.problem, "s_2/refused");
    let peer = &summary.peers["peer"];
    assert_eq!(
        (peer.answers, peer.valid, peer.ratio, peer.cpu_s),
        (3, 3, 0.5, 0.1)
    );
    assert_eq!(
        (peer.ours["a"]["end"], peer.ours["a"]["peer_cpu"]),
        (tally(1, 1, 1), tally(1, 0, 2))
    );
    assert_eq!(peer.ours["b"]["end"], tally(0, 0, 3));
}

#[test]
fn each_mode_is_measured_against_the_best_of_the_others() {
    let summary = summary();
    let above = |mode: &str| -> Vec<[i64; 2]> {
        let above = summary.modes[mode].above_other_modes.iter();
        let rounded = |percent: Option<f64>| percent.unwrap().round() as i64;
        above
            .map(|above| [rounded(above.medians_percent), rounded(above.paths_percent)])
            .collect()
    };
    assert_eq!(above("a"), [[67, 67], [67, 67], [-17, -17]]);
    assert_eq!(above("b"), [[-40, -40], [-40, -40], [20, 20]]);
}

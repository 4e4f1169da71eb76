//! How requests ended, as rows.

use crate::orders::Tally;
use crate::row::Row;
use crate::statistics::time;

/// Every request ends, with an answer or a code.
pub(super) fn ends(tally: &Tally, when: &str) -> Vec<Row> {
    let longest = tally.times.iter().copied().fold(0.0, f64::max);
    vec![
        Row::none(
            format!("of {} requests {when}, without an end", tally.sent),
            tally.endless,
        ),
        Row::told("  how they ended", tally.told()),
        Row::told("  longest time to an end", time(longest)),
        Row::told("  those over 1 s: sent at, took", slow(tally)),
    ]
}

/// A few of the slow ones.
fn slow(tally: &Tally) -> String {
    let some = tally.slow.iter().take(6);
    let told: Vec<String> = some
        .map(|(sent, took)| format!("{sent:.1} {took:.2}"))
        .collect();
    format!("{}: {}", tally.slow.len(), told.join(", "))
}

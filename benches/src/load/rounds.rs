//! When requests were under way, and which part of that a server took that computes one at a time.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::times::Times;

/// One request and its answer, as its client saw them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Round {
    /// When it was sent, on the monotonic clock, which all processes share (ns).
    pub sent_ns: u64,
    /// When its client had the answer (ns).
    pub ended_ns: u64,
    /// The computing in between, as the answer says (ns).
    pub compute_ns: u64,
}

/// What each took beyond computing and waiting for others.
///
/// A request waits until the answer before it is out, whosever that is. What is left of it then
/// is its own: all of the way there and back for a client that is alone, and for many at once the
/// time from answer to answer. Together these are all the time in which anything was under way
/// less the computing, so that no way of waiting hides any of it.
///
/// Clients that wake beside each other may see their answers in another order than they were
/// computed in. The one that comes late then has less time than its computing, which lies in the
/// shares before it and is taken off there.
///
/// Those that end within `looked_at` (ns) are given.
pub(super) fn own_shares(rounds: impl IntoIterator<Item = Round>, looked_at: &Range<u64>) -> Times {
    let mut rounds: Vec<Round> = rounds.into_iter().collect();
    rounds.sort_by_key(|round| round.ended_ns);
    let mut before_ns = 0;
    let mut shares: Vec<u64> = Vec::with_capacity(rounds.len());
    for round in &rounds {
        let taken_ns = round.ended_ns - round.sent_ns.max(before_ns);
        take_off(&mut shares, round.compute_ns.saturating_sub(taken_ns));
        shares.push(taken_ns.saturating_sub(round.compute_ns));
        before_ns = round.ended_ns;
    }
    let mut times = Times::default();
    for (round, share) in rounds.iter().zip(shares) {
        if looked_at.contains(&round.ended_ns) {
            times.add(share);
        }
    }
    times
}

/// Takes this much off the last shares.
fn take_off(shares: &mut [u64], mut over_ns: u64) {
    for share in shares.iter_mut().rev() {
        if over_ns == 0 {
            return;
        }
        let part_ns = over_ns.min(*share);
        *share -= part_ns;
        over_ns -= part_ns;
    }
}

/// The middle half of the time (ns) in which anything was under way. Clients have stood still
/// before, all wake at once, and take ten times their usual CPU for their first answers, on the
/// server's core as well; at the end some are through and write down what they saw.
pub(super) fn middle(rounds: &[Round]) -> Range<u64> {
    let sent = rounds.iter().map(|round| round.sent_ns);
    let ended = rounds.iter().map(|round| round.ended_ns);
    let begin_ns = sent.min().unwrap_or(0);
    let end_ns = ended.max().unwrap_or(0);
    let quarter_ns = (end_ns - begin_ns) / 4;
    begin_ns + quarter_ns..end_ns - quarter_ns
}

/// The longest time from begin to end in which a client had no answer, between those it had (ns).
pub(super) fn longest_pause_ns(rounds: &[Round], begin_ns: u64, end_ns: u64) -> u64 {
    let ends = rounds.iter().map(|round| round.ended_ns);
    let mut before_ns = begin_ns;
    let mut longest_ns = 0;
    for now_ns in ends.chain([end_ns]) {
        longest_ns = longest_ns.max(now_ns.saturating_sub(before_ns));
        before_ns = now_ns;
    }
    longest_ns
}

#[cfg(test)]
mod tests {
    use super::*;

    fn round(sent_ns: u64, ended_ns: u64, compute_ns: u64) -> Round {
        Round {
            sent_ns,
            ended_ns,
            compute_ns,
        }
    }

    /// In nanoseconds, shortest first.
    fn sorted(times: Times) -> Vec<u64> {
        let counts: Vec<(u64, u64)> = times.into();
        counts
            .iter()
            .flat_map(|&(time, count)| vec![time; count as usize])
            .collect()
    }

    #[test]
    fn whoever_is_alone_takes_the_whole_way() {
        let alone = [round(100, 200, 30), round(250, 400, 50)];
        assert_eq!(sorted(own_shares(alone, &(0..u64::MAX))), [70, 100]);
    }

    #[test]
    fn the_shares_of_a_crowd_are_the_time_that_passes_less_the_computing() {
        // All sent at once; the answers come one after the other, and not in order here.
        let crowd = [round(0, 300, 60), round(0, 100, 60), round(0, 220, 60)];
        assert_eq!(sorted(own_shares(crowd, &(0..u64::MAX))), [20, 40, 60]);
        assert_eq!(20 + 40 + 60 + 3 * 60, 300);
    }

    #[test]
    fn a_pause_is_also_before_the_first_answer_and_after_the_last() {
        let rounds = [round(0, 100, 0), round(100, 150, 0)];
        let pause = |begin_ns, end_ns| longest_pause_ns(&rounds, begin_ns, end_ns);
        assert_eq!(
            (pause(90, 160), pause(0, 160), pause(90, 400)),
            (50, 100, 250)
        );
        assert_eq!(longest_pause_ns(&[], 10, 90), 80);
    }

    #[test]
    fn the_computing_of_an_answer_that_comes_late_is_in_the_shares_before_it() {
        let pair = [round(0, 100, 60), round(0, 110, 60)];
        assert_eq!(
            sorted(own_shares(pair, &(0..u64::MAX))),
            [0, 0],
            "120 of 110 were computed"
        );
        let overtaken = [round(0, 100, 60), round(0, 300, 80), round(0, 310, 90)];
        assert_eq!(sorted(own_shares(overtaken, &(0..u64::MAX))), [0, 40, 40]);
        assert_eq!(40 + 40 + 60 + 80 + 90, 310, "all the time");
    }

    #[test]
    fn the_middle_half_is_looked_at() {
        let rounds: Vec<Round> = [4, 1, 2, 3, 8, 6]
            .map(|end_ns| round(0, end_ns, 0))
            .into();
        assert_eq!(middle(&rounds), 2..6);
        let shares = own_shares(rounds.iter().copied(), &middle(&rounds));
        assert_eq!(sorted(shares), [1, 1, 1], "those that end at 2, 3 and 4");
        assert!(middle(&[]).is_empty());
    }
}

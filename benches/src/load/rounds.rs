//! When requests were under way, and which part of that a server took that computes one at a time.

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
pub(super) fn own_shares(rounds: impl IntoIterator<Item = Round>) -> Times {
    let mut rounds: Vec<Round> = rounds.into_iter().collect();
    rounds.sort_by_key(|round| round.ended_ns);
    let mut before_ns = 0;
    let mut shares = Times::default();
    for round in rounds {
        let taken_ns = round.ended_ns - round.sent_ns.max(before_ns);
        shares.add(taken_ns.saturating_sub(round.compute_ns));
        before_ns = round.ended_ns;
    }
    shares
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
        assert_eq!(sorted(own_shares(alone)), [70, 100]);
    }

    #[test]
    fn the_shares_of_a_crowd_are_the_time_that_passes_less_the_computing() {
        // All sent at once; the answers come one after the other, and not in order here.
        let crowd = [round(0, 300, 60), round(0, 100, 60), round(0, 220, 60)];
        assert_eq!(sorted(own_shares(crowd)), [20, 40, 60]);
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
    fn an_answer_that_comes_with_the_one_before_has_no_share_below_none() {
        let pair = [round(0, 100, 60), round(0, 110, 60)];
        assert_eq!(sorted(own_shares(pair)), [0, 40]);
    }
}

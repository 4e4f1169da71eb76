//! When ours is compared with an answer of a peer.

/// CPU times below this are not told apart (s): recorded ones are no finer.
const FINEST_S: f64 = 1e-3;

/// A moment of our run, by the CPU time that the peer took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Moment {
    /// When ours is done.
    End,
    /// When the peer was done.
    ItsTime,
    /// At a twentieth of that, but not before 1 ms.
    Twentieth,
    /// At a hundredth of that, but not before 1 ms.
    Hundredth,
}

/// The moments at which any peer is compared.
pub(super) const AGAINST_ANY: [Moment; 2] = [Moment::End, Moment::ItsTime];
/// Those at which the best honest peer of each path is.
pub(super) const AGAINST_BEST: [Moment; 3] = [Moment::End, Moment::Twentieth, Moment::Hundredth];

impl Moment {
    /// Name in JSON.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::End => "end",
            Self::ItsTime => "peer_cpu",
            Self::Twentieth => "peer_cpu_20th",
            Self::Hundredth => "peer_cpu_100th",
        }
    }

    /// Name for people.
    pub(super) fn text(self) -> &'static str {
        match self {
            Self::End => "at the end",
            Self::ItsTime => "at its CPU",
            Self::Twentieth => "at its CPU ÷ 20",
            Self::Hundredth => "at its CPU ÷ 100",
        }
    }

    /// Time since the start of our run (s).
    pub(super) fn time_s(self, peer_cpu_s: f64) -> f64 {
        match self {
            Self::End => f64::INFINITY,
            Self::ItsTime => peer_cpu_s,
            Self::Twentieth => (peer_cpu_s / 20.0).max(FINEST_S),
            Self::Hundredth => (peer_cpu_s / 100.0).max(FINEST_S),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_short_time_are_a_millisecond() {
        assert_eq!(
            (Moment::Twentieth.time_s(1.0), Moment::Hundredth.time_s(1.0)),
            (0.05, 0.01)
        );
        assert_eq!(
            (
                Moment::Twentieth.time_s(0.01),
                Moment::Hundredth.time_s(0.01)
            ),
            (1e-3, 1e-3)
        );
        assert_eq!(Moment::ItsTime.time_s(1e-4), 1e-4);
    }
}

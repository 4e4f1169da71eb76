//! What a link does to packets, switched while it runs.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Parts of a million.
pub(super) const MILLION: u64 = 1_000_000;

/// What happens to each packet of a link, in either direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Weather {
    /// Time that it takes one way.
    pub delay: Duration,
    /// Part of the packets that are lost, 0 to 1.
    pub loss: f64,
    /// None comes through.
    pub cut: bool,
}

impl Weather {
    /// A link that is there and does nothing.
    pub(crate) const CLEAR: Self = Self {
        delay: Duration::ZERO,
        loss: 0.0,
        cut: false,
    };
    /// A link that is not there.
    pub(crate) const CUT: Self = Self {
        cut: true,
        ..Self::CLEAR
    };

    /// A round trip of so many milliseconds, and so much loss.
    pub(crate) fn far(round_trip_ms: u64, loss: f64) -> Self {
        Self {
            delay: Duration::from_micros(round_trip_ms * 500),
            loss,
            ..Self::CLEAR
        }
    }
}

/// The weather of now, read by the link's threads for every packet.
#[derive(Debug, Default)]
pub(super) struct Sky {
    delay_ns: AtomicU64,
    /// In millionths; all of them is a cut.
    loss: AtomicU64,
}

impl Sky {
    /// Lets it be so from now on.
    pub(super) fn set(&self, weather: Weather) {
        let loss = match weather.cut {
            true => MILLION,
            false => (weather.loss * MILLION as f64) as u64,
        };
        self.delay_ns
            .store(weather.delay.as_nanos() as u64, Ordering::Relaxed);
        self.loss.store(loss, Ordering::Relaxed);
    }

    pub(super) fn delay(&self) -> Duration {
        Duration::from_nanos(self.delay_ns.load(Ordering::Relaxed))
    }

    /// Whether a packet with this random number is lost.
    pub(super) fn loses(&self, random: u64) -> bool {
        random % MILLION < self.loss.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_loses_all_and_clear_weather_none() {
        let sky = Sky::default();
        let lost = |sky: &Sky| {
            (0..MILLION)
                .filter(|&random| sky.loses(random))
                .count()
        };
        assert_eq!(lost(&sky), 0);
        sky.set(Weather::CUT);
        assert_eq!(lost(&sky), 1_000_000);
        sky.set(Weather::far(100, 0.05));
        assert_eq!(lost(&sky), 50_000);
        assert_eq!(sky.delay(), Duration::from_millis(50));
    }
}

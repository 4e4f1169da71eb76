//! Requests that crashed: after the second time nobody tries again.

use std::collections::VecDeque;

use taut_ipc::control::Refusal;
use taut_ipc::wire::Code;

/// Crashes of a request after which it is refused.
const MOST: u32 = 2;
/// Crashed requests that are remembered.
const REMEMBERED: usize = 256;

/// Contents of requests on which the core panicked, with how often.
#[derive(Default)]
pub(crate) struct Poison {
    crashed: VecDeque<(u64, u32)>,
}

impl Poison {
    /// The core panicked on this content.
    pub(crate) fn crashed(&mut self, content: u64) {
        let known = self
            .crashed
            .iter_mut()
            .find(|(known, _)| *known == content);
        match known {
            Some((_, times)) => *times += 1,
            None => self.remember(content),
        }
    }

    fn remember(&mut self, content: u64) {
        if self.crashed.len() == REMEMBERED {
            self.crashed.pop_front();
        }
        self.crashed.push_back((content, 1));
    }

    /// Refuses what crashed too often; `content` is asked for only if anything did.
    pub(crate) fn check(&self, content: impl FnOnce() -> u64) -> Result<(), Refusal> {
        if self.crashed.is_empty() {
            return Ok(());
        }
        match self.times(content()) {
            times @ MOST.. => Err(refusal(times)),
            _ => Ok(()),
        }
    }

    /// How often the core panicked on this content.
    fn times(&self, content: u64) -> u32 {
        let mut crashed = self.crashed.iter();
        crashed
            .find(|(known, _)| *known == content)
            .map_or(0, |(_, times)| *times)
    }
}

fn refusal(times: u32) -> Refusal {
    let text = format!(
        "this request crashed its worker {times} times and is not tried again; report it as a defect"
    );
    Refusal::new(Code::Crash, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_third_time_is_refused_and_others_are_not() {
        let mut poison = Poison::default();
        assert!(
            poison
                .check(|| unreachable!("nothing crashed yet"))
                .is_ok()
        );
        poison.crashed(7);
        assert!(poison.check(|| 7).is_ok(), "once may be chance");
        poison.crashed(7);
        assert_eq!(poison.check(|| 7).unwrap_err().code, i32::from(Code::Crash));
        assert!(poison.check(|| 8).is_ok());
        for content in 100..100 + REMEMBERED as u64 {
            poison.crashed(content);
        }
        assert!(poison.check(|| 7).is_ok(), "the memory is bounded");
    }
}

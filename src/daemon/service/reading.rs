//! A robot or scene whose files are being read: what requests for it hear meanwhile.

use std::sync::OnceLock;

use taut_ipc::control::{ModelState, Refusal};

use crate::daemon::translate::{so_far, still_loading};

/// A label whose content is on its way.
pub(crate) struct Reading {
    label: String,
    is_robot: bool,
    /// When it was asked for, on the monotonic clock.
    since_ns: u64,
    /// What is made of the files, once they are read.
    step: OnceLock<String>,
}

impl Reading {
    /// Its files are read from now on.
    pub(crate) fn new(label: &str, is_robot: bool, now_ns: u64) -> Self {
        Self {
            label: label.to_owned(),
            is_robot,
            since_ns: now_ns,
            step: OnceLock::new(),
        }
    }

    /// The files are read, and this is made of them.
    pub(crate) fn makes(&self, step: String) {
        // It is told once for each.
        let _ = self.step.set(step);
    }

    /// The refusal of what names the label.
    pub(crate) fn refusal(&self, now_ns: u64) -> Refusal {
        let kind = if self.is_robot { "robot" } else { "scene" };
        let what = format!("{kind} {}", self.label);
        still_loading(&what, &self.step(now_ns), self.passed_ns(now_ns))
    }

    /// How far it is.
    pub(crate) fn state(&self, now_ns: u64) -> ModelState {
        ModelState {
            label: self.label.clone(),
            is_robot: self.is_robot,
            missing: self.step(now_ns),
            ..ModelState::default()
        }
    }

    fn step(&self, now_ns: u64) -> String {
        let step = self
            .step
            .get()
            .map_or("its files are being read", String::as_str);
        so_far(step, self.passed_ns(now_ns))
    }

    fn passed_ns(&self, now_ns: u64) -> u64 {
        now_ns.saturating_sub(self.since_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_says_which_step_is_taken_and_for_how_long() {
        let reading = Reading::new("arm", true, 1_000_000_000);
        let refusal = reading.refusal(1_500_000_000);
        assert_eq!(
            refusal.message,
            "robot arm is still being made: its files are being read, 0.5 s so far; send again in 500 ms"
        );
        reading.makes("solids of 2 links".to_owned());
        assert_eq!(
            reading.state(3_000_000_000).missing,
            "solids of 2 links, 2.0 s so far"
        );
    }
}

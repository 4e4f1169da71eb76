//! The status message: what else is done when one is due, and what it says.

use std::collections::BTreeMap;

use taut::store::{RobotEntry as Robot, SceneEntry as Scene};
use taut_ipc::monotonic_ns;
use taut_ipc::server::ServerError;
use taut_ipc::wire::{RobotEntry, SceneEntry, StatusRecord};

use super::event_loop::EventLoop;
use super::heal;

impl EventLoop {
    pub(super) fn publish_status_when_due(&mut self) -> Result<(), ServerError> {
        match self.status_clock.ticks() {
            true => self.publish_status(),
            false => Ok(()),
        }
    }

    fn publish_status(&mut self) -> Result<(), ServerError> {
        self.notice_removal();
        self.forget_the_absent();
        self.pulse.beat();
        let status = self.status();
        self.server.publish_status(&status)?;
        self.show_figures();
        self.cleaning.warn_if_slow();
        Ok(())
    }

    /// Ends what is open where nobody else can come any more.
    fn notice_removal(&mut self) {
        if let Some(missing) = self.server.missing_file() {
            heal::warn(missing);
            self.drain_removed();
        }
    }

    /// Forgets clients that are away, and ends the recording that nobody asks about.
    fn forget_the_absent(&mut self) {
        self.clients.forget(monotonic_ns());
        self.recorder.end_forgotten(monotonic_ns());
    }

    fn show_figures(&mut self) {
        if let Some(live) = self.live.clone() {
            let numbers = self.stats().numbers;
            live.counted(numbers, self.clients.summaries(monotonic_ns()));
        }
    }

    /// The state of the daemon.
    pub(super) fn status(&mut self) -> StatusRecord {
        let mut status = self.counted();
        enter_robots(&mut status, self.store.robots());
        enter_scenes(&mut status, self.store.scenes());
        self.metrics.made(self.store.made());
        self.metrics.enter(&mut status);
        status
    }

    fn counted(&self) -> StatusRecord {
        let queued = self.schedule.waiting();
        StatusRecord {
            workers: self.limits.workers as u32,
            queued: queued as u32,
            running: self.open.len().saturating_sub(queued) as u32,
            clients: self.server.clients() as u32,
            robots: self.store.robots().len() as u32,
            scenes: self.store.scenes().len() as u32,
            cleaned_nodes: self.cleaning.cleaned(),
            ..StatusRecord::default()
        }
    }
}

fn enter_robots(status: &mut StatusRecord, robots: &BTreeMap<String, Robot>) {
    for (entry, robot) in status.robot.iter_mut().zip(robots.values()) {
        *entry = RobotEntry {
            id: robot.id,
            hash: robot.robot.hash(),
        };
    }
}

fn enter_scenes(status: &mut StatusRecord, scenes: &BTreeMap<String, Scene>) {
    for (entry, scene) in status.scene.iter_mut().zip(scenes.values()) {
        *entry = SceneEntry {
            id: scene.id,
            hash: scene.scene.hash(),
            version: scene.version,
        };
    }
}

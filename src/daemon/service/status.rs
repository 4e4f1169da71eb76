//! The status message: what else is done when one is due, and what it says.

use std::collections::BTreeMap;

use taut::store::{RobotEntry as Robot, SceneEntry as Scene};
use taut_ipc::wire::{RobotEntry, SceneEntry, StatusRecord};

use super::Service;
use super::effect::{Effect, InOrder};
use super::event::Surroundings;

impl Service {
    /// Time has passed: publishes the status when it is due.
    pub(super) fn tick(&mut self, around: Surroundings) {
        if self.status_clock.ticks(self.now_ns) {
            self.look_for_files();
            self.forget_the_absent();
            let status = self.status(around);
            self.in_order(InOrder::Status(Box::new(status)));
            self.show_figures(around);
        }
    }

    fn look_for_files(&mut self) {
        if !self.is_draining {
            self.effects.push(Effect::LookForFiles);
        }
    }

    /// Forgets clients that are away, and ends the recording that nobody asks about.
    fn forget_the_absent(&mut self) {
        self.clients.forget(self.now_ns);
        self.recorder.end_forgotten(self.now_ns);
    }

    fn show_figures(&mut self, around: Surroundings) {
        if self.shows {
            let numbers = self.stats(around).numbers;
            let summaries = self.clients.summaries(self.now_ns);
            self.in_order(InOrder::Show(numbers, summaries));
        }
    }

    /// The state of the daemon.
    pub(super) fn status(&mut self, around: Surroundings) -> StatusRecord {
        let mut status = self.counted(around);
        enter_robots(&mut status, self.store.robots());
        enter_scenes(&mut status, self.store.scenes());
        self.metrics.made(self.store.made());
        self.metrics.enter(&mut status, self.now_ns);
        status
    }

    fn counted(&self, around: Surroundings) -> StatusRecord {
        let queued = self.schedule.waiting();
        StatusRecord {
            workers: self.limits.workers as u32,
            queued: queued as u32,
            running: self.open.worked_on().saturating_sub(queued) as u32,
            clients: around.clients,
            robots: self.store.robots().len() as u32,
            scenes: self.store.scenes().len() as u32,
            cleaned_nodes: around.cleaned_nodes,
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

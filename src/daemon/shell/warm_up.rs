//! What a daemon that starts again makes before anybody asks for it: robots and scenes that were
//! restored without their solids.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use taut::store::{ModelStore, PreparedModel, PreparedScene};
use taut_ipc::monotonic_ns;

use crate::daemon::durability::prepared::Prepared;
use crate::daemon::service::event::Event;
use crate::daemon::threads::{Started, spawn_nice};

/// What is to be made.
pub(super) struct WarmUp {
    robots: Vec<Arc<PreparedModel>>,
    scenes: Vec<Arc<PreparedScene>>,
    prepared: Option<Prepared>,
}

impl WarmUp {
    /// Robots and scenes of a store, and where the solids of robots are kept.
    pub(super) fn of(store: &ModelStore, prepared: Option<Prepared>) -> Self {
        let robots = store.robots().values();
        let scenes = store.scenes().values();
        Self {
            robots: robots
                .filter_map(|entry| store.alone(&entry.robot).cloned())
                .collect(),
            scenes: scenes
                .filter_map(|entry| store.prepared_scene(&entry.scene).cloned())
                .collect(),
            prepared,
        }
    }

    /// Starts the thread, which tells of each robot that it has made; it ends when everything is.
    pub(super) fn start(
        self,
        niceness: i32,
        tell: impl Fn(Event) -> bool + Send + 'static,
    ) -> Started<()> {
        let thread = spawn_nice("taut-warm-up", niceness, move || self.work(tell))?;
        Ok(((), thread))
    }

    fn work(self, tell: impl Fn(Event) -> bool) {
        if let Some(prepared) = &self.prepared {
            let robots = self.robots.iter();
            prepared.retain(
                &robots
                    .map(|alone| alone.robot())
                    .collect::<Vec<_>>(),
            );
        }
        for alone in &self.robots {
            self.make_robot(alone);
            if !tell(Event::Prepared) {
                return;
            }
        }
        // A scene that panics is made again by its request's worker, which answers with what it
        // says.
        for scene in &self.scenes {
            let _ = catch_unwind(AssertUnwindSafe(|| scene.solids().bytes()));
        }
    }

    fn make_robot(&self, alone: &PreparedModel) {
        alone.begin(monotonic_ns());
        let model = catch_unwind(AssertUnwindSafe(|| alone.get().ok().cloned()));
        match (model, &self.prepared) {
            (Ok(Some(model)), Some(prepared)) => prepared.keep(&model),
            (Err(_), _) => alone.give_up(),
            _ => {}
        }
    }
}

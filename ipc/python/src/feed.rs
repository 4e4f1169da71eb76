//! Changes of scenes as they happen.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Mutex;
use std::time::{Duration, Instant};
use taut_ipc::client::{Loss, SceneEventFeed};
use taut_ipc::planner::{Planner, PlannerError};
use taut_ipc::wire::{Code, SceneEvent, SceneEventKind};
use taut_ipc::{Client, ClientError, DaemonState};

use super::errors;
use super::guard::{self, Own};

/// How often it looks: events do not wake who waits for them.
const LOOK: Duration = Duration::from_millis(10);
/// How often it looks for signals and whether the daemon lives.
const SIGNALS: Duration = Duration::from_millis(50);

/// Changes of a daemon's scenes from now on.
#[pyclass(frozen, module = "taut._taut")]
pub struct SceneFeed {
    feed: Mutex<Own<(SceneEventFeed, Client)>>,
    scene_id: u64,
    boot: DaemonState,
}

impl SceneFeed {
    pub fn open(planner: &Planner, scene_id: u64) -> PyResult<Self> {
        let text = "changes are told by a daemon only; here nobody else makes any";
        let client = planner
            .client()
            .ok_or_else(|| errors::raise(Code::MalformedRequest, text))?
            .clone();
        let feed = client
            .scene_event_feed()
            .map_err(|error| errors::of(&error.into()))?;
        let boot = client.daemon_state();
        Ok(Self {
            feed: Mutex::new(Own::new((feed, client))),
            scene_id,
            boot,
        })
    }

    fn wait(&self, until: Instant) -> Result<Option<SceneEvent>, PlannerError> {
        let feed = self
            .feed
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        let Ok((feed, client)) = feed.get() else {
            return Ok(None);
        };
        loop {
            while let Some(event) = feed.next()? {
                if event.scene_id == self.scene_id {
                    return Ok(Some(event));
                }
            }
            if client.daemon_state() != self.boot {
                let root = String::from("the instance");
                let loss = Loss::Unsubscribed;
                return Err(ClientError::DaemonLost { root, loss }.into());
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            std::thread::sleep(left.min(LOOK));
        }
    }
}

#[pymethods]
impl SceneFeed {
    /// The next change, or None after `timeout` seconds.
    #[pyo3(signature = (timeout=None))]
    fn next<'py>(
        &self,
        py: Python<'py>,
        timeout: Option<f64>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let end = guard::end_of(timeout)?;
        self.feed
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
            .get()?;
        loop {
            let slice = Instant::now() + SIGNALS;
            let until = end.map_or(slice, |end| end.min(slice));
            let event = py
                .detach(|| self.wait(until))
                .map_err(|error| errors::of(&error))?;
            py.check_signals()?;
            if let Some(event) = event {
                return dict(py, &event).map(Some);
            }
            if end.is_some_and(|end| Instant::now() >= end) {
                return Ok(None);
            }
        }
    }
}

fn dict<'py>(py: Python<'py>, event: &SceneEvent) -> PyResult<Bound<'py, PyDict>> {
    let kind = match SceneEventKind::try_from(event.kind) {
        Ok(SceneEventKind::Created) => "created",
        Ok(SceneEventKind::Changed) => "changed",
        Ok(SceneEventKind::Deleted) => "deleted",
        Ok(SceneEventKind::PathUnsafe) => "path-unsafe",
        Err(_) => "unknown",
    };
    let is_path = kind == "path-unsafe";
    let dict = PyDict::new(py);
    dict.set_item("kind", kind)?;
    dict.set_item("version", event.scene_version)?;
    dict.set_item("hash", format!("{:016x}", event.scene_hash))?;
    dict.set_item(
        "request_id",
        is_path.then(|| format!("{:016x}", event.subscription)),
    )?;
    dict.set_item("segment", is_path.then_some(event.segment))?;
    Ok(dict)
}

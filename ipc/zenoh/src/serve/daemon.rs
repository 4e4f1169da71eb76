//! The daemon beside the gateway: whether it is there, and what it publishes.

use super::gate::Gate;
use crate::call::Gateway;
use crate::names;
use std::sync::Arc;
use std::time::{Duration, Instant};
use taut_ipc::DaemonState;
use taut_ipc::client::{Client, ClientError, SceneEventFeed, StatusFeed};
use taut_ipc::wire::{SceneEvent, StatusRecord};
use zenoh::Wait;
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::{CongestionControl, Priority};

/// How often a daemon that is not there is looked for.
const RETRY: Duration = Duration::from_millis(100);

/// The daemon as its gateway knows it.
pub(super) struct Daemon {
    gate: Arc<Gate>,
    link: Option<Link>,
    tried: Option<Instant>,
    unfit: Option<Unfit>,
}

/// Why it cannot be served, as it was told last: in the log, and to clients by a token.
struct Unfit {
    reason: String,
    _token: Option<LivelinessToken>,
}

/// Why there is no link.
enum NoLink {
    /// There will be: the daemon is not there, or is starting.
    Yet(String),
    /// Not with this daemon: it is of another release, or has no room.
    WithThis(String),
}

impl From<ClientError> for NoLink {
    fn from(error: ClientError) -> Self {
        let reason = error.to_string();
        match error {
            ClientError::DaemonLost { .. } => Self::Yet(reason),
            _ => Self::WithThis(reason),
        }
    }
}

/// A start of the daemon, while it lasts.
struct Link {
    client: Client,
    boot: u64,
    status: StatusFeed,
    events: SceneEventFeed,
    _token: LivelinessToken,
}

impl Daemon {
    pub(super) fn new(gate: Arc<Gate>) -> Self {
        Self {
            gate,
            link: None,
            tried: None,
            unfit: None,
        }
    }

    /// Looks whether it is there, and passes on what it published.
    pub(super) fn look(&mut self) {
        if let Some(link) = &self.link
            && !(link.is_there() && link.publish(&self.gate))
        {
            // Clients are told by the token, after their requests are known to be lost.
            self.gate.daemon_changed();
            self.link = None;
            self.tried = None;
        }
        let is_due = self
            .tried
            .is_none_or(|tried| tried.elapsed() >= RETRY);
        if self.link.is_none() && is_due {
            self.tried = Some(Instant::now());
            self.link = self.open();
        }
    }

    fn open(&mut self) -> Option<Link> {
        match Link::open(&self.gate) {
            Ok(link) => {
                self.unfit = None;
                Some(link)
            }
            Err(NoLink::Yet(reason)) => {
                self.unfit = None;
                tracing::debug!("no daemon: {reason}");
                None
            }
            Err(NoLink::WithThis(reason)) => {
                self.tell(reason);
                None
            }
        }
    }

    /// Once: it is tried again and again.
    fn tell(&mut self, reason: String) {
        let known = self.unfit.as_ref().map(|unfit| &unfit.reason);
        if known == Some(&reason) {
            return;
        }
        tracing::error!("the daemon cannot be served: {reason}");
        let key = names::unfit_token(self.gate.name(), &reason);
        let token = self
            .gate
            .session
            .liveliness()
            .declare_token(key)
            .wait();
        self.unfit = Some(Unfit {
            reason,
            _token: token.ok(),
        });
    }
}

impl Link {
    fn open(gate: &Gate) -> Result<Self, NoLink> {
        let client = Client::connect(&gate.instance)?;
        let DaemonState::Running { boot_id, .. } = client.daemon_state() else {
            return Err(NoLink::Yet("it is starting".to_owned()));
        };
        let status = client.status_feed()?;
        let events = client.scene_event_feed()?;
        let gateway = Gateway {
            name: gate.name().into(),
            boot: boot_id,
        };
        let token = gate
            .session
            .liveliness()
            .declare_token(names::daemon_token(&gateway))
            .wait()
            .map_err(|error| NoLink::WithThis(error.to_string()))?;
        tracing::info!("the daemon is there, start {boot_id:016x}");
        Ok(Self {
            client,
            boot: boot_id,
            status,
            events,
            _token: token,
        })
    }

    fn is_there(&self) -> bool {
        let state = self.client.daemon_state();
        matches!(state, DaemonState::Running { boot_id, .. } if boot_id == self.boot)
    }

    /// Passes on what was published; false where a feed broke.
    fn publish(&self, gate: &Gate) -> bool {
        let status = self.status.latest();
        if let Ok(Some(record)) = &status {
            put_status(gate, record);
        }
        loop {
            match self.events.next() {
                Ok(Some(event)) => put_event(gate, &event),
                Ok(None) => return status.is_ok(),
                Err(_) => return false,
            }
        }
    }
}

/// Priorities other than that of answers: whoever does not read those has this thread wait for
/// nothing.
fn put_status(gate: &Gate, record: &StatusRecord) {
    let key = names::status(gate.name());
    put(gate, key, bytemuck::bytes_of(record), Priority::Background);
}

fn put_event(gate: &Gate, event: &SceneEvent) {
    let key = names::scene_event(gate.name(), event.scene_id);
    put(
        gate,
        key,
        bytemuck::bytes_of(event),
        Priority::InteractiveLow,
    );
}

fn put(gate: &Gate, key: String, bytes: &[u8], priority: Priority) {
    let sent = gate
        .session
        .put(key, bytes)
        .congestion_control(CongestionControl::Drop)
        .priority(priority)
        .express(true)
        .wait();
    if let Err(error) = sent {
        tracing::warn!("not published: {error}");
    }
}

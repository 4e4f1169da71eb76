//! The gateways that are there.

use crate::call::Gateway;
use crate::names;
use crate::network::{NetworkError, declared};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Session, Wait};

type Waker = Box<dyn Fn() + Send + Sync>;

/// The gateways that are there, as their tokens tell.
pub struct Live {
    /// Daemons to ask, the best first; empty = all, by name.
    wanted: Vec<String>,
    seen: Mutex<BTreeSet<Gateway>>,
    wakers: Mutex<Vec<Waker>>,
}

impl std::fmt::Debug for Live {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.now()).finish()
    }
}

impl Live {
    /// Follows the tokens for as long as the session is open.
    ///
    /// # Errors
    /// [`NetworkError::Declare`].
    pub fn watch(session: &Session, wanted: &[String]) -> Result<Arc<Self>, NetworkError> {
        let live = Arc::new(Self {
            wanted: wanted.to_vec(),
            seen: Mutex::default(),
            wakers: Mutex::default(),
        });
        let for_callback = live.clone();
        let subscriber = session
            .liveliness()
            .declare_subscriber(names::daemon_tokens())
            .history(true)
            .callback(move |sample| for_callback.changed(&sample))
            .background()
            .wait();
        declared("a subscriber of tokens", subscriber)?;
        Ok(live)
    }

    /// Has `waker` called whenever one comes or goes.
    pub fn wakes(&self, waker: impl Fn() + Send + Sync + 'static) {
        locked(&self.wakers).push(Box::new(waker));
    }

    /// Those that are there now, the best first.
    pub fn now(&self) -> Vec<Gateway> {
        let seen = locked(&self.seen);
        let mut live: Vec<_> = seen
            .iter()
            .filter_map(|gateway| Some((self.rank(gateway)?, gateway.clone())))
            .collect();
        live.sort();
        live.into_iter()
            .map(|(_, gateway)| gateway)
            .collect()
    }

    fn rank(&self, gateway: &Gateway) -> Option<usize> {
        match self.wanted.is_empty() {
            true => Some(0),
            false => self
                .wanted
                .iter()
                .position(|wanted| **wanted == *gateway.name),
        }
    }

    fn changed(&self, sample: &Sample) {
        let Some(gateway) = names::gateway_of(sample.key_expr().as_str()) else {
            return;
        };
        let daemon = &*gateway.name;
        let boot = gateway.boot;
        match sample.kind() {
            SampleKind::Put => {
                tracing::info!(daemon, "daemon is there, start {boot:016x}");
                locked(&self.seen).insert(gateway);
            }
            SampleKind::Delete => {
                tracing::info!(daemon, "daemon is gone, start {boot:016x}");
                locked(&self.seen).remove(&gateway);
            }
        }
        for wake in &*locked(&self.wakers) {
            wake();
        }
    }
}

pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
}

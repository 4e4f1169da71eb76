//! The gateways that are there.

use crate::call::Gateway;
use crate::names;
use crate::network::{NetworkError, declared};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Session, Wait};

type Waker = Box<dyn Fn() + Send + Sync>;

/// Gateways that are remembered at most, so that nobody fills the memory with tokens.
const MOST_GATEWAYS: usize = 1024;

/// The gateways that are there, as their tokens tell.
pub struct Live {
    /// Daemons to ask, the best first; empty = all, by name.
    wanted: Vec<String>,
    seen: Mutex<BTreeSet<Gateway>>,
    /// Daemons that cannot be served, by name, and why.
    unfit: Mutex<BTreeMap<String, String>>,
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
            unfit: Mutex::default(),
            wakers: Mutex::default(),
        });
        watch(session, &live, names::daemon_tokens(), Self::changed)?;
        watch(session, &live, names::unfit_tokens(), Self::unfit_changed)?;
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
            .filter_map(|gateway| Some((self.rank(&gateway.name)?, gateway.clone())))
            .collect();
        live.sort();
        live.into_iter()
            .map(|(_, gateway)| gateway)
            .collect()
    }

    /// Why nobody answers, and what to do.
    pub fn nobody(&self) -> String {
        let unfit = self.unfit();
        let mut told: String = unfit
            .iter()
            .map(|(daemon, reason)| format!("{daemon} is there and cannot be used: {reason}; "))
            .collect();
        if told.is_empty() {
            told.push_str("look with `taut-zenoh doctor`, and send again, that is safe");
        }
        format!("no gateway answers; {}", told.trim_end_matches("; "))
    }

    /// Daemons that cannot be served by the gateways beside them, by name, and why.
    pub fn unfit(&self) -> Vec<(String, String)> {
        let unfit = locked(&self.unfit);
        let wanted = unfit
            .iter()
            .filter(|(name, _)| self.rank(name).is_some());
        wanted
            .map(|(name, reason)| (name.clone(), reason.clone()))
            .collect()
    }

    fn rank(&self, name: &str) -> Option<usize> {
        match self.wanted.is_empty() {
            true => Some(0),
            false => self
                .wanted
                .iter()
                .position(|wanted| wanted == name),
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
                let mut seen = locked(&self.seen);
                if seen.len() < MOST_GATEWAYS {
                    seen.insert(gateway);
                }
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

    fn unfit_changed(&self, sample: &Sample) {
        let key = sample.key_expr().as_str();
        let Some((daemon, reason)) = names::unfit_of(key) else {
            return;
        };
        let mut unfit = locked(&self.unfit);
        match sample.kind() {
            SampleKind::Put if unfit.len() < MOST_GATEWAYS => {
                tracing::warn!(daemon, "daemon cannot be used: {reason}");
                unfit.insert(daemon.to_owned(), reason);
            }
            SampleKind::Put => {}
            // Another reason may have come before this one goes.
            SampleKind::Delete if unfit.get(daemon) == Some(&reason) => {
                unfit.remove(daemon);
            }
            SampleKind::Delete => {}
        }
    }
}

/// Has tokens taken for as long as the session is open, those that are there first.
fn watch(
    session: &Session,
    live: &Arc<Live>,
    tokens: String,
    take: fn(&Live, &Sample),
) -> Result<(), NetworkError> {
    let live = live.clone();
    let subscriber = session
        .liveliness()
        .declare_subscriber(tokens)
        .history(true)
        .callback(move |sample| take(&live, &sample))
        .background()
        .wait();
    declared("a subscriber of tokens", subscriber)
}

pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
}

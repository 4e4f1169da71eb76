//! What the requests of a process share, and whose they are.

use super::models::Models;
use super::seen::Seen;
use crate::call::Gateway;
use crate::live::Live;
use crate::message::Sender;
use crate::names;
use crate::network::{Network, NetworkError, declared};
use std::hash::{BuildHasher, RandomState};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use taut_ipc::wire::{Envelope, EnvelopeKind};
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::{Session, Wait};

/// What all requests of a process share.
#[derive(Debug)]
pub struct Caller {
    /// The session.
    pub session: Session,
    /// The gateways.
    pub live: Arc<Live>,
    /// Newest versions of scenes.
    pub seen: Seen,
    pub(super) models: Models,
    pub(super) late: AtomicU64,
    pub(super) resent: AtomicU64,
}

impl Caller {
    /// Opens the session and follows the gateways; `wanted` are the daemons to ask, the best first,
    /// or none for all.
    ///
    /// # Errors
    /// [`NetworkError`].
    pub fn open(network: &Network, wanted: &[String]) -> Result<Arc<Self>, NetworkError> {
        Self::over(network.open()?, wanted)
    }

    /// The same over a session that is open.
    ///
    /// # Errors
    /// [`NetworkError::Declare`].
    pub fn over(session: Session, wanted: &[String]) -> Result<Arc<Self>, NetworkError> {
        let live = Live::watch(&session, wanted)?;
        Ok(Arc::new(Self {
            session,
            live,
            seen: Seen::default(),
            models: Models::default(),
            late: AtomicU64::new(0),
            resent: AtomicU64::new(0),
        }))
    }

    /// Takes a client in, whose token says that it lives until it is dropped.
    ///
    /// # Errors
    /// [`NetworkError::Declare`].
    pub fn client(&self, name: String) -> Result<Client, NetworkError> {
        let id = RandomState::new().hash_one(0);
        let token = self
            .session
            .liveliness()
            .declare_token(names::client_token(id))
            .wait();
        let token = declared("a client's token", token)?;
        Ok(Client {
            id,
            name,
            _token: token,
        })
    }

    /// Best gateway that is there.
    pub fn best(&self) -> Option<Gateway> {
        self.live.now().into_iter().next()
    }

    /// Requests sent more than once, and final answers that came after the first, since the start.
    pub fn counts(&self) -> (u64, u64) {
        let resent = self.resent.load(Ordering::Relaxed);
        let late = self.late.load(Ordering::Relaxed);
        (resent, late)
    }
}

/// A client of gateways. Its requests are dropped by them soon after it is.
#[derive(Debug)]
pub struct Client {
    id: u64,
    name: String,
    _token: LivelinessToken,
}

impl Client {
    /// The number by which gateways know it.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// What accompanies its messages.
    pub fn attachment(&self, kind: EnvelopeKind, envelope: Envelope) -> ZBytes {
        let envelope = Envelope {
            client: self.id,
            ..envelope
        };
        Sender::write(&envelope, kind, &self.name)
    }
}

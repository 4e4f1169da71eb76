//! What the daemon publishes.

use super::ClientError;
use super::Loss;
use super::link::Link;
use crate::limits::SCENE_EVENT_BUFFER;
use crate::transport::{self, Variant};
use crate::wire::{SceneEvent, StatusRecord};
use iceoryx2::port::subscriber::Subscriber;
use std::sync::Arc;

/// The daemon's state, published twice a second.
#[derive(Debug)]
pub struct StatusFeed {
    subscriber: Subscriber<Variant, StatusRecord, ()>,
    link: Arc<Link>,
}

impl StatusFeed {
    pub(super) fn open(link: &Arc<Link>) -> Result<Self, ClientError> {
        let service = transport::status(&link.node).open();
        let service = service.map_err(|error| ClientError::setup("status", error))?;
        let subscriber = service
            .subscriber_builder()
            .buffer_size(1)
            .create();
        let subscriber = subscriber.map_err(|error| ClientError::setup("status feed", error))?;
        Ok(Self {
            subscriber,
            link: link.clone(),
        })
    }

    /// The newest state not seen yet; the first comes with the next publication.
    ///
    /// # Errors
    /// [`ClientError::Transport`] if the subscription broke, [`ClientError::DaemonLost`] where the
    /// daemon's files were removed: open one anew.
    pub fn latest(&self) -> Result<Option<StatusRecord>, ClientError> {
        let sample = self.subscriber.receive();
        let sample = sample.map_err(|error| ClientError::transport("status feed", error))?;
        seen(&self.link, sample.map(|sample| *sample.payload()))
    }
}

/// What was received; nothing will come any more of services that were removed.
fn seen<T>(link: &Link, received: Option<T>) -> Result<Option<T>, ClientError> {
    match received {
        None if link.is_stale() => Err(link.lost(Loss::Removed)),
        received => Ok(received),
    }
}

/// Changes of scenes.
#[derive(Debug)]
pub struct SceneEventFeed {
    subscriber: Subscriber<Variant, SceneEvent, ()>,
    link: Arc<Link>,
}

impl SceneEventFeed {
    pub(super) fn open(link: &Arc<Link>) -> Result<Self, ClientError> {
        let service = transport::scene_events(&link.node).open();
        let service = service.map_err(|error| ClientError::setup("scene events", error))?;
        let subscriber = service
            .subscriber_builder()
            .buffer_size(SCENE_EVENT_BUFFER)
            .create();
        let subscriber =
            subscriber.map_err(|error| ClientError::setup("scene event feed", error))?;
        Ok(Self {
            subscriber,
            link: link.clone(),
        })
    }

    /// The next change, if any; of more than 64 unread ones the oldest are lost.
    ///
    /// # Errors
    /// [`ClientError::Transport`] if the subscription broke, [`ClientError::DaemonLost`] where the
    /// daemon's files were removed: open one anew.
    pub fn next(&self) -> Result<Option<SceneEvent>, ClientError> {
        let sample = self.subscriber.receive();
        let sample = sample.map_err(|error| ClientError::transport("scene event feed", error))?;
        seen(&self.link, sample.map(|sample| *sample.payload()))
    }
}

//! Robots that were loaded through here, and the scene with nothing in it: gateways that come later,
//! or whose daemon was started again without them, get them when a request needs them there.

use crate::call::{Gateway, Nanos};
use crate::live::locked;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex};
use taut_ipc::content::Parcel;

/// Models that are remembered at most; the first go first.
const MOST_MODELS: usize = 256;

/// How far a model is at a gateway.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bringing {
    /// It is being brought.
    UnderWay,
    /// It was, or could not be, at this time.
    Done(Nanos),
}

/// A robot that was loaded, or a scene that never changes.
#[derive(Debug)]
pub(super) struct Model {
    /// Its id.
    pub(super) id: u64,
    /// The model that it is made of, which has to be there before.
    pub(super) base: Option<u64>,
    /// What loads it, always with the same content.
    pub(super) parcel: Parcel,
    brought: Mutex<BTreeMap<Gateway, Bringing>>,
}

/// The models.
#[derive(Debug, Default)]
pub(super) struct Models(Mutex<VecDeque<Arc<Model>>>);

impl Models {
    /// A model was loaded; it takes the place of one of its label.
    pub(super) fn note(&self, id: u64, base: Option<u64>, parcel: Parcel) -> Arc<Model> {
        let model = Arc::new(Model {
            id,
            base,
            parcel,
            brought: Mutex::default(),
        });
        let mut models = locked(&self.0);
        models.retain(|model| model.id != id);
        if models.len() >= MOST_MODELS {
            models.pop_front();
        }
        models.push_back(model.clone());
        model
    }

    /// A model was unloaded, and with it goes what is made of it.
    pub(super) fn forget(&self, id: u64) {
        locked(&self.0).retain(|model| model.id != id && model.base != Some(id));
    }

    pub(super) fn find(&self, id: u64) -> Option<Arc<Model>> {
        let models = locked(&self.0);
        models
            .iter()
            .find(|model| model.id == id)
            .cloned()
    }
}

impl Model {
    pub(super) fn at(&self, gateway: &Gateway) -> Option<Bringing> {
        locked(&self.brought).get(gateway).copied()
    }

    /// Whether whoever asks is to bring it there: nobody does so, nor has.
    pub(super) fn begin(&self, gateway: &Gateway, live: &[Gateway]) -> bool {
        let mut brought = locked(&self.brought);
        brought.retain(|gateway, _| live.contains(gateway));
        let is_new = !brought.contains_key(gateway);
        if is_new {
            brought.insert(gateway.clone(), Bringing::UnderWay);
        }
        is_new
    }

    pub(super) fn end(&self, gateway: &Gateway, now: Nanos) {
        locked(&self.brought).insert(gateway.clone(), Bringing::Done(now));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use taut_ipc::control::ControlRequest;

    fn gateway(boot: u64) -> Gateway {
        Gateway {
            name: "a".into(),
            boot,
        }
    }

    #[test]
    fn a_model_is_brought_once_to_each_start_of_a_daemon() {
        let models = Models::default();
        let model = models.note(7, None, Parcel::of(ControlRequest::List));
        let live = [gateway(1)];
        assert!(model.begin(&live[0], &live) && !model.begin(&live[0], &live));
        assert_eq!(model.at(&live[0]), Some(Bringing::UnderWay));
        model.end(&live[0], 5);
        assert_eq!(model.at(&live[0]), Some(Bringing::Done(5)));
        assert!(!model.begin(&live[0], &live));
        let again = [gateway(2)];
        assert!(model.begin(&again[0], &again));
        assert_eq!(model.at(&live[0]), None);
    }

    #[test]
    fn so_many_models_are_remembered_and_none_that_was_unloaded() {
        let models = Models::default();
        for id in 0..2 * MOST_MODELS as u64 {
            models.note(id, Some(id / 2), Parcel::of(ControlRequest::List));
        }
        assert_eq!(locked(&models.0).len(), MOST_MODELS);
        let last = 2 * MOST_MODELS as u64 - 1;
        assert!(models.find(0).is_none() && models.find(last).is_some());
        models.forget(last / 2);
        assert!(models.find(last).is_none());
    }
}

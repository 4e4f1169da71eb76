//! Robots that were loaded through here: gateways that come later, or whose daemon was started
//! again without them, get them when a request needs them there.

use crate::call::{Gateway, Nanos};
use crate::live::locked;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex};
use taut_ipc::content::Parcel;

/// Robots that are remembered at most; the first go first.
const MOST_ROBOTS: usize = 256;

/// How far a robot is at a gateway.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bringing {
    /// It is being brought.
    UnderWay,
    /// It was, or could not be, at this time.
    Done(Nanos),
}

/// A robot that was loaded.
#[derive(Debug)]
pub(super) struct Robot {
    /// Its id.
    pub(super) id: u64,
    /// The robot that it is made of, which has to be there before.
    pub(super) base: Option<u64>,
    /// What loads it, always with the same content.
    pub(super) parcel: Parcel,
    brought: Mutex<BTreeMap<Gateway, Bringing>>,
}

/// The robots.
#[derive(Debug, Default)]
pub(super) struct Robots(Mutex<VecDeque<Arc<Robot>>>);

impl Robots {
    /// A robot was loaded; it takes the place of one of its label.
    pub(super) fn note(&self, id: u64, base: Option<u64>, parcel: Parcel) -> Arc<Robot> {
        let robot = Arc::new(Robot {
            id,
            base,
            parcel,
            brought: Mutex::default(),
        });
        let mut robots = locked(&self.0);
        robots.retain(|robot| robot.id != id);
        if robots.len() >= MOST_ROBOTS {
            robots.pop_front();
        }
        robots.push_back(robot.clone());
        robot
    }

    /// A robot was unloaded, and with it goes what is made of it.
    pub(super) fn forget(&self, id: u64) {
        locked(&self.0).retain(|robot| robot.id != id && robot.base != Some(id));
    }

    pub(super) fn find(&self, id: u64) -> Option<Arc<Robot>> {
        let robots = locked(&self.0);
        robots.iter().find(|robot| robot.id == id).cloned()
    }
}

impl Robot {
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
    fn a_robot_is_brought_once_to_each_start_of_a_daemon() {
        let robots = Robots::default();
        let robot = robots.note(7, None, Parcel::of(ControlRequest::List));
        let live = [gateway(1)];
        assert!(robot.begin(&live[0], &live) && !robot.begin(&live[0], &live));
        assert_eq!(robot.at(&live[0]), Some(Bringing::UnderWay));
        robot.end(&live[0], 5);
        assert_eq!(robot.at(&live[0]), Some(Bringing::Done(5)));
        assert!(!robot.begin(&live[0], &live));
        let again = [gateway(2)];
        assert!(robot.begin(&again[0], &again));
        assert_eq!(robot.at(&live[0]), None);
    }

    #[test]
    fn so_many_robots_are_remembered_and_none_that_was_unloaded() {
        let robots = Robots::default();
        for id in 0..2 * MOST_ROBOTS as u64 {
            robots.note(id, Some(id / 2), Parcel::of(ControlRequest::List));
        }
        assert_eq!(locked(&robots.0).len(), MOST_ROBOTS);
        let last = 2 * MOST_ROBOTS as u64 - 1;
        assert!(robots.find(0).is_none() && robots.find(last).is_some());
        robots.forget(last / 2);
        assert!(robots.find(last).is_none());
    }
}

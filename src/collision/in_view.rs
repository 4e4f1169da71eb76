//! What of a robot a sensor sees: points on its own bodies, or on what it carries.

use super::body::Size;
use super::model::CollisionModel;
use crate::math::{Pose, Vec3};
use crate::robot::Kinematics;
use crate::solid::near::distance_up_to;
use crate::solid::{Solid, Transform};

/// The bodies of a robot that move or not, as a sensor sees them at one moment.
#[derive(Debug)]
pub struct InView<'m> {
    bodies: Vec<Seen<'m>>,
    padding: f64,
}

/// A body in the sensor's frame.
#[derive(Debug)]
struct Seen<'m> {
    solid: &'m Solid,
    place: Transform,
    center: Vec3,
    /// Of a ball around it, with the padding (m).
    reach: f64,
}

/// Where a point is beside the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beside {
    /// On a body.
    Robot,
    /// On none, but within the padding of one.
    Padding,
    /// Farther.
    World,
}

impl<'m> InView<'m> {
    /// A robot's links and what they carry, each exactly, as seen from a sensor that stands at
    /// `sensor` in the world; what is within `padding` (m) of them counts as theirs.
    pub fn new(
        model: &'m CollisionModel,
        kinematics: &Kinematics,
        sensor: &Pose,
        padding: f64,
    ) -> Self {
        let sensor = Transform::from(sensor);
        let carried = model.carried_bodies().iter();
        let own = carried.filter(|body| body.size == Size::OWN);
        let bodies = own.map(|body| {
            let place = sensor.inverse_of(&body.placed(kinematics));
            let root = body.solid.tree.balls()[0];
            Seen {
                solid: &body.solid,
                center: place.point(root.center),
                reach: root.radius + padding,
                place,
            }
        });
        Self {
            bodies: bodies.collect(),
            padding,
        }
    }

    /// Whether a point that the sensor sees is the robot's.
    pub fn beside(&self, point: Vec3) -> Beside {
        let near = self
            .bodies
            .iter()
            .filter(|body| body.center.distance_squared(point) <= body.reach * body.reach);
        let distances = near.filter_map(|body| {
            distance_up_to(body.solid, body.place.inverse_point(point), self.padding)
        });
        match distances.min_by(f64::total_cmp) {
            Some(distance) if distance <= 0.0 => Beside::Robot,
            Some(_) => Beside::Padding,
            None => Beside::World,
        }
    }
}

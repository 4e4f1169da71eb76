//! What a sensor sees of the robot itself: what lies on its bodies, or within a padding of them.

use std::collections::HashMap;
use std::sync::Arc;

use super::body::{BodyKind, Size};
use super::model::CollisionModel;
use crate::math::{Pose, Vec3};
use crate::robot::Kinematics;
use crate::shape::{PlacedShape, Shape};
use crate::solid::near::distance_up_to;
use crate::solid::{Solid, Transform, query};

/// The exact bodies of a robot and of what it carries, where it stands; without padding and scale.
pub struct OwnBodies {
    bodies: Vec<Placed>,
    /// Cubes by half their edge.
    probes: HashMap<u64, Solid>,
}

struct Placed {
    solid: Arc<Solid>,
    at: Transform,
    /// Ball around it, in the world.
    center: Vec3,
    radius: f64,
}

impl OwnBodies {
    /// Where the joints are as `kinematics` has it.
    pub fn of(model: &CollisionModel, kinematics: &Kinematics) -> Self {
        let own = model
            .bodies()
            .iter()
            .filter(|body| body.size == Size::OWN && body.kind != BodyKind::Obstacle);
        let placed = own.map(|body| {
            let at = body.placed(kinematics);
            let ball = body.solid.tree.ball(0);
            Placed {
                solid: body.solid.clone(),
                center: at.point(ball.center),
                radius: ball.radius,
                at,
            }
        });
        Self {
            bodies: placed.collect(),
            probes: HashMap::new(),
        }
    }

    /// The same bodies as seen from a frame that has this pose in the world.
    #[must_use]
    pub fn seen_from(mut self, pose: &Pose) -> Self {
        let frame = Transform::from(pose);
        for body in &mut self.bodies {
            body.at = frame.inverse_of(&body.at);
            body.center = frame.inverse_point(body.center);
        }
        self
    }

    /// Distance (m) of a point to the nearest body, 0 inside; none where that is more than `reach`
    /// (m).
    pub fn near(&self, point: Vec3, reach: f64) -> Option<f64> {
        let near = self.bodies.iter().filter(|body| {
            let within = body.radius + reach;
            body.center.distance_squared(point) <= within * within
        });
        let distances = near
            .filter_map(|body| distance_up_to(&body.solid, body.at.inverse_point(point), reach));
        distances.min_by(f64::total_cmp)
    }

    /// Distance (m) of a cube, half of its edge `half` (m, 0 for a point), to the nearest body, 0 where it
    /// touches one or is inside; none where that is more than `reach` (m). `pose` is the cube's in the world.
    pub fn within(&mut self, pose: &Pose, half: f64, reach: f64) -> Option<f64> {
        if half == 0.0 {
            return self.near(pose.translation, reach);
        }
        let probe = self
            .probes
            .entry(half.to_bits())
            .or_insert_with(|| cube(half));
        let at = Transform::from(pose);
        let size = half * 3.0_f64.sqrt();
        let near = self
            .bodies
            .iter()
            .filter(|body| body.center.distance(pose.translation) <= body.radius + size + reach);
        let distance = |body: &Placed| {
            let surfaces = query::between_surfaces(&body.solid, &body.at, probe, &at);
            match surfaces.distance <= reach {
                true => surfaces.distance.max(0.0),
                false if query::enclosed(&body.solid, &body.at, probe, &at).is_some() => 0.0,
                false => f64::INFINITY,
            }
        };
        let least = near.map(distance).fold(f64::INFINITY, f64::min);
        (least <= reach).then_some(least)
    }
}

fn cube(half: f64) -> Solid {
    let shape = Shape::Box {
        half_extents: Vec3::splat(half),
    };
    let pose = Pose::identity();
    Solid::new(&[PlacedShape { pose, shape }])
}

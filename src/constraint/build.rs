//! Constraints of a text, for a robot and a scene.

use std::f64::consts::{FRAC_PI_2, PI};

use super::joint;
use super::place::Place;
use super::watched::angle_seen_from;
use super::words::{
    ConstraintsFile, EulerFile, JointFile, Moment, OrientationFile, PositionFile, Reference,
    TiltFile,
};
use super::{ConstraintError, ConstraintKind, Cylinder, Held, JointValue, Region, Vector, Watched};
use crate::math::{Pose, Quat, Vec3};
use crate::robot::RobotModel;
use crate::scene::words::{Point, checked_pose};
use crate::scene::{Scene, SceneError};
use crate::shape::Shape;

/// Something besides clearance that a path must keep.
#[derive(Clone, Debug)]
pub struct Constraint {
    /// What it is about, which says what it is counted in.
    pub kind: ConstraintKind,
    /// As messages call it: the name in the text, where it has one, and what it is about.
    pub name: String,
    /// What must hold: each of it.
    pub held: Held,
}

/// The constraints of a text. What cannot be kept is refused, nothing is left out; but tolerances of half
/// a turn and more ask for nothing.
///
/// # Errors
/// A name that is none, a value that makes no sense, what cannot be proved.
pub fn constraints(
    text: &ConstraintsFile,
    robot: &RobotModel,
    scene: &Scene,
) -> Result<Vec<Constraint>, ConstraintError> {
    let builder = Builder { text, robot, scene };
    builder.check_visibility()?;
    let mut all = Vec::new();
    for joint in &text.joint_constraints {
        all.push(builder.joint(joint)?);
    }
    for position in &text.position_constraints {
        all.push(builder.position(position)?);
    }
    for orientation in &text.orientation_constraints {
        match orientation {
            OrientationFile::Tilt(tilt) => all.push(builder.tilt(tilt)?),
            OrientationFile::Euler(euler) => builder.euler(euler, &mut all)?,
        }
    }
    Ok(all)
}

struct Builder<'a> {
    text: &'a ConstraintsFile,
    robot: &'a RobotModel,
    scene: &'a Scene,
}

impl Builder<'_> {
    fn check_visibility(&self) -> Result<(), ConstraintError> {
        if self.text.visibility_constraints.is_empty() {
            return Ok(());
        }
        Err(ConstraintError::Unsupported {
            constraint: self.text.name.clone(),
            what: "visibility_constraints".into(),
            instead: "leave them out, or attach the sensor's cone as an object that nothing may touch",
        })
    }

    fn place(&self, name: &str, frame: &str) -> Result<Place, ConstraintError> {
        Place::named(self.robot, self.scene, name, frame)
    }

    fn carrier(&self, name: &str, link: &str) -> Result<Place, ConstraintError> {
        Place::watched(self.robot, self.scene, name, link)
    }

    fn joint(&self, joint: &JointFile) -> Result<Constraint, ConstraintError> {
        let name = self.text.name_of(&joint.joint_name);
        let [below, above] = [
            ("tolerance_below", joint.tolerance_below.0),
            ("tolerance_above", joint.tolerance_above.0),
        ];
        for (what, value) in [below, above] {
            check(&name, what, value, value >= 0.0, "it must not be negative")?;
        }
        let width = below.1 + above.1;
        check(
            &name,
            "tolerance_below + tolerance_above",
            width,
            width >= LEAST,
            NOT_ZERO,
        )?;
        let (value, kind) = self.joint_value(&name, joint)?;
        let narrow = !value.is_angle || (below.1 < PI && above.1 < PI);
        check(
            &name,
            "a tolerance of a continuous joint",
            width,
            narrow,
            "each must be below π",
        )?;
        Ok(Constraint {
            kind,
            name,
            held: Held {
                watched: Watched::joint(value),
                regions: vec![Region::Range {
                    lower: -below.1,
                    upper: above.1,
                }],
            },
        })
    }

    /// How far a joint is from the constraint's position.
    fn joint_value(
        &self,
        name: &str,
        joint: &JointFile,
    ) -> Result<(JointValue, ConstraintKind), ConstraintError> {
        let position = joint.position.0;
        check(name, "position", position, position.abs() <= FARTHEST, FAR)?;
        let (value, kind) = joint::named(self.robot, &joint.joint_name).ok_or_else(|| {
            ConstraintError::UnknownJoint {
                constraint: name.to_owned(),
                joint: joint.joint_name.clone(),
                valid: joint::names(self.robot),
            }
        })?;
        let value = JointValue {
            offset: value.offset - position,
            ..value
        };
        Ok((value, kind))
    }

    fn position(&self, position: &PositionFile) -> Result<Constraint, ConstraintError> {
        let name = self.text.name_of(&position.link_name);
        let carrier = self.carrier(&name, &position.link_name)?;
        let frame = self.place(&name, &position.header.frame_id)?;
        let point = carrier
            .pose
            .transform_point(Vec3::from_array(position.target_point_offset.0));
        check_near(&name, "target_point_offset", point)?;
        let vector = Vector::Point(point);
        Ok(Constraint {
            kind: ConstraintKind::Position,
            held: Held {
                watched: Watched::new(self.robot, vector, carrier.link, frame.link),
                regions: regions(&name, position, &frame.pose)?,
            },
            name,
        })
    }

    fn tilt(&self, tilt: &TiltFile) -> Result<Constraint, ConstraintError> {
        let name = self.text.name_of(&tilt.link_name);
        let angle = tilt.tolerance_rad.0;
        check(&name, "tolerance_rad", angle, angle >= LEAST, NOT_ZERO)?;
        let rule = "it may be π/2 at most: directions within a wider cone are not convex";
        check(&name, "tolerance_rad", angle, angle <= FRAC_PI_2, rule)?;
        let carrier = self.carrier(&name, &tilt.link_name)?;
        let frame = self.place(&name, &tilt.header.frame_id)?;
        let direction = carrier.pose.rotation * direction(&name, "axis", tilt.axis)?;
        let axis = frame.pose.rotation * direction_of(&name, tilt)?;
        let (seen_from, axis) = angle_seen_from(self.robot, carrier.link, frame.link, axis);
        let vector = Vector::Direction(direction);
        Ok(Constraint {
            kind: ConstraintKind::Orientation,
            name,
            held: Held {
                watched: Watched::new(self.robot, vector, carrier.link, seen_from),
                regions: vec![Region::Cone { axis, angle }],
            },
        })
    }

    /// MoveIt's: two directions are watched, for the first two angles and for the third.
    fn euler(&self, euler: &EulerFile, all: &mut Vec<Constraint>) -> Result<(), ConstraintError> {
        let name = self.text.name_of(&euler.link_name);
        check_parameterization(&name, euler)?;
        let [x, y, z] = tolerances(&name, euler)?;
        let carrier = self.carrier(&name, &euler.link_name)?;
        let frame = self.place(&name, &euler.header.frame_id)?;
        let reference = frame.pose.rotation * orientation(&name, euler)?;
        let mut add = |vector: Vec3, link, seen_from, region| {
            all.push(Constraint {
                kind: ConstraintKind::Orientation,
                name: name.clone(),
                held: Held {
                    watched: Watched::new(self.robot, Vector::Direction(vector), link, seen_from),
                    regions: vec![region],
                },
            });
        };
        if x < PI || y < FRAC_PI_2 {
            let region = Region::EulerXy {
                turned: reference,
                x,
                y,
            };
            add(
                carrier.pose.rotation * Vec3::Z,
                carrier.link,
                frame.link,
                region,
            );
        }
        if z < PI {
            let region = Region::EulerZ {
                turned: carrier.pose.rotation,
                z,
            };
            add(reference * Vec3::X, frame.link, carrier.link, region);
        }
        Ok(())
    }
}

/// Least tolerance (rad or m): some roundings wide.
const LEAST: f64 = 1e-11;
/// Farthest that a point may be from the origin of its frame, and a joint's position from 0 (m or rad):
/// as far as paths go.
const FARTHEST: f64 = 1e6;
const FAR: &str = "it may be 1e6 at most: so far out rounding is no longer small";
const NOT_ZERO: &str = "give what the path may stray, such as 0.001: nothing that moves keeps 0";

fn check(
    constraint: &str,
    what: &str,
    value: f64,
    is_right: bool,
    rule: &'static str,
) -> Result<(), ConstraintError> {
    if is_right {
        return Ok(());
    }
    Err(ConstraintError::BadValue {
        constraint: constraint.to_owned(),
        what: what.to_owned(),
        value: value.to_string(),
        rule,
    })
}

fn check_near(constraint: &str, what: &str, point: Vec3) -> Result<(), ConstraintError> {
    let far = point.length();
    check(constraint, what, far, far <= FARTHEST, FAR)
}

/// The regions of a position constraint, as the link of its frame, which is there, has them.
fn regions(
    name: &str,
    position: &PositionFile,
    frame: &Pose,
) -> Result<Vec<Region>, ConstraintError> {
    let volume = &position.constraint_region;
    if !volume.meshes.is_empty() {
        return Err(ConstraintError::Unsupported {
            constraint: name.to_owned(),
            what: "a mesh as a region".into(),
            instead: "use boxes, spheres or cylinders",
        });
    }
    let poses = volume.primitive_poses.len();
    let count = volume.primitives.len();
    let rule = "there must be one primitive at least, and a pose for each";
    check(
        name,
        "the number of primitive_poses",
        poses as f64,
        count == poses && count > 0,
        rule,
    )?;
    let both = volume
        .primitives
        .iter()
        .zip(&volume.primitive_poses);
    both.map(|(primitive, pose)| {
        let shape = primitive
            .build("constraint_region")
            .map_err(|error| no_region(name, &error))?;
        let pose = pose
            .build("constraint_region", "primitive")
            .map_err(|error| no_region(name, &error))?;
        checked_region(name, &shape, &(*frame * pose))
    })
    .collect()
}

/// A region that has an inside, and is where rounding is small.
fn checked_region(name: &str, shape: &Shape, pose: &Pose) -> Result<Region, ConstraintError> {
    check_near(name, "how far its region is", pose.translation)?;
    let region = region(name, shape, pose)?;
    let tolerance = region.tolerance();
    check(
        name,
        "its region's half width",
        tolerance,
        tolerance >= LEAST,
        NOT_ZERO,
    )?;
    Ok(region)
}

fn region(name: &str, shape: &Shape, pose: &Pose) -> Result<Region, ConstraintError> {
    let center = pose.translation;
    match *shape {
        Shape::Sphere { radius } => Ok(Region::Ball { center, radius }),
        Shape::Box { half_extents } => Ok(Region::Box {
            center,
            turned: pose.rotation,
            half: half_extents,
        }),
        Shape::Cylinder {
            radius,
            half_height,
        } => Ok(Region::Cylinder(Cylinder {
            center,
            axis: pose.rotation * Vec3::Z,
            radius,
            half_length: half_height,
        })),
        Shape::Capsule { .. } | Shape::Mesh(_) | Shape::Cloud(_) => {
            Err(ConstraintError::Unsupported {
                constraint: name.to_owned(),
                what: "such a shape as a region".into(),
                instead: "use boxes, spheres or cylinders",
            })
        }
    }
}

/// What a scene's reader says of a region.
fn no_region(constraint: &str, error: &SceneError) -> ConstraintError {
    ConstraintError::Region {
        constraint: constraint.to_owned(),
        what: error.to_string(),
    }
}

fn direction_of(name: &str, tilt: &TiltFile) -> Result<Vec3, ConstraintError> {
    match tilt.reference {
        Reference::Along(point) => direction(name, "reference", point),
        Reference::Of(Moment::Start) => Err(ConstraintError::BadValue {
            constraint: name.to_owned(),
            what: "reference".into(),
            value: "\"start\"".into(),
            rule: "only a path that is there has a start; give a direction",
        }),
    }
}

fn direction(name: &str, what: &str, point: Point) -> Result<Vec3, ConstraintError> {
    let point = Vec3::from_array(point.0);
    // Of any length, also where squares of numbers are none.
    let scaled = point / point.abs().max_element();
    scaled
        .try_normalize()
        .ok_or_else(|| ConstraintError::BadValue {
            constraint: name.to_owned(),
            what: what.to_owned(),
            value: format!("{:?}", point.to_array()),
            rule: "a direction must not be zero",
        })
}

fn check_parameterization(name: &str, euler: &EulerFile) -> Result<(), ConstraintError> {
    if euler.parameterization.is_euler() {
        return Ok(());
    }
    Err(ConstraintError::Unsupported {
        constraint: name.to_owned(),
        what: format!("the parameterization {}", euler.parameterization),
        instead: "use XYZ_EULER_ANGLES (0)",
    })
}

/// Tolerances about x, y and z (rad).
fn tolerances(name: &str, euler: &EulerFile) -> Result<[f64; 3], ConstraintError> {
    let words = [
        (
            "absolute_x_axis_tolerance",
            euler.absolute_x_axis_tolerance.0,
        ),
        (
            "absolute_y_axis_tolerance",
            euler.absolute_y_axis_tolerance.0,
        ),
        (
            "absolute_z_axis_tolerance",
            euler.absolute_z_axis_tolerance.0,
        ),
    ];
    for (axis, (what, value)) in words.into_iter().enumerate() {
        check(name, what, value, value >= LEAST, NOT_ZERO)?;
        let is_convex = axis == 1 || !(FRAC_PI_2..PI).contains(&value);
        let rule = "below π/2 it is convex and can be proved, from π on it asks for nothing";
        check(name, what, value, is_convex, rule)?;
    }
    Ok(words.map(|(_, value)| value))
}

fn orientation(name: &str, euler: &EulerFile) -> Result<Quat, ConstraintError> {
    let [x, y, z, w] = euler.orientation.to_array();
    let pose = checked_pose(name, "orientation", [0.0; 3], [x, y, z, w]);
    pose.map(|pose| pose.rotation)
        .map_err(|_| ConstraintError::BadValue {
            constraint: name.to_owned(),
            what: "orientation".into(),
            value: format!("x {x}, y {y}, z {z}, w {w}"),
            rule: "it must be a unit quaternion, to within 1e-3",
        })
}

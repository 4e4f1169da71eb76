//! Robots: what a model was made of.

use serde::{Deserialize, Serialize};
use taut::math::Vec3;
use taut::robot::{
    Group, GroupState, JointDescription, JointKind, LinkDescription, Mimic, Motor,
    RobotDescription, RobotModel, Semantics, VirtualJoint,
};

use super::apart::Find;
use super::plain::{PoseRecord, WarningRecord};
use super::shape::{ShapeRecord, records, restored};

/// A robot: what its model was made of, and what was found when it was put to use.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct RobotRecord {
    name: String,
    links: Vec<(String, Vec<ShapeRecord>)>,
    joints: Vec<JointRecord>,
    virtual_joint: Option<VirtualJointRecord>,
    variables: Option<Vec<String>>,
    semantics: Option<SemanticsRecord>,
    allowed_collisions: Vec<(String, String)>,
    warnings: Vec<WarningRecord>,
    /// All warnings of the model.
    found: Vec<WarningRecord>,
    /// Joint, greatest speed, greatest force or torque of each.
    motors: Vec<(String, Option<f64>, Option<f64>)>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct JointRecord {
    name: String,
    kind: KindRecord,
    parent: String,
    child: String,
    origin: PoseRecord,
    axis: [f64; 3],
    limits: Option<(f64, f64)>,
    soft_limits: Option<(f64, f64)>,
    /// The joint that it copies, factor and offset.
    mimic: Option<(String, f64, f64)>,
}

/// New kinds stand last: files name a kind by its number.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
enum KindRecord {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    Planar,
    Floating,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct VirtualJointRecord {
    name: String,
    kind: KindRecord,
    position_bounds: Vec<(f64, f64)>,
    parent_frame: String,
}

/// Joint name and its values.
type JointValues = Vec<(String, Vec<f64>)>;

#[derive(Clone, Debug, Serialize, Deserialize)]
struct SemanticsRecord {
    disabled_collisions: Vec<(String, String)>,
    /// Name and joints of each.
    groups: Vec<(String, Vec<String>)>,
    /// Name, group, and the values of joints.
    group_states: Vec<(String, String, JointValues)>,
    virtual_joint: Option<VirtualJointRecord>,
}

impl From<&RobotModel> for RobotRecord {
    fn from(robot: &RobotModel) -> Self {
        // Named one by one, here and below, so that nothing a description gains is forgotten.
        let RobotDescription {
            name,
            links,
            joints,
            virtual_joint,
            variables,
            semantics,
            allowed_collisions,
            motors,
            warnings,
        } = robot.description();
        let link = |link: &LinkDescription| (link.name.clone(), records(&link.collision));
        Self {
            name: name.clone(),
            links: links.iter().map(link).collect(),
            joints: joints.iter().map(JointRecord::from).collect(),
            virtual_joint: virtual_joint
                .as_ref()
                .map(VirtualJointRecord::from),
            variables: variables.clone(),
            semantics: semantics.as_ref().map(SemanticsRecord::from),
            allowed_collisions: allowed_collisions.clone(),
            warnings: WarningRecord::all(warnings),
            found: WarningRecord::all(robot.warnings()),
            motors: motors.iter().map(of_motor).collect(),
        }
    }
}

impl RobotRecord {
    /// The model, checked as when it was first made.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn restore(self, find: &mut dyn Find) -> Result<RobotModel, String> {
        let found = WarningRecord::restored(self.found.clone());
        let model = RobotModel::new(self.description(find)?).map_err(|error| error.to_string())?;
        let known = model.warnings().to_vec();
        let more = found
            .into_iter()
            .filter(|found| !known.contains(found));
        Ok(model.with_warnings(more.collect()))
    }

    fn description(self, find: &mut dyn Find) -> Result<RobotDescription, String> {
        let links = self.links.into_iter();
        let links = links.map(|(name, shapes)| link(name, &shapes, find));
        Ok(RobotDescription {
            name: self.name,
            links: links.collect::<Result<_, String>>()?,
            joints: self
                .joints
                .into_iter()
                .map(JointRecord::restore)
                .collect(),
            virtual_joint: self
                .virtual_joint
                .map(VirtualJointRecord::restore),
            variables: self.variables,
            semantics: self.semantics.map(SemanticsRecord::restore),
            allowed_collisions: self.allowed_collisions,
            motors: self.motors.into_iter().map(motor).collect(),
            warnings: WarningRecord::restored(self.warnings),
        })
    }
}

fn of_motor(motor: &Motor) -> (String, Option<f64>, Option<f64>) {
    let Motor {
        joint,
        velocity,
        effort,
    } = motor;
    (joint.clone(), *velocity, *effort)
}

fn motor((joint, velocity, effort): (String, Option<f64>, Option<f64>)) -> Motor {
    Motor {
        joint,
        velocity,
        effort,
    }
}

fn link(
    name: String,
    shapes: &[ShapeRecord],
    find: &mut dyn Find,
) -> Result<LinkDescription, String> {
    let collision = restored(shapes, find)?;
    Ok(LinkDescription { name, collision })
}

impl From<&JointDescription> for JointRecord {
    fn from(joint: &JointDescription) -> Self {
        let JointDescription {
            name,
            kind,
            parent,
            child,
            origin,
            axis,
            limits,
            soft_limits,
            mimic,
        } = joint;
        let mimic = mimic.as_ref().map(|mimic| {
            let Mimic {
                joint,
                multiplier,
                offset,
            } = mimic;
            (joint.clone(), *multiplier, *offset)
        });
        Self {
            name: name.clone(),
            kind: (*kind).into(),
            parent: parent.clone(),
            child: child.clone(),
            origin: (*origin).into(),
            axis: axis.to_array(),
            limits: *limits,
            soft_limits: *soft_limits,
            mimic,
        }
    }
}

impl JointRecord {
    fn restore(self) -> JointDescription {
        let mimic = |(joint, multiplier, offset)| Mimic {
            joint,
            multiplier,
            offset,
        };
        JointDescription {
            name: self.name,
            kind: self.kind.into(),
            parent: self.parent,
            child: self.child,
            origin: self.origin.into(),
            axis: Vec3::from_array(self.axis),
            limits: self.limits,
            soft_limits: self.soft_limits,
            mimic: self.mimic.map(mimic),
        }
    }
}

impl From<&VirtualJoint> for VirtualJointRecord {
    fn from(joint: &VirtualJoint) -> Self {
        let VirtualJoint {
            name,
            kind,
            position_bounds,
            parent_frame,
        } = joint.clone();
        Self {
            name,
            kind: kind.into(),
            position_bounds,
            parent_frame,
        }
    }
}

impl VirtualJointRecord {
    fn restore(self) -> VirtualJoint {
        VirtualJoint {
            name: self.name,
            kind: self.kind.into(),
            position_bounds: self.position_bounds,
            parent_frame: self.parent_frame,
        }
    }
}

impl From<&Semantics> for SemanticsRecord {
    fn from(semantics: &Semantics) -> Self {
        let Semantics {
            disabled_collisions,
            groups,
            group_states,
            virtual_joint,
        } = semantics.clone();
        let group = |Group { name, joints }| (name, joints);
        let state = |state: GroupState| {
            let GroupState {
                name,
                group,
                values,
            } = state;
            (name, group, values)
        };
        Self {
            disabled_collisions,
            groups: groups.into_iter().map(group).collect(),
            group_states: group_states.into_iter().map(state).collect(),
            virtual_joint: virtual_joint
                .as_ref()
                .map(VirtualJointRecord::from),
        }
    }
}

impl SemanticsRecord {
    fn restore(self) -> Semantics {
        let group = |(name, joints)| Group { name, joints };
        let state = |(name, group, values)| GroupState {
            name,
            group,
            values,
        };
        Semantics {
            disabled_collisions: self.disabled_collisions,
            groups: self.groups.into_iter().map(group).collect(),
            group_states: self
                .group_states
                .into_iter()
                .map(state)
                .collect(),
            virtual_joint: self
                .virtual_joint
                .map(VirtualJointRecord::restore),
        }
    }
}

impl From<JointKind> for KindRecord {
    fn from(kind: JointKind) -> Self {
        match kind {
            JointKind::Fixed => Self::Fixed,
            JointKind::Revolute => Self::Revolute,
            JointKind::Continuous => Self::Continuous,
            JointKind::Prismatic => Self::Prismatic,
            JointKind::Planar => Self::Planar,
            JointKind::Floating => Self::Floating,
        }
    }
}

impl From<KindRecord> for JointKind {
    fn from(kind: KindRecord) -> Self {
        match kind {
            KindRecord::Fixed => Self::Fixed,
            KindRecord::Revolute => Self::Revolute,
            KindRecord::Continuous => Self::Continuous,
            KindRecord::Prismatic => Self::Prismatic,
            KindRecord::Planar => Self::Planar,
            KindRecord::Floating => Self::Floating,
        }
    }
}

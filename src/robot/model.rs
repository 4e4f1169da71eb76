//! The immutable robot: a tree of joints in topological order, checked once when it is built.

use std::collections::{BTreeSet, HashMap};

use super::configuration::{Component, ConfigurationSpace};
use super::description::{GroupState, JointDescription, RobotDescription};
use super::joint::{Drive, Joint, JointKind};
use super::variable::{Bounds, HeldVariable, Variable};
use crate::hash::ContentHasher;
use crate::math::{Pose, Vec3};
use crate::shape::PlacedShape;
use crate::warning::Warning;

/// A robot. Joint `i` carries link `i`; a joint's parent link comes before it.
#[derive(Clone, Debug)]
pub struct RobotModel {
    // Kept: whoever keeps the robot keeps what it was made of, and has it checked again.
    description: RobotDescription,
    name: String,
    links: Vec<Link>,
    joints: Vec<Joint>,
    space: ConfigurationSpace,
    variables: Vec<Variable>,
    held: Vec<HeldVariable>,
    groups: Vec<(String, Vec<bool>)>,
    group_states: Vec<GroupState>,
    allowed: BTreeSet<(usize, usize)>,
    warnings: Vec<Warning>,
    hash: u64,
    layout_hash: u64,
}

/// A link and its collision shapes in the link's frame.
#[derive(Clone, Debug)]
pub struct Link {
    /// Name.
    pub name: String,
    /// Collision shapes; often none.
    pub shapes: Vec<PlacedShape>,
}

/// Why a robot was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RobotError {
    /// Two links, joints or variables of one name.
    #[error("{kind} {name:?} is defined twice; names must be unique")]
    Duplicate {
        /// Link, joint or variable.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A name that nothing carries.
    #[error("{what} names {kind} {name:?}, which does not exist; known: {known}")]
    Unknown {
        /// Who names it.
        what: String,
        /// Link, joint or variable.
        kind: &'static str,
        /// The name.
        name: String,
        /// The valid names.
        known: String,
    },
    /// The joints do not form one tree.
    #[error("the joints do not form a tree: {0}")]
    NotATree(String),
    /// A number that is no number, or out of its range.
    #[error("{what} is {value}; {rule}")]
    BadValue {
        /// What.
        what: String,
        /// Its value.
        value: String,
        /// What it must be.
        rule: &'static str,
    },
    /// A text that is not the format it should be, with line and column where known.
    #[error("{0}")]
    Syntax(String),
    /// A collision mesh.
    #[error("link {link}: {source}")]
    Mesh {
        /// Link that wants the mesh.
        link: String,
        /// What is wrong.
        source: crate::shape::MeshError,
    },
}

impl RobotModel {
    /// Checks a description and orders it.
    ///
    /// # Errors
    /// A duplicate or unknown name, joints that form no tree, a number that is not finite or out of
    /// its range: the message names the place, the value and the valid ones.
    pub fn new(mut description: RobotDescription) -> Result<Self, RobotError> {
        let kept = description.clone();
        let mut warnings = description.warnings.clone();
        warnings.extend(free_of_fixed_leaders(&mut description));
        let order = topological_order(&description)?;
        let joint_index = order.joint_index(&description);
        let columns = Columns::assign(&description, &order, &joint_index, &mut warnings)?;

        let mut links = Vec::with_capacity(order.0.len());
        let mut joints = Vec::with_capacity(order.0.len());
        for (index, &(link, joint)) in order.0.iter().enumerate() {
            let source = &description.links[link];
            links.push(Link {
                name: source.name.clone(),
                shapes: source.collision.clone(),
            });
            joints.push(match joint {
                None => root_joint(&description, columns.drives[index])?,
                Some(j) => {
                    let joint = &description.joints[j];
                    let parent = order.link_position(&description, &joint.parent);
                    checked_joint(joint, parent, columns.drives[index])?
                }
            });
        }
        let link_index: HashMap<&str, usize> = links
            .iter()
            .enumerate()
            .map(|(i, l)| (l.name.as_str(), i))
            .collect();
        let allowed = allowed_pairs(&description, &joints, &link_index, &mut warnings)?;
        let (groups, group_states) =
            groups(&description, &joints, columns.space.nv(), &joint_index)?;
        let mut model = Self {
            description: kept,
            name: description.name,
            links,
            joints,
            space: columns.space,
            variables: columns.variables,
            held: columns.held,
            groups,
            group_states,
            allowed,
            warnings,
            hash: 0,
            layout_hash: 0,
        };
        model.hash = model.content_hash();
        model.layout_hash = model.hash_of_layout();
        Ok(model)
    }

    /// What it was made of: a model made of it again is the same, but for warnings found where it
    /// was put to use.
    pub fn description(&self) -> &RobotDescription {
        &self.description
    }
    /// Label of the robot.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// Links, root first, parents before children.
    pub fn links(&self) -> &[Link] {
        &self.links
    }
    /// Joints; joint `i` carries link `i`.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }
    /// The space that a row of a path lives in.
    pub fn space(&self) -> &ConfigurationSpace {
        &self.space
    }
    /// Columns of a path.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }
    /// Variables of the joints that hold still.
    pub fn held(&self) -> &[HeldVariable] {
        &self.held
    }
    /// Groups: name, and which velocity coordinates belong to it.
    pub fn groups(&self) -> &[(String, Vec<bool>)] {
        &self.groups
    }
    /// Named configurations of groups.
    pub fn group_states(&self) -> &[GroupState] {
        &self.group_states
    }
    /// Whether the pair of links is left out of every check (SRDF, `allowed_collisions`, or joined
    /// by one joint where there is no SRDF).
    pub fn is_allowed(&self, a: usize, b: usize) -> bool {
        self.allowed.contains(&(a.min(b), a.max(b)))
    }
    /// What is odd about the files, a line each.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }
    /// The same robot with more that is odd about it, found where it was put to use.
    pub fn with_warnings(mut self, more: Vec<Warning>) -> Self {
        self.warnings.extend(more);
        self
    }
    /// Content hash: equal models have equal hashes whatever their label.
    pub fn hash(&self) -> u64 {
        self.hash
    }
    /// Hash of the variable names in order.
    pub fn layout_hash(&self) -> u64 {
        self.layout_hash
    }
    /// Index of a link by name.
    pub fn link_index(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    fn hash_of_layout(&self) -> u64 {
        let mut hasher = ContentHasher::default();
        for variable in &self.variables {
            hasher.text(&variable.name);
        }
        hasher.finish()
    }

    fn content_hash(&self) -> u64 {
        let mut hasher = ContentHasher::default();
        for (link, joint) in self.links.iter().zip(&self.joints) {
            hasher.text(&link.name);
            for shape in &link.shapes {
                hasher.shape(shape);
            }
            hasher.text(&joint.name);
            hasher.text(&format!(
                "{:?}{:?}{:?}",
                joint.kind, joint.parent, joint.drive
            ));
            hasher.pose(&joint.origin).floats(&joint.axis.to_array());
        }
        for variable in &self.variables {
            hasher
                .text(&variable.name)
                .floats(&[variable.lower, variable.upper]);
            if variable.has_soft_limits() {
                hasher.floats(&[variable.hard_lower, variable.hard_upper]);
            }
        }
        hasher.text(&format!(
            "{:?}{:?}{:?}",
            self.allowed, self.groups, self.group_states
        ));
        hasher.finish()
    }
}

/// (link, joint that carries it) by index in the description, root first.
struct Order(Vec<(usize, Option<usize>)>);

impl Order {
    /// Position of the link called `name` in tree order.
    fn link_position(&self, description: &RobotDescription, name: &str) -> usize {
        let position = self
            .0
            .iter()
            .position(|&(link, _)| description.links[link].name == name);
        position.expect("topological_order has checked every link name")
    }

    /// Joint name to position in tree order; the virtual joint is at 0.
    fn joint_index(&self, description: &RobotDescription) -> HashMap<String, usize> {
        let named = |(position, &(_, joint)): (usize, &(usize, Option<usize>))| match joint {
            Some(j) => Some((description.joints[j].name.clone(), position)),
            None => description
                .virtual_joint
                .as_ref()
                .map(|v| (v.name.clone(), position)),
        };
        self.0.iter().enumerate().filter_map(named).collect()
    }
}

/// Drops the mimics of fixed joints, which have no value to follow: MoveIt takes such joints for
/// independent.
fn free_of_fixed_leaders(description: &mut RobotDescription) -> Vec<Warning> {
    let fixed = |joint: &&JointDescription| joint.kind == JointKind::Fixed;
    let fixed: BTreeSet<String> = description
        .joints
        .iter()
        .filter(fixed)
        .map(|joint| joint.name.clone())
        .collect();
    let mut warnings = Vec::new();
    for joint in description
        .joints
        .iter_mut()
        .filter(|joint| joint.kind != JointKind::Fixed)
    {
        if let Some(mimic) = joint.mimic.take_if(|mimic| fixed.contains(&mimic.joint)) {
            let text = format!(
                "mimics {:?}, which is fixed; it moves independently",
                mimic.joint
            );
            warnings.push(Warning::uncovered(format!("joint {:?} {text}", joint.name)));
        }
    }
    warnings
}

fn unique<'a>(kind: &'static str, names: impl Iterator<Item = &'a str>) -> Result<(), RobotError> {
    let mut seen = BTreeSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(RobotError::Duplicate {
                kind,
                name: name.to_owned(),
            });
        }
    }
    Ok(())
}

/// Comma-separated names for a message, cut where there are many.
fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<_> = names.collect();
    match names.len() {
        0 => "none".to_owned(),
        1..=40 => names.join(", "),
        n => format!("{}, … ({n} in all)", names[..40].join(", ")),
    }
}

fn topological_order(description: &RobotDescription) -> Result<Order, RobotError> {
    let links = &description.links;
    let joints = &description.joints;
    let virtual_name = description.virtual_joint.iter().map(|v| v.name.as_str());
    unique("link", links.iter().map(|l| l.name.as_str()))?;
    unique(
        "joint",
        joints.iter().map(|j| j.name.as_str()).chain(virtual_name),
    )?;
    let index: HashMap<&str, usize> = links
        .iter()
        .enumerate()
        .map(|(i, l)| (l.name.as_str(), i))
        .collect();
    let mut carried_by: Vec<Option<usize>> = vec![None; links.len()];
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); links.len()];
    for (j, joint) in joints.iter().enumerate() {
        let known = |end: &str, name: &str| {
            index.get(name).copied().ok_or_else(|| RobotError::Unknown {
                what: format!("joint {:?} ({end})", joint.name),
                kind: "link",
                name: name.to_owned(),
                known: list(links.iter().map(|l| l.name.as_str())),
            })
        };
        let parent = known("parent", &joint.parent)?;
        let child = known("child", &joint.child)?;
        if let Some(other) = carried_by[child] {
            let first = &joints[other].name;
            let second = &joint.name;
            let text = format!(
                "link {:?} is the child of two joints, {first:?} and {second:?}",
                joint.child
            );
            return Err(RobotError::NotATree(text));
        }
        carried_by[child] = Some(j);
        children[parent].push(j);
    }
    let roots: Vec<usize> = (0..links.len())
        .filter(|&l| carried_by[l].is_none())
        .collect();
    let &[root] = roots.as_slice() else {
        let text = match roots.as_slice() {
            [] if links.is_empty() => "there is no link".to_owned(),
            [] => "every link is some joint's child, so the joints form a loop".to_owned(),
            several => {
                format!(
                    "{} links are no joint's child: {}",
                    several.len(),
                    list(several.iter().map(|&l| links[l].name.as_str()))
                )
            }
        };
        return Err(RobotError::NotATree(text));
    };
    // Depth first, so that a chain's links lie side by side.
    let mut order = Vec::with_capacity(links.len());
    let mut stack = vec![(root, None)];
    while let Some((link, joint)) = stack.pop() {
        order.push((link, joint));
        for &j in children[link].iter().rev() {
            stack.push((index[joints[j].child.as_str()], Some(j)));
        }
    }
    if order.len() < links.len() {
        let reached: BTreeSet<usize> = order.iter().map(|&(link, _)| link).collect();
        let lost = (0..links.len())
            .filter(|l| !reached.contains(l))
            .map(|l| links[l].name.as_str());
        return Err(RobotError::NotATree(format!(
            "a loop that the root does not reach: {}",
            list(lost)
        )));
    }
    Ok(Order(order))
}

/// Which joint gets which columns.
struct Columns {
    drives: Vec<Drive>,
    space: ConfigurationSpace,
    variables: Vec<Variable>,
    held: Vec<HeldVariable>,
}

impl Columns {
    fn assign(
        description: &RobotDescription,
        order: &Order,
        joint_index: &HashMap<String, usize>,
        warnings: &mut Vec<Warning>,
    ) -> Result<Self, RobotError> {
        let source = |position: usize| -> JointSource<'_> {
            match order.0[position].1 {
                Some(j) => JointSource::of(&description.joints[j]),
                None => JointSource::root(description),
            }
        };
        let names: Vec<Vec<String>> = (0..order.0.len())
            .map(|i| source(i).kind.variable_names(source(i).name))
            .collect();
        let all = || list(names.iter().flatten().map(String::as_str));
        let listed = match &description.variables {
            Some(listed) => listed.clone(),
            None => (0..names.len())
                .filter(|&i| source(i).mimic.is_none())
                .flat_map(|i| names[i].clone())
                .collect(),
        };
        unique("variable", listed.iter().map(String::as_str))?;

        let mut drives = vec![Drive::Fixed; order.0.len()];
        let mut components = Vec::new();
        let mut variables = Vec::new();
        let mut q = 0;
        let mut v = 0;
        while q < listed.len() {
            let Some(position) = names.iter().position(|n| n.first() == Some(&listed[q])) else {
                let known = all();
                let what = "the list of variables".to_owned();
                return Err(RobotError::Unknown {
                    what,
                    kind: "variable",
                    name: listed[q].clone(),
                    known,
                });
            };
            let JointSource {
                name,
                kind,
                limits,
                mimic,
            } = source(position);
            let own = &names[position];
            if listed[q..].len() < own.len() || listed[q..q + own.len()] != own[..] {
                return Err(RobotError::BadValue {
                    what: format!("the list of variables at {:?}", listed[q]),
                    value: "incomplete or out of order".to_owned(),
                    rule: "a planar or floating joint's variables stand together, in MoveIt's order",
                });
            }
            if mimic.is_some() {
                let text =
                    format!("mimic joint {name:?} is listed as a variable and moves independently");
                warnings.push(Warning::uncovered(text));
            }
            drives[position] = Drive::Variable { q, v };
            push_components(kind, q, v, &mut components);
            for (i, name) in own.iter().enumerate() {
                let Bounds {
                    lower,
                    upper,
                    hard_lower,
                    hard_upper,
                } = limits.get(i).copied().unwrap_or(Bounds::NONE);
                if lower.is_nan() || upper.is_nan() || lower > upper {
                    return Err(RobotError::BadValue {
                        what: format!("the limits of {name:?}"),
                        value: format!("[{lower}, {upper}]"),
                        rule: "they must be numbers, lower ≤ upper",
                    });
                }
                variables.push(Variable {
                    name: name.clone(),
                    lower,
                    upper,
                    hard_lower,
                    hard_upper,
                });
            }
            q += kind.nq();
            v += kind.nv();
        }
        let mut held: Vec<HeldVariable> = Vec::new();
        let is_listed: Vec<bool> = drives
            .iter()
            .map(|d| matches!(d, Drive::Variable { .. }))
            .collect();
        for position in 0..drives.len() {
            let JointSource {
                name,
                kind,
                mimic,
                limits,
            } = source(position);
            if is_listed[position] || kind == JointKind::Fixed {
                if kind == JointKind::Fixed && mimic.is_some() {
                    warnings.push(Warning::cosmetic(
                        "fixed mimic",
                        format!("mimic on fixed joint {name:?} is ignored"),
                    ));
                }
                continue;
            }
            if let Some((master, multiplier, offset)) =
                resolve_mimic(description, joint_index, position, order, &is_listed)?
            {
                drives[position] = Drive::Mimic {
                    master,
                    multiplier,
                    offset,
                };
                if let Some(warning) = as_real_line(
                    &mut components,
                    drives[master],
                    source(master),
                    kind,
                    multiplier,
                ) {
                    let text = format!("{warning}, since {name:?} follows it");
                    warnings.push(Warning::cosmetic("whole turns", text));
                }
                continue;
            }
            drives[position] = Drive::Held { first: held.len() };
            for (i, variable) in names[position].iter().enumerate() {
                // A floating joint at rest is the unit quaternion: its last number is 1.
                let default = if kind == JointKind::Floating && i == 6 {
                    1.0
                } else {
                    0.0
                };
                let Bounds {
                    lower,
                    upper,
                    hard_lower,
                    hard_upper,
                } = limits.get(i).copied().unwrap_or(Bounds::NONE);
                held.push(HeldVariable {
                    name: variable.clone(),
                    default,
                    lower,
                    upper,
                    hard_lower,
                    hard_upper,
                });
            }
        }
        Ok(Self {
            drives,
            space: ConfigurationSpace::new(components),
            variables,
            held,
        })
    }
}

/// What the columns need to know of a joint, virtual or not.
struct JointSource<'a> {
    name: &'a str,
    kind: JointKind,
    limits: Vec<Bounds>,
    mimic: Option<&'a super::description::Mimic>,
}

impl<'a> JointSource<'a> {
    fn of(joint: &'a JointDescription) -> Self {
        let limits = match joint.kind {
            JointKind::Revolute | JointKind::Prismatic => Bounds::of(joint).into_iter().collect(),
            _ => Vec::new(),
        };
        Self {
            name: &joint.name,
            kind: joint.kind,
            limits,
            mimic: joint.mimic.as_ref(),
        }
    }

    fn root(description: &'a RobotDescription) -> Self {
        match &description.virtual_joint {
            Some(v) => {
                let limits = v
                    .position_bounds
                    .iter()
                    .copied()
                    .map(Bounds::hard)
                    .collect();
                Self {
                    name: &v.name,
                    kind: v.kind,
                    limits,
                    mimic: None,
                }
            }
            None => Self {
                name: "world",
                kind: JointKind::Fixed,
                limits: Vec::new(),
                mimic: None,
            },
        }
    }
}

fn push_components(kind: JointKind, q: usize, v: usize, components: &mut Vec<Component>) {
    match kind {
        JointKind::Fixed => {}
        JointKind::Revolute | JointKind::Prismatic => components.push(Component::Line { q, v }),
        JointKind::Continuous => components.push(Component::Circle { q, v }),
        JointKind::Planar => {
            components.extend([
                Component::Line { q, v },
                Component::Line { q: q + 1, v: v + 1 },
            ]);
            components.push(Component::Circle { q: q + 2, v: v + 2 });
        }
        JointKind::Floating => {
            components.extend((0..3).map(|i| Component::Line { q: q + i, v: v + i }));
            components.push(Component::Rotation { q: q + 3, v: v + 3 });
        }
    }
}

/// Takes a continuous joint's numbers as they stand where a joint that follows it is not the same
/// after a whole turn: the leader then is no angle on the circle but a real line. Says so once.
fn as_real_line(
    components: &mut [Component],
    leader: Drive,
    JointSource { name, .. }: JointSource<'_>,
    follower: JointKind,
    multiplier: f64,
) -> Option<String> {
    let Drive::Variable { q, v } = leader else {
        return None;
    };
    let is_periodic = match follower {
        JointKind::Revolute | JointKind::Continuous => multiplier.fract() == 0.0,
        JointKind::Prismatic => multiplier == 0.0,
        JointKind::Fixed | JointKind::Planar | JointKind::Floating => true,
    };
    let circle = components
        .iter_mut()
        .find(|component| **component == Component::Circle { q, v })?;
    if is_periodic {
        return None;
    }
    *circle = Component::Line { q, v };
    Some(format!("whole turns of continuous joint {name:?} count"))
}

/// Follows a mimic to the joint that is a variable or held, composing multipliers and offsets.
fn resolve_mimic(
    description: &RobotDescription,
    joint_index: &HashMap<String, usize>,
    position: usize,
    order: &Order,
    is_listed: &[bool],
) -> Result<Option<(usize, f64, f64)>, RobotError> {
    let mut at = position;
    let mut multiplier = 1.0;
    let mut offset = 0.0;
    let single = |kind: JointKind| kind.nq() == 1;
    for _ in 0..=order.0.len() {
        let Some(joint) = order.0[at].1.map(|j| &description.joints[j]) else {
            break;
        };
        let Some(mimic) = joint.mimic.as_ref().filter(|_| !is_listed[at]) else {
            break;
        };
        let master = joint_index
            .get(&mimic.joint)
            .copied()
            .ok_or_else(|| RobotError::Unknown {
                what: format!("the mimic of joint {:?}", joint.name),
                kind: "joint",
                name: mimic.joint.clone(),
                known: list(description.joints.iter().map(|j| j.name.as_str())),
            })?;
        let master_kind = order.0[master]
            .1
            .map_or(JointKind::Fixed, |j| description.joints[j].kind);
        if !mimic.multiplier.is_finite()
            || !mimic.offset.is_finite()
            || !single(joint.kind)
            || !single(master_kind)
        {
            return Err(RobotError::BadValue {
                what: format!("the mimic of joint {:?}", joint.name),
                value: format!(
                    "{} · {:?} + {}",
                    mimic.multiplier, mimic.joint, mimic.offset
                ),
                rule: "both joints have one variable, multiplier and offset are finite",
            });
        }
        offset += multiplier * mimic.offset;
        multiplier *= mimic.multiplier;
        at = master;
        if at == position {
            return Err(RobotError::NotATree(format!(
                "joint {:?} mimics itself",
                joint.name
            )));
        }
    }
    Ok((at != position).then_some((at, multiplier, offset)))
}

fn root_joint(description: &RobotDescription, drive: Drive) -> Result<Joint, RobotError> {
    let (name, kind) = match &description.virtual_joint {
        None => ("world".to_owned(), JointKind::Fixed),
        Some(v) => (v.name.clone(), v.kind),
    };
    if !matches!(
        kind,
        JointKind::Fixed | JointKind::Planar | JointKind::Floating
    ) {
        return Err(RobotError::BadValue {
            what: format!("the type of virtual joint {name:?}"),
            value: format!("{kind:?}").to_lowercase(),
            rule: "it must be fixed, planar or floating",
        });
    }
    Ok(Joint {
        name,
        kind,
        parent: None,
        origin: Pose::identity(),
        axis: Vec3::Z,
        drive,
    })
}

fn checked_joint(
    joint: &JointDescription,
    parent: usize,
    drive: Drive,
) -> Result<Joint, RobotError> {
    let bad = |what: &str, value: String, rule| RobotError::BadValue {
        what: format!("the {what} of joint {:?}", joint.name),
        value,
        rule,
    };
    if !joint.origin.is_finite() {
        return Err(bad(
            "origin",
            format!("{:?}", joint.origin),
            "it must be finite",
        ));
    }
    let axis = match joint.kind {
        JointKind::Revolute | JointKind::Continuous | JointKind::Prismatic => {
            let length = joint.axis.length();
            if !length.is_finite() || length < 1e-9 {
                return Err(bad(
                    "axis",
                    format!("{}", joint.axis),
                    "it must be finite and not zero",
                ));
            }
            joint.axis / length
        }
        _ => Vec3::Z,
    };
    if matches!(joint.kind, JointKind::Revolute | JointKind::Prismatic) && joint.limits.is_none() {
        let rule = "a revolute or prismatic joint needs <limit lower= upper=>; use continuous for a joint without";
        return Err(bad("limits", "missing".to_owned(), rule));
    }
    if let Some((lower, upper)) = joint.limits {
        let unlimited = !matches!(joint.kind, JointKind::Revolute | JointKind::Prismatic);
        if !unlimited && (lower.is_nan() || upper.is_nan() || lower > upper) {
            return Err(bad(
                "limits",
                format!("[{lower}, {upper}]"),
                "they must be numbers, lower ≤ upper",
            ));
        }
    }
    let name = joint.name.clone();
    Ok(Joint {
        name,
        kind: joint.kind,
        parent: Some(parent),
        origin: joint.origin,
        axis,
        drive,
    })
}

fn allowed_pairs(
    description: &RobotDescription,
    joints: &[Joint],
    link_index: &HashMap<&str, usize>,
    warnings: &mut Vec<Warning>,
) -> Result<BTreeSet<(usize, usize)>, RobotError> {
    let mut allowed = BTreeSet::new();
    let mut insert = |a: usize, b: usize| allowed.insert((a.min(b), a.max(b)));
    match &description.semantics {
        Some(semantics) => {
            for (a, b) in &semantics.disabled_collisions {
                // SRDFs are shared between variants of a robot, so unknown links are common there.
                match (link_index.get(a.as_str()), link_index.get(b.as_str())) {
                    (Some(&a), Some(&b)) => {
                        insert(a, b);
                    }
                    _ => {
                        let text =
                            format!("the SRDF disables {a} × {b}, not both links of this robot");
                        warnings.push(Warning::cosmetic("SRDF pair", text));
                    }
                }
            }
        }
        None => {
            for (child, joint) in joints.iter().enumerate() {
                if let Some(parent) = joint.parent {
                    insert(parent, child);
                }
            }
            if joints.len() > 1 {
                let text = "no SRDF: links joined by one joint are not checked against each other";
                warnings.push(Warning::uncovered(text));
            }
        }
    }
    for (a, b) in &description.allowed_collisions {
        let index = |name: &String| {
            link_index
                .get(name.as_str())
                .copied()
                .ok_or_else(|| RobotError::Unknown {
                    what: format!("the allowed pair {a} × {b}"),
                    kind: "link",
                    name: name.clone(),
                    known: list(description.links.iter().map(|l| l.name.as_str())),
                })
        };
        insert(index(a)?, index(b)?);
    }
    Ok(allowed)
}

type Groups = (Vec<(String, Vec<bool>)>, Vec<GroupState>);

fn groups(
    description: &RobotDescription,
    joints: &[Joint],
    nv: usize,
    joint_index: &HashMap<String, usize>,
) -> Result<Groups, RobotError> {
    let Some(semantics) = &description.semantics else {
        return Ok(Groups::default());
    };
    let mut groups = Vec::new();
    for group in &semantics.groups {
        let mut mask = vec![false; nv];
        for joint in group
            .joints
            .iter()
            .filter_map(|name| joint_index.get(name))
            .map(|&i| &joints[i])
        {
            if let Drive::Variable { v, .. } = joint.drive {
                mask[v..v + joint.kind.nv()].fill(true);
            }
        }
        groups.push((group.name.clone(), mask));
    }
    Ok((groups, semantics.group_states.clone()))
}

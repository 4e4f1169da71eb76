//! Which joint gets which columns of a path, and which stand still.

use std::collections::HashMap;

use super::error::{RobotError, list, unique};
use super::mimic::{Followed, as_real_line, follow};
use super::source::{JointSource, push_components};
use super::tree::Order;
use crate::robot::configuration::{Component, ConfigurationSpace};
use crate::robot::description::RobotDescription;
use crate::robot::joint::{Drive, JointKind};
use crate::robot::variable::{Bounds, HeldVariable, Variable};
use crate::warning::Warning;

/// Where the value of each joint comes from, and what the variables are.
pub(super) struct Columns {
    /// For each joint, in tree order.
    pub drives: Vec<Drive>,
    /// The space that a row lives in.
    pub space: ConfigurationSpace,
    /// Columns of a path.
    pub variables: Vec<Variable>,
    /// Variables that are no column.
    pub held: Vec<HeldVariable>,
}

impl Columns {
    /// Gives each joint its columns.
    ///
    /// # Errors
    /// A list of variables with unknown, missing or double names; limits that are none; a mimic
    /// that cannot be followed.
    pub fn assign(
        description: &RobotDescription,
        order: &Order,
        joint_index: &HashMap<String, usize>,
        warnings: &mut Vec<Warning>,
    ) -> Result<Self, RobotError> {
        let mut assigning = Assigning::new(description, order);
        assigning.give_columns(warnings)?;
        assigning.give_the_rest(description, order, joint_index, warnings)?;
        Ok(Self {
            drives: assigning.drives,
            space: ConfigurationSpace::new(assigning.components),
            variables: assigning.variables,
            held: assigning.held,
        })
    }
}

/// Columns while they are given.
struct Assigning<'a> {
    /// The joints, in tree order, and the names of their variables.
    sources: Vec<JointSource<'a>>,
    names: Vec<Vec<String>>,
    /// The variables that are columns, as the description lists them.
    listed: Vec<String>,
    drives: Vec<Drive>,
    components: Vec<Component>,
    variables: Vec<Variable>,
    held: Vec<HeldVariable>,
}

impl<'a> Assigning<'a> {
    fn new(description: &'a RobotDescription, order: &Order) -> Self {
        let source = |position: usize| match order.joint(description, position) {
            Some(joint) => JointSource::of(joint),
            None => JointSource::root(description),
        };
        let sources: Vec<_> = (0..order.len()).map(source).collect();
        let named = |source: &JointSource| source.kind.variable_names(source.name);
        let names: Vec<Vec<String>> = sources.iter().map(named).collect();
        let listed = description.variables.clone();
        Self {
            listed: listed.unwrap_or_else(|| every_free_variable(&sources, &names)),
            drives: vec![Drive::Fixed; sources.len()],
            sources,
            names,
            components: Vec::new(),
            variables: Vec::new(),
            held: Vec::new(),
        }
    }

    /// Gives the listed joints their columns, in the order of the list.
    fn give_columns(&mut self, warnings: &mut Vec<Warning>) -> Result<(), RobotError> {
        unique("variable", self.listed.iter().map(String::as_str))?;
        let mut q = 0;
        let mut v = 0;
        while q < self.listed.len() {
            let position = self.listed_at(q)?;
            let JointSource { name, kind, .. } = self.sources[position];
            if self.sources[position].mimic.is_some() {
                let text =
                    format!("mimic joint {name:?} is listed as a variable and moves independently");
                warnings.push(Warning::uncovered(text));
            }
            self.drives[position] = Drive::Variable { q, v };
            push_components(kind, q, v, &mut self.components);
            self.add_variables(position)?;
            q += kind.nq();
            v += kind.nv();
        }
        Ok(())
    }

    /// The joint whose variables stand at `column` of the list.
    fn listed_at(&self, column: usize) -> Result<usize, RobotError> {
        let listed = &self.listed[column..];
        let is_first = |names: &Vec<String>| names.first() == Some(&listed[0]);
        let Some(position) = self.names.iter().position(is_first) else {
            return Err(RobotError::Unknown {
                what: "the list of variables".to_owned(),
                kind: "variable",
                name: listed[0].clone(),
                known: list(self.names.iter().flatten().map(String::as_str)),
            });
        };
        if listed.starts_with(&self.names[position]) {
            return Ok(position);
        }
        Err(RobotError::BadValue {
            what: format!("the list of variables at {:?}", listed[0]),
            value: "incomplete or out of order".to_owned(),
            rule: "a planar or floating joint's variables stand together, in MoveIt's order",
        })
    }

    fn add_variables(&mut self, position: usize) -> Result<(), RobotError> {
        for (index, name) in self.names[position].iter().enumerate() {
            let Bounds {
                lower,
                upper,
                hard_lower,
                hard_upper,
            } = self.sources[position].bounds(index);
            if lower.is_nan() || upper.is_nan() || lower > upper {
                return Err(RobotError::BadValue {
                    what: format!("the limits of {name:?}"),
                    value: format!("[{lower}, {upper}]"),
                    rule: "they must be numbers, lower ≤ upper",
                });
            }
            self.variables.push(Variable {
                name: name.clone(),
                lower,
                upper,
                hard_lower,
                hard_upper,
            });
        }
        Ok(())
    }

    /// Joints that are no columns follow another or stand still.
    fn give_the_rest(
        &mut self,
        description: &RobotDescription,
        order: &Order,
        joint_index: &HashMap<String, usize>,
        warnings: &mut Vec<Warning>,
    ) -> Result<(), RobotError> {
        let is_variable = |drive: &Drive| matches!(drive, Drive::Variable { .. });
        let is_listed: Vec<bool> = self.drives.iter().map(is_variable).collect();
        for position in 0..self.drives.len() {
            if self.sources[position].kind == JointKind::Fixed {
                warnings.extend(self.ignored_mimic(position));
            } else if is_listed[position] {
                continue;
            } else if let Some(followed) =
                follow(description, joint_index, position, order, &is_listed)?
            {
                warnings.extend(self.let_follow(position, &followed));
            } else {
                self.hold(position);
            }
        }
        Ok(())
    }

    fn ignored_mimic(&self, position: usize) -> Option<Warning> {
        let JointSource { name, mimic, .. } = &self.sources[position];
        mimic.map(|_| {
            let text = format!("mimic on fixed joint {name:?} is ignored");
            Warning::cosmetic("fixed mimic", text)
        })
    }

    fn let_follow(&mut self, position: usize, followed: &Followed) -> Option<Warning> {
        let Followed {
            master,
            multiplier,
            offset,
        } = *followed;
        self.drives[position] = Drive::Mimic {
            master,
            multiplier,
            offset,
        };
        let JointSource { name, kind, .. } = self.sources[position];
        let told = as_real_line(
            &mut self.components,
            self.drives[master],
            self.sources[master].name,
            kind,
            multiplier,
        )?;
        let text = format!("{told}, since {name:?} follows it");
        Some(Warning::cosmetic("whole turns", text))
    }

    fn hold(&mut self, position: usize) {
        let source = &self.sources[position];
        self.drives[position] = Drive::Held {
            first: self.held.len(),
        };
        for (index, name) in self.names[position].iter().enumerate() {
            // A floating joint at rest is the unit quaternion: its last number is 1.
            let is_one = source.kind == JointKind::Floating && index == 6;
            let Bounds {
                lower,
                upper,
                hard_lower,
                hard_upper,
            } = source.bounds(index);
            self.held.push(HeldVariable {
                name: name.clone(),
                default: if is_one { 1.0 } else { 0.0 },
                lower,
                upper,
                hard_lower,
                hard_upper,
            });
        }
    }
}

/// Every variable of a joint that copies no other, in tree order.
fn every_free_variable(sources: &[JointSource], names: &[Vec<String>]) -> Vec<String> {
    let free = sources.iter().zip(names);
    free.filter(|(source, _)| source.mimic.is_none())
        .flat_map(|(_, names)| names.clone())
        .collect()
}

//! Where a node puts what it shows.

use roxmltree::Node;

use super::{at, numbers, tag};
use crate::math::{Mat3, Quat, Vec3};

/// A linear map followed by a shift.
#[derive(Clone, Copy, Debug)]
pub(super) struct Affine {
    linear: Mat3,
    shift: Vec3,
}

impl Affine {
    const IDENTITY: Self = Self {
        linear: Mat3::IDENTITY,
        shift: Vec3::ZERO,
    };

    /// Multiplies coordinates.
    pub(super) fn scale(factors: Vec3) -> Self {
        Self {
            linear: Mat3::from_diagonal(factors),
            ..Self::IDENTITY
        }
    }

    /// The map that does `inner` first, then this one.
    pub(super) fn then(&self, inner: &Self) -> Self {
        Self {
            linear: self.linear * inner.linear,
            shift: self.linear * inner.shift + self.shift,
        }
    }

    pub(super) fn point(&self, point: Vec3) -> Vec3 {
        self.linear * point + self.shift
    }

    pub(super) fn mirrors(&self) -> bool {
        self.linear.determinant() < 0.0
    }
}

/// The transforms of a node in the order in which it has them: the last is done first.
pub(super) fn of_node(node: Node) -> Result<Affine, String> {
    let mut all = Affine::IDENTITY;
    for child in node.children().filter(Node::is_element) {
        let one = match child.tag_name().name() {
            "matrix" => matrix(child)?,
            "translate" => Affine {
                shift: Vec3::from_array(exactly(child)?),
                ..Affine::IDENTITY
            },
            "scale" => Affine::scale(Vec3::from_array(exactly(child)?)),
            "rotate" => rotate(child)?,
            "lookat" | "skew" => {
                let text = format!(
                    "{} is not read; apply the object's transforms before the export",
                    tag(child)
                );
                return Err(at(child, text));
            }
            _ => continue,
        };
        all = all.then(&one);
    }
    Ok(all)
}

/// Axes may differ from unit length by this much, as of six digits.
const AXIS_TOLERANCE: f64 = 1e-3;

fn rotate(node: Node) -> Result<Affine, String> {
    let [x, y, z, degrees] = exactly(node)?;
    let axis = Vec3::new(x, y, z);
    match axis.try_normalize() {
        // assimp and pycollada put such an axis into the formula as it stands, and stretch the
        // mesh.
        Some(_) if degrees != 0.0 && (axis.length() - 1.0).abs() > AXIS_TOLERANCE => {
            let text = format!(
                "the axis of <rotate> is {x} {y} {z}, of length {}",
                axis.length()
            );
            Err(at(
                node,
                format!("{text}; readers stretch the mesh: make it a unit vector"),
            ))
        }
        Some(axis) => {
            let linear = Mat3::from_quat(Quat::from_axis_angle(axis, degrees.to_radians()));
            Ok(Affine {
                linear,
                shift: Vec3::ZERO,
            })
        }
        None if degrees == 0.0 => Ok(Affine::IDENTITY),
        None => Err(at(
            node,
            format!("<rotate> turns by {degrees} degrees about an axis of length 0"),
        )),
    }
}

/// A matrix written row by row.
fn matrix(node: Node) -> Result<Affine, String> {
    let m: [f64; 16] = exactly(node)?;
    if m[12..] != [0.0, 0.0, 0.0, 1.0] {
        let text = format!(
            "the last row of <matrix> is {:?}; it must be 0 0 0 1",
            &m[12..]
        );
        return Err(at(node, text));
    }
    let column = |i: usize| Vec3::new(m[i], m[4 + i], m[8 + i]);
    Ok(Affine {
        linear: Mat3::from_cols(column(0), column(1), column(2)),
        shift: column(3),
    })
}

fn exactly<const N: usize>(node: Node) -> Result<[f64; N], String> {
    let values = numbers(node)?;
    if let Some(bad) = values.iter().find(|value| !value.is_finite()) {
        return Err(at(
            node,
            format!("{} holds {bad}, which is not finite", tag(node)),
        ));
    }
    let count = values.len();
    values.try_into().map_err(|_| {
        at(
            node,
            format!("{} has {count} numbers, it must have {N}", tag(node)),
        )
    })
}

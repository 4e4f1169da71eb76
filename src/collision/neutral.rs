//! Links that collide as the robot stands: without an SRDF nobody has said which of them are built that way.

use super::model::CollisionModel;
use super::query;
use crate::robot::{Component, Kinematics, RobotModel};
use crate::warning::Warning;

/// Checked pairs of links that touch or overlap in the neutral configuration: every variable at 0, or at the limit
/// that is nearest to it, and turns of floating joints at none.
pub fn neutral_contacts(model: &CollisionModel) -> Vec<[String; 2]> {
    let robot = model.robot();
    let held: Vec<f64> = robot.held().iter().map(|joint| nearest(joint.default, joint.lower, joint.upper)).collect();
    let mut kinematics = Kinematics::default();
    kinematics.update(robot, &neutral(robot), &held);
    let overlaps = |&index: &usize| {
        let pair = model.pairs()[index];
        let (a, b) = (&model.bodies()[pair.a], &model.bodies()[pair.b]);
        let are_links = a.link.is_some() && b.link.is_some();
        are_links && query::overlap(a, &a.placed(&kinematics), b, &b.placed(&kinematics)).is_some()
    };
    (0..model.pairs().len()).filter(overlaps).map(|index| model.pair_names(index)).collect()
}

/// A warning for each of [`neutral_contacts`], with the line of an SRDF that would allow it.
pub fn neutral_warnings(model: &CollisionModel) -> Vec<Warning> {
    let warning = |[a, b]: [String; 2]| {
        let line =
            format!("<disable_collisions link1=\"{}\" link2=\"{}\" reason=\"Default\"/>", escaped(&a), escaped(&b));
        let text = format!(
            "no SRDF, and {a} × {b} collide with every joint at 0; if they are built so, put in an SRDF: {line}"
        );
        Warning::cosmetic("rest contact", text)
    };
    neutral_contacts(model).into_iter().map(warning).collect()
}

fn neutral(robot: &RobotModel) -> Vec<f64> {
    let mut q: Vec<f64> = robot.variables().iter().map(|v| nearest(0.0, v.lower, v.upper)).collect();
    for component in robot.space().components() {
        if let Component::Rotation { q: first, .. } = *component {
            q[first..first + 4].copy_from_slice(&[0.0, 0.0, 0.0, 1.0]);
        }
    }
    q
}

/// Like `clamp`, which panics where limits are the wrong way round.
fn nearest(value: f64, lower: f64, upper: f64) -> f64 {
    value.max(lower).min(upper)
}

fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::robot::{srdf, urdf};
    use crate::scene::Scene;

    /// Four balls in a row on sliding joints, a metre apart at 0. The third's limits hold it on the first at
    /// least, the fourth floats where the second is.
    fn robot(srdf: Option<&str>) -> CollisionModel {
        let link = |name: &str| {
            let shape = "<collision><geometry><sphere radius='0.2'/></geometry></collision>";
            format!("<link name='{name}'>{shape}</link>")
        };
        let joint = |name: &str, child: &str, kind: &str, x: f64, limit: &str| {
            let ends = format!("<parent link='a'/><child link='{child}'/><origin xyz='{x} 0 0'/>{limit}");
            format!("<joint name='{name}' type='{kind}'>{ends}</joint>")
        };
        let joints = [
            joint("ab", "b", "prismatic", 1.0, "<limit lower='-1' upper='1'/>"),
            joint("ac", "c", "prismatic", -1.0, "<limit lower='2' upper='3'/>"),
            joint("ad", "d", "floating", 1.0, ""),
        ];
        let text = format!("<robot name='r'>{}{}</robot>", ["a", "b", "c", "d"].map(link).concat(), joints.concat());
        let mut robot = urdf::parse(&text, &mut |_, _| unreachable!("no meshes")).unwrap();
        robot.semantics = srdf.map(|text| srdf::parse(text, &robot).unwrap().0);
        let robot = RobotModel::new(robot).unwrap();
        CollisionModel::new(Arc::new(robot), Arc::new(Scene::default())).unwrap()
    }

    #[test]
    fn links_that_overlap_at_zero_or_the_nearest_limit_are_named_with_the_line_to_paste() {
        let model = robot(None);
        // All three stand at x = 1 then.
        assert_eq!(neutral_contacts(&model), [["b", "c"], ["b", "d"], ["c", "d"]]);
        let warnings = neutral_warnings(&model);
        let line = r#"<disable_collisions link1="b" link2="c" reason="Default"/>"#;
        assert!(warnings[0].contains("b × c") && warnings[0].ends_with(line), "{}", warnings[0]);
        // The line does what it says, and naming a pair has not allowed it.
        assert_eq!(model.pairs().len(), 3);
        let mended = robot(Some(&format!("<robot name='r'>{line}</robot>")));
        assert!(!neutral_contacts(&mended).contains(&["b".to_owned(), "c".to_owned()]));
    }
}

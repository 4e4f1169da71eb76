//! Links that collide as the robot stands, where no SRDF says which of them are built that way.

use std::f64::consts::PI;

use super::body::{Body, BodyKind};
use super::model::CollisionModel;
use crate::robot::{Drive, Joint, JointKind, Kinematics, RobotModel};
use crate::solid::query;

/// Configurations that are looked at before a pair is offered for switching off.
const SAMPLES: usize = 200;
/// In how many of those the pair may be apart: MoveIt's setup assistant calls a pair "always" in
/// collision from 95 % on.
const APART: usize = SAMPLES / 20;
/// How far an unbounded translation is moved in them (m).
const UNBOUNDED_M: f64 = 1.0;
use crate::warning::Warning;

/// Checked pairs of links that touch or overlap in the neutral configuration: every variable at 0,
/// or at the limit that is nearest to it, and turns of floating joints at none.
pub fn neutral_contacts(model: &CollisionModel) -> Vec<[String; 2]> {
    neutral_pairs(model)
        .into_iter()
        .map(|index| model.pair_names(index))
        .collect()
}

/// Where the SRDF disables no pair, a warning for each of [`neutral_contacts`]: with the line of an
/// SRDF that would allow it if the links touch in nearly every configuration, and else that it is
/// none to allow.
pub fn neutral_warnings(model: &CollisionModel) -> Vec<Warning> {
    let semantics = model.robot().description().semantics.as_ref();
    let (srdf, place) = match semantics {
        None => ("no SRDF", "put in an SRDF"),
        Some(semantics) if semantics.disabled_collisions.is_empty() => {
            ("the SRDF disables no pair", "put in it")
        }
        Some(_) => return Vec::new(),
    };
    let warning = |index: usize| {
        let [a, b] = model.pair_names(index);
        let begin = format!("{srdf}, and {a} × {b} collide with every joint at 0");
        if !touch_nearly_always(model, index) {
            let advice = "the pair stays checked: begin and end paths where they are apart";
            let text = format!("{begin} and are apart in other configurations; {advice}");
            return Warning::cosmetic("rest contact", text);
        }
        let reason = if are_joined(model, index) {
            "Adjacent"
        } else {
            "Always"
        };
        let a = escaped(&a);
        let b = escaped(&b);
        let line = format!("<disable_collisions link1=\"{a}\" link2=\"{b}\" reason=\"{reason}\"/>");
        let text = format!(
            "{begin} and in nearly every configuration; if they are built so, {place}: {line}"
        );
        Warning::cosmetic("rest contact", text)
    };
    neutral_pairs(model)
        .into_iter()
        .map(warning)
        .collect()
}

fn neutral_pairs(model: &CollisionModel) -> Vec<usize> {
    let robot = model.robot();
    let neutral = |joint: &Joint, column: usize, lower: f64, upper: f64| match (joint.kind, column)
    {
        (JointKind::Floating, 3..6) => 0.0,
        (JointKind::Floating, 6) => 1.0,
        _ => nearest(0.0, lower, upper),
    };
    let kinematics = placed(robot, neutral);
    let are_links = |index: &usize| {
        let [a, b] = bodies(model, *index);
        a.kind == BodyKind::Link && b.kind == BodyKind::Link
    };
    (0..model.pairs().len())
        .filter(are_links)
        .filter(|index| touch(model, *index, &kinematics))
        .collect()
}

/// Whether the pair touches in all but a few of many configurations, the same ones each time.
fn touch_nearly_always(model: &CollisionModel, pair: usize) -> bool {
    let mut random = fastrand::Rng::with_seed(0);
    let mut apart = 0;
    for _ in 0..SAMPLES {
        let mut turn = [0.0; 4];
        let value =
            |joint: &Joint, column: usize, lower: f64, upper: f64| match (joint.kind, column) {
                (JointKind::Floating, 3..7) => {
                    if column == 3 {
                        turn = random_turn(&mut random);
                    }
                    turn[column - 3]
                }
                (JointKind::Continuous, _) | (JointKind::Planar, 2) => within(&mut random, -PI, PI),
                (JointKind::Prismatic | JointKind::Planar | JointKind::Floating, _) => within(
                    &mut random,
                    lower.max(upper.min(0.0) - UNBOUNDED_M),
                    upper.min(lower.max(0.0) + UNBOUNDED_M),
                ),
                (JointKind::Revolute, _) => within(&mut random, lower.max(-PI), upper.min(PI)),
                (JointKind::Fixed, _) => 0.0,
            };
        let kinematics = placed(model.robot(), value);
        apart += usize::from(!touch(model, pair, &kinematics));
        if apart > APART {
            return false;
        }
    }
    true
}

/// The robot with every column of its joints, held ones too, at what `value` makes of its limits.
fn placed(robot: &RobotModel, mut value: impl FnMut(&Joint, usize, f64, f64) -> f64) -> Kinematics {
    let mut q = vec![0.0; robot.variables().len()];
    let mut held = vec![0.0; robot.held().len()];
    for joint in robot.joints() {
        for column in 0..joint.kind.nq() {
            match joint.drive {
                Drive::Variable { q: first, .. } => {
                    let variable = &robot.variables()[first + column];
                    q[first + column] = value(joint, column, variable.lower, variable.upper);
                }
                Drive::Held { first } => {
                    let variable = &robot.held()[first + column];
                    held[first + column] = value(joint, column, variable.lower, variable.upper);
                }
                Drive::Fixed | Drive::Mimic { .. } => {}
            }
        }
    }
    let mut kinematics = Kinematics::default();
    kinematics.update(robot, &q, &held);
    kinematics
}

fn bodies(model: &CollisionModel, pair: usize) -> [&Body; 2] {
    let pair = model.pairs()[pair];
    [&model.bodies()[pair.a], &model.bodies()[pair.b]]
}

fn touch(model: &CollisionModel, pair: usize, kinematics: &Kinematics) -> bool {
    let [a, b] = bodies(model, pair);
    let [at_a, at_b] = [a, b].map(|body| body.placed(kinematics));
    query::overlap(&a.solid, &at_a, &b.solid, &at_b).is_some()
}

/// Whether one joint joins the two links.
fn are_joined(model: &CollisionModel, pair: usize) -> bool {
    let [a, b] = bodies(model, pair).map(|body| body.link);
    let parent = |link: Option<usize>| link.and_then(|link| model.robot().joints()[link].parent);
    parent(a) == b || parent(b) == a
}

fn within(random: &mut fastrand::Rng, lower: f64, upper: f64) -> f64 {
    lower + random.f64() * (upper - lower).max(0.0)
}

/// A unit quaternion, each direction of four as likely as any other.
fn random_turn(random: &mut fastrand::Rng) -> [f64; 4] {
    loop {
        let turn = [(); 4].map(|()| within(random, -1.0, 1.0));
        let norm = turn.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (0.1..=1.0).contains(&norm) {
            return turn.map(|x| x / norm);
        }
    }
}

/// Like `clamp`, which panics where limits are the wrong way round.
fn nearest(value: f64, lower: f64, upper: f64) -> f64 {
    value.max(lower).min(upper)
}

fn escaped(name: &str) -> String {
    name.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::robot::{srdf, urdf};
    use crate::scene::Scene;

    /// Four balls in a row on sliding joints, a metre apart at 0. The third's limits hold it on the
    /// first at least, the fourth floats where the second is; a fifth turns in the second's place.
    fn robot(srdf: Option<&str>) -> CollisionModel {
        let link = |name: &str| {
            let shape = "<collision><geometry><sphere radius='0.2'/></geometry></collision>";
            format!("<link name='{name}'>{shape}</link>")
        };
        let joint = |name: &str, [parent, child]: [&str; 2], kind: &str, x: f64, limit: &str| {
            let ends = format!(
                "<parent link='{parent}'/><child link='{child}'/><origin xyz='{x} 0 0'/>{limit}"
            );
            format!("<joint name='{name}' type='{kind}'>{ends}</joint>")
        };
        let joints = [
            joint(
                "ab",
                ["a", "b"],
                "prismatic",
                1.0,
                "<limit lower='-1' upper='1'/>",
            ),
            joint(
                "ac",
                ["a", "c"],
                "prismatic",
                -1.0,
                "<limit lower='2' upper='3'/>",
            ),
            joint("ad", ["a", "d"], "floating", 1.0, ""),
            joint("be", ["b", "m"], "continuous", 0.0, ""),
            joint("me", ["m", "e"], "fixed", 0.1, ""),
        ];
        let links = ["a", "b", "c", "d", "e"].map(link).concat();
        let text = format!(
            "<robot name='r'>{links}<link name='m'/>{}</robot>",
            joints.concat()
        );
        let mut robot = urdf::parse(&text, &mut |_, _| unreachable!("no meshes")).unwrap();
        robot.semantics = srdf.map(|text| srdf::parse(text, &robot).unwrap().0);
        let robot = RobotModel::new(robot).unwrap();
        CollisionModel::new(Arc::new(robot), Arc::new(Scene::default())).unwrap()
    }

    #[test]
    fn links_that_overlap_at_zero_or_the_nearest_limit_are_named() {
        // All but the first stand at x = 1 then, or 0.1 m beside it.
        let pairs = [
            ["b", "c"],
            ["b", "d"],
            ["b", "e"],
            ["c", "d"],
            ["c", "e"],
            ["d", "e"],
        ];
        let mut found = neutral_contacts(&robot(None));
        found.iter_mut().for_each(|pair| pair.sort());
        found.sort();
        assert_eq!(found, pairs);
    }

    #[test]
    fn the_line_to_paste_is_offered_only_for_links_that_touch_nearly_always() {
        let model = robot(None);
        let warnings = neutral_warnings(&model);
        let line = r#"<disable_collisions link1="b" link2="e" reason="Always"/>"#;
        let offered: Vec<&Warning> = warnings
            .iter()
            .filter(|text| text.contains("disable_collisions"))
            .collect();
        assert!(
            offered.len() == 1 && offered[0].ends_with(line),
            "{warnings:?}"
        );
        assert!(
            offered[0].starts_with("no SRDF, and b × e collide"),
            "{}",
            offered[0]
        );
        assert!(
            warnings
                .iter()
                .any(|text| text.contains("b × c") && text.contains("stays checked")),
            "{warnings:?}"
        );
        assert_eq!(
            warnings,
            neutral_warnings(&robot(None)),
            "the same each time"
        );
        // The line does what it says, and then the SRDF has spoken.
        let mended = robot(Some(&format!("<robot name='r'>{line}</robot>")));
        assert!(!neutral_contacts(&mended).contains(&["b".to_owned(), "e".to_owned()]));
        assert!(neutral_warnings(&mended).is_empty());
    }

    #[test]
    fn an_srdf_that_disables_nothing_gets_the_same_advice() {
        let warnings = neutral_warnings(&robot(Some("<robot name='r'/>")));
        let text = warnings
            .iter()
            .find(|text| text.contains("b × e"))
            .unwrap();
        assert!(
            text.starts_with("the SRDF disables no pair") && text.contains("disable_collisions"),
            "{text}"
        );
        let rest = neutral_warnings(&robot(Some(r#"<robot name="r"><group name="g"/></robot>"#)));
        assert_eq!(rest, warnings);
    }
}

//! What a robot looks like, for pictures: nothing is proved about it, so what cannot be read is
//! named and left out.

use std::collections::HashMap;

use roxmltree::Node;

use super::{MeshSource, Reading, check, children, essentials, version, xml};
use crate::robot::RobotError;
use crate::shape::PlacedShape;

/// A visual shape, in its link's frame.
#[derive(Clone, Debug)]
pub struct Visual {
    /// Name of the link.
    pub link: String,
    /// The shape.
    pub shape: PlacedShape,
    /// Red, green, blue, alpha in [0, 1], where the file says so.
    pub color: Option<[f64; 4]>,
}

/// Reads the visual shapes of a URDF; and what of them cannot be shown, a line for each link, of
/// which then none is.
///
/// # Errors
/// A text that is no XML.
pub fn visuals(
    text: &str,
    meshes: &mut MeshSource<'_>,
) -> Result<(Vec<Visual>, Vec<String>), RobotError> {
    let (text, _) = xml::tidy(text);
    let document = xml::document(&text, "URDF")?;
    let root = document.root_element();
    // What is odd about a picture is said of shapes that are not shown.
    let mut reading = Reading {
        meshes,
        version: version(root),
        warnings: Vec::new(),
    };
    let named = |node: Node| Some((node.attribute("name")?.to_owned(), color(node)?));
    let materials: HashMap<String, [f64; 4]> = children(root, "material")
        .filter_map(named)
        .collect();
    let mut found = Vec::new();
    let mut missing = Vec::new();
    for link in children(root, "link") {
        let name = link.attribute("name").unwrap_or_default();
        let mut read = |visual: Node| {
            let Some(shape) = reading.visual(visual, name)? else {
                return Ok(None);
            };
            let material = children(visual, "material").next();
            let known = |node: Node| materials.get(node.attribute("name")?).copied();
            let color = material.and_then(|node| color(node).or_else(|| known(node)));
            Ok::<_, RobotError>(Some(Visual {
                link: name.to_owned(),
                shape,
                color,
            }))
        };
        match children(link, "visual")
            .filter_map(|visual| read(visual).transpose())
            .collect::<Result<Vec<_>, _>>()
        {
            Ok(visuals) => found.extend(visuals),
            Err(error) => missing.push(format!("visual shape of {error}")),
        }
    }
    Ok((found, missing))
}

impl Reading<'_, '_> {
    /// A visual's shape is written as a collision's is, and read by the same reader; a point is
    /// none.
    fn visual(&mut self, visual: Node, link: &str) -> Result<Option<PlacedShape>, RobotError> {
        let of = format!("link {link:?}");
        check::placed(visual, &of, self.version)?;
        let robot = urdf_rs::read_from_string(&essentials::of_visual(visual))
            .map_err(|error| RobotError::Syntax(format!("{of}: {error}")))?;
        let Some(found) = robot
            .links
            .first()
            .and_then(|link| link.collision.first())
        else {
            return Ok(None);
        };
        let pose = self.pose(&found.origin, visual, &of)?;
        Ok(self
            .shape(&found.geometry, visual, link)?
            .map(|shape| PlacedShape { pose, shape }))
    }
}

fn color(material: Node) -> Option<[f64; 4]> {
    let text = children(material, "color")
        .next()?
        .attribute("rgba")?;
    let numbers: Vec<f64> = text
        .split_whitespace()
        .map_while(|number| number.parse().ok())
        .collect();
    let color: [f64; 4] = numbers.try_into().ok()?;
    color
        .iter()
        .all(|part| (0.0..=1.0).contains(part))
        .then_some(color)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{MeshError, Shape};

    #[test]
    fn what_can_be_shown_is_read_and_the_rest_is_named() {
        let text = r#"<robot name="r"><material name="steel"><color rgba="0.1 0.2 0.3 1"/></material>
            <link name="a">
              <visual><origin xyz="1 0 0"/><geometry><box size="2 2 2"/></geometry><material name="steel"/></visual>
            </link>
            <link name="b">
              <visual><geometry><box size="1 1 1"/></geometry></visual>
              <visual><geometry><mesh filename="gone.dae"/></geometry></visual>
            </link></robot>"#;
        let mut none = |name: &str, _| {
            Err(MeshError::Unreadable {
                name: name.to_owned(),
                reason: "not there".into(),
            })
        };
        let (found, missing) = visuals(text, &mut none).unwrap();
        assert_eq!(
            (found.len(), found[0].link.as_str(), found[0].color),
            (1, "a", Some([0.1, 0.2, 0.3, 1.0]))
        );
        assert_eq!(found[0].shape.pose.translation.x, 1.0);
        assert!(
            matches!(found[0].shape.shape, Shape::Box { half_extents } if half_extents.x == 1.0)
        );
        assert!(
            missing.len() == 1 && missing[0].contains("gone.dae"),
            "{missing:?}"
        );
    }
}

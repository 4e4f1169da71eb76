//! The solids of a model, by what they were made of, so that the next scene's model takes over what
//! stays.

use std::collections::HashMap;
use std::sync::Arc;

use super::body::Size;
use crate::hash::ContentHasher;
use crate::robot::{Link, RobotModel};
use crate::scene::Scene;
use crate::shape::{PlacedShape, ScaleError};
use crate::solid::Solid;

/// Solids of a robot's links and a scene's objects.
#[derive(Clone, Debug, Default)]
pub struct Solids {
    /// One for each link that has shapes.
    links: Arc<[Option<Arc<Solid>>]>,
    /// By where an object's shapes are in memory, which costs nothing to compare. The shapes are
    /// kept, so nothing else can be there.
    by_place: HashMap<usize, Made>,
    /// By content: equal shapes that were read twice.
    by_content: HashMap<u64, Arc<Solid>>,
    /// By solid and bits of scale and padding.
    sized: HashMap<(usize, [u64; 2]), Sized>,
}

#[derive(Clone, Debug)]
struct Made {
    shapes: Arc<[PlacedShape]>,
    content: u64,
    solid: Arc<Solid>,
}

#[derive(Clone, Debug)]
struct Sized {
    /// Kept, so that nothing else can be where it is in memory.
    bare: Arc<Solid>,
    solid: Arc<Solid>,
}

impl Solids {
    /// Those of a robot's links.
    pub fn of_links(robot: &RobotModel) -> Self {
        let solid =
            |shapes: &[PlacedShape]| (!shapes.is_empty()).then(|| Arc::new(Solid::new(shapes)));
        let links = robot
            .links()
            .iter()
            .map(|link| solid(&link.shapes))
            .collect();
        Self {
            links,
            ..Self::default()
        }
    }

    /// Those of a robot's links as they were made before; `None` if they are not this robot's.
    pub fn with_links(robot: &RobotModel, links: Vec<Option<Solid>>) -> Option<Self> {
        let is_of =
            |(link, solid): (&Link, &Option<Solid>)| link.shapes.is_empty() == solid.is_none();
        let fits =
            links.len() == robot.links().len() && robot.links().iter().zip(&links).all(is_of);
        fits.then(|| Self {
            links: links
                .into_iter()
                .map(|solid| solid.map(Arc::new))
                .collect(),
            ..Self::default()
        })
    }

    /// Those of a scene's objects, taken from `before` where they are there.
    pub fn of_objects(scene: &Scene, before: Option<&Self>) -> Self {
        let mut solids = Self::default();
        let before = before.as_slice();
        for object in scene
            .objects()
            .filter(|object| !object.shapes.is_empty())
        {
            solids.object(&object.shapes, before);
        }
        solids
    }

    /// Those of a robot's links, with no object yet.
    pub fn links_only(&self) -> Self {
        Self {
            links: self.links.clone(),
            ..Self::default()
        }
    }

    /// Those of all links.
    pub fn links(&self) -> &[Option<Arc<Solid>>] {
        &self.links
    }

    /// The solid of a link; `None` where it has no shapes.
    pub fn link(&self, link: usize) -> Option<Arc<Solid>> {
        self.links[link].clone()
    }

    /// Whether the solid of an object's shapes is there.
    pub fn has(&self, shapes: &Arc<[PlacedShape]>) -> bool {
        let place = Arc::as_ptr(shapes).cast::<PlacedShape>() as usize;
        let made = self.by_place.get(&place);
        made.is_some_and(|made| Arc::ptr_eq(&made.shapes, shapes))
    }

    /// Memory of the solids of objects (bytes).
    pub fn bytes(&self) -> usize {
        self.by_content
            .values()
            .map(|solid| solid.bytes())
            .sum()
    }

    /// Memory of the solids of links (bytes).
    pub fn link_bytes(&self) -> usize {
        let links = self.links.iter().flatten();
        links.map(|solid| solid.bytes()).sum()
    }

    /// Memory of the solids of another size than their shapes' (bytes).
    pub fn sized_bytes(&self) -> usize {
        self.sized
            .values()
            .map(|sized| sized.solid.bytes())
            .sum()
    }

    /// The solid of an object's shapes, of which there is at least one: taken from one of `before`
    /// if it is there.
    pub fn object(&mut self, shapes: &Arc<[PlacedShape]>, before: &[&Self]) -> Arc<Solid> {
        let place = Arc::as_ptr(shapes).cast::<PlacedShape>() as usize;
        if let Some(made) = self.by_place.get(&place) {
            return made.solid.clone();
        }
        let mut known = before
            .iter()
            .filter_map(|before| before.by_place.get(&place));
        let known = known.find(|made| Arc::ptr_eq(&made.shapes, shapes));
        let made = known
            .cloned()
            .unwrap_or_else(|| self.read_again(shapes, before));
        let solid = made.solid.clone();
        self.by_content
            .insert(made.content, solid.clone());
        self.by_place.insert(place, made);
        solid
    }

    fn read_again(&self, shapes: &Arc<[PlacedShape]>, before: &[&Self]) -> Made {
        let mut hasher = ContentHasher::default();
        for shape in shapes.iter() {
            shape.tell(&mut hasher);
        }
        let content = hasher.finish();
        let mut earlier = before.iter();
        let known = self
            .by_content
            .get(&content)
            .or_else(|| earlier.find_map(|before| before.by_content.get(&content)));
        let solid = known
            .cloned()
            .unwrap_or_else(|| Arc::new(Solid::new(shapes)));
        Made {
            shapes: shapes.clone(),
            content,
            solid,
        }
    }

    /// The solid of shapes, of which `bare` is the plain one, at another size: taken from `before`
    /// if it is there.
    ///
    /// # Errors
    /// A mesh that the scale leaves without an area.
    pub fn sized(
        &mut self,
        bare: &Arc<Solid>,
        shapes: &[PlacedShape],
        size: Size,
        before: &[&Self],
    ) -> Result<Arc<Solid>, ScaleError> {
        if size == Size::OWN {
            return Ok(bare.clone());
        }
        let key = (
            Arc::as_ptr(bare) as usize,
            [size.scale, size.padding].map(f64::to_bits),
        );
        let mut earlier = before.iter();
        let known = self
            .sized
            .get(&key)
            .or_else(|| earlier.find_map(|before| before.sized.get(&key)));
        let sized = match known.filter(|sized| Arc::ptr_eq(&sized.bare, bare)) {
            Some(known) => known.clone(),
            None => Sized {
                bare: bare.clone(),
                solid: Arc::new(resized(bare, shapes, size)?),
            },
        };
        let solid = sized.solid.clone();
        self.sized.insert(key, sized);
        Ok(solid)
    }
}

fn resized(
    bare: &Solid,
    shapes: &[PlacedShape],
    Size { scale, padding }: Size,
) -> Result<Solid, ScaleError> {
    if scale == 1.0 {
        return Ok(bare.padded(padding));
    }
    let shapes = shapes
        .iter()
        .map(|shape| shape.scaled(scale))
        .collect::<Result<Vec<_>, _>>()?;
    let solid = Solid::new(&shapes);
    Ok(if padding > 0.0 {
        solid.padded(padding)
    } else {
        solid
    })
}

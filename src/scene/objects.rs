//! Objects in their order, found by id; what a change leaves as it is, the lists before and after
//! it share.

use std::ops::{Bound, Index};
use std::sync::Arc;

use rpds::RedBlackTreeMapSync;

use super::{AttachedObject, Obstacle};
use crate::hash::{ContentHasher, Digest, FactSum};
use crate::shape::PlacedShape;

/// Objects of a scene in the order in which they came, found by id. Cloning it costs nothing;
/// changing a clone costs the logarithm of its length.
#[derive(Clone, Debug)]
pub struct Objects<T> {
    in_order: RedBlackTreeMapSync<u64, Held<T>>,
    number_of: RedBlackTreeMapSync<Arc<str>, u64>,
    facts: FactSum,
}

/// An object and what its content hash is made of.
#[derive(Clone, Debug)]
struct Held<T> {
    object: T,
    /// Of its shapes, which most changes leave as they are.
    shapes: Digest,
    /// Of all of it.
    fact: Digest,
}

/// What stands in a list of objects.
pub trait Member: AsRef<Obstacle> {
    /// All that makes it what it is, its shapes by their digest.
    fn fact(&self, shapes: &Digest) -> Digest;
}

impl Member for Obstacle {
    fn fact(&self, shapes: &Digest) -> Digest {
        let mut hasher = ContentHasher::default();
        hasher.name("object");
        tell(&mut hasher, self, shapes);
        hasher.finish_digest()
    }
}

impl Member for AttachedObject {
    fn fact(&self, shapes: &Digest) -> Digest {
        let mut hasher = ContentHasher::default();
        hasher
            .name("attached")
            .name(&self.link_name)
            .count(self.touch_links.len());
        for name in &self.touch_links {
            hasher.name(name);
        }
        tell(&mut hasher, &self.object, shapes);
        hasher.finish_digest()
    }
}

fn tell(hasher: &mut ContentHasher, object: &Obstacle, shapes: &Digest) {
    hasher
        .name(&object.id)
        .pose(&object.pose)
        .digest(shapes);
    if let Some(sensing) = &object.sensed {
        sensing.tell(hasher);
    }
}

/// Objects in their order.
pub struct Iter<'a, T>(<&'a RedBlackTreeMapSync<u64, Held<T>> as IntoIterator>::IntoIter);

impl<'a, T> Iterator for Iter<'a, T> {
    type Item = &'a T;

    fn next(&mut self) -> Option<&'a T> {
        self.0.next().map(|(_, held)| &held.object)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        self.0.size_hint()
    }
}

impl<T> Default for Objects<T> {
    fn default() -> Self {
        let in_order = RedBlackTreeMapSync::new_sync();
        let number_of = RedBlackTreeMapSync::new_sync();
        Self {
            in_order,
            number_of,
            facts: FactSum::default(),
        }
    }
}

impl<T> Objects<T> {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.in_order.size()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.in_order.is_empty()
    }

    /// All of them, in order.
    pub fn iter(&self) -> Iter<'_, T> {
        self.into_iter()
    }

    /// The one of an id.
    pub fn get(&self, id: &str) -> Option<&T> {
        self.held(id).map(|held| &held.object)
    }

    /// The first.
    pub fn first(&self) -> Option<&T> {
        self.in_order
            .first()
            .map(|(_, held)| &held.object)
    }

    fn held(&self, id: &str) -> Option<&Held<T>> {
        self.in_order.get(self.number_of.get(id)?)
    }

    /// Which of two lists' objects came first is told by their numbers, in one list or in one made
    /// from it.
    pub(super) fn number(&self, id: &str) -> Option<u64> {
        self.number_of.get(id).copied()
    }

    /// All that makes an object what it is, but for its place in the order.
    pub(super) fn fact(&self, id: &str) -> Option<&Digest> {
        self.held(id).map(|held| &held.fact)
    }

    /// Whether both lists are one in memory; those that are not may still be equal.
    pub(super) fn is(&self, other: &Self) -> bool {
        self.in_order.ptr_eq(&other.in_order)
    }

    /// Whether both lists have the same ids in the same order, as far as memory that they share
    /// tells.
    pub(super) fn lines_up_with(&self, other: &Self) -> bool {
        self.number_of.ptr_eq(&other.number_of)
    }

    /// What the list's content hash is made of: each object, and which follows which.
    pub(super) fn facts(&self) -> &FactSum {
        &self.facts
    }
}

impl<T: Member + Clone> Objects<T> {
    /// Puts an object behind the others; none of them has its id.
    pub(super) fn push(&mut self, object: T) {
        let shapes = digest_of_shapes(&object.as_ref().shapes);
        let held = Held::new(object, shapes);
        let (number, before) = match self.in_order.last() {
            Some((number, last)) => (number + 1, Some(last.id())),
            None => (0, None),
        };
        self.facts.add(&held.fact);
        self.facts.add(&succession(before, held.id()));
        self.number_of
            .insert_mut(held.id().into(), number);
        self.in_order.insert_mut(number, held);
    }

    /// Takes an object away and gives it.
    pub(super) fn remove(&mut self, id: &str) -> Option<T> {
        let number = self.number(id)?;
        let held = self.in_order.get(&number)?.clone();
        let before = self
            .in_order
            .range((Bound::Unbounded, Bound::Excluded(number)))
            .next_back();
        let before = before.map(|(_, held)| held.id());
        let after = self
            .in_order
            .range((Bound::Excluded(number), Bound::Unbounded))
            .next();
        self.facts.subtract(&held.fact);
        self.facts.subtract(&succession(before, id));
        if let Some((_, after)) = after {
            self.facts
                .subtract(&succession(Some(id), after.id()));
            self.facts.add(&succession(before, after.id()));
        }
        self.number_of.remove_mut(id);
        self.in_order.remove_mut(&number);
        Some(held.object)
    }

    /// Makes another object of the same id of one, if there is one.
    pub(super) fn update(&mut self, id: &str, change: impl FnOnce(&T) -> T) {
        let Some((number, held)) = self
            .number(id)
            .and_then(|number| Some((number, self.in_order.get(&number)?)))
        else {
            return;
        };
        let object = change(&held.object);
        let is_same = Arc::ptr_eq(&held.object.as_ref().shapes, &object.as_ref().shapes);
        let shapes = if is_same {
            held.shapes
        } else {
            digest_of_shapes(&object.as_ref().shapes)
        };
        let new = Held::new(object, shapes);
        self.facts.subtract(&held.fact);
        self.facts.add(&new.fact);
        self.in_order.insert_mut(number, new);
    }
}

impl<T: AsRef<Obstacle>> Held<T> {
    fn id(&self) -> &str {
        &self.object.as_ref().id
    }
}

impl<T: Member> Held<T> {
    fn new(object: T, shapes: Digest) -> Self {
        let fact = object.fact(&shapes);
        Self {
            object,
            shapes,
            fact,
        }
    }
}

/// What the content hash of shapes is made of.
pub(super) fn digest_of_shapes(shapes: &[PlacedShape]) -> Digest {
    let mut hasher = ContentHasher::default();
    for shape in shapes {
        shape.tell(&mut hasher);
    }
    hasher.finish_digest()
}

/// That an object comes right after another one, or first. Ids are unique, so these facts tell the
/// whole order.
fn succession(before: Option<&str>, id: &str) -> Digest {
    let mut hasher = ContentHasher::default();
    match before {
        Some(before) => hasher.name("follows").name(before),
        None => hasher.name("is first"),
    };
    hasher.name(id);
    hasher.finish_digest()
}

/// Takes as long as the index is large.
impl<T> Index<usize> for Objects<T> {
    type Output = T;

    fn index(&self, index: usize) -> &T {
        let length = self.len();
        self.iter()
            .nth(index)
            .unwrap_or_else(|| panic!("index {index} of {length} objects"))
    }
}

impl<'a, T> IntoIterator for &'a Objects<T> {
    type Item = &'a T;
    type IntoIter = Iter<'a, T>;

    fn into_iter(self) -> Iter<'a, T> {
        Iter(self.in_order.iter())
    }
}

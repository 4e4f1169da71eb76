//! What a scene says of names and pairs of names, with what its content hash is made of.

use std::sync::Arc;

use rpds::{RedBlackTreeMapSync, RedBlackTreeSetSync};

use crate::hash::{ContentHasher, Digest, FactSum};
use crate::math::Pose;

/// What makes a key or a value what it is.
pub(super) trait Content {
    /// Adds it.
    fn tell(&self, hasher: &mut ContentHasher);
}

impl Content for Arc<str> {
    fn tell(&self, hasher: &mut ContentHasher) {
        hasher.name(self);
    }
}

impl Content for f64 {
    fn tell(&self, hasher: &mut ContentHasher) {
        hasher.floats(&[*self]);
    }
}

impl Content for Pose {
    fn tell(&self, hasher: &mut ContentHasher) {
        hasher.pose(self);
    }
}

/// Values by key. Cloning it costs nothing; changing a clone costs the logarithm of its length.
#[derive(Clone, Debug)]
pub(super) struct Table<K: Ord, V> {
    values: RedBlackTreeMapSync<K, V>,
    facts: FactSum,
}

impl<K: Ord, V> Default for Table<K, V> {
    fn default() -> Self {
        Self {
            values: RedBlackTreeMapSync::new_sync(),
            facts: FactSum::default(),
        }
    }
}

impl<K: Ord + Content, V: Content> Table<K, V> {
    pub fn get<Q: Ord + ?Sized>(&self, key: &Q) -> Option<&V>
    where
        K: std::borrow::Borrow<Q>,
    {
        self.values.get(key)
    }

    pub fn iter(&self) -> impl Iterator<Item = (&K, &V)> {
        self.values.iter()
    }

    /// Those from a key on, in order.
    pub fn from(&self, key: K) -> impl Iterator<Item = (&K, &V)> {
        self.values.range(key..)
    }

    /// Gives a key another value, or none.
    pub fn set(&mut self, key: K, value: Option<V>) {
        if let Some(old) = self.values.get(&key) {
            self.facts.subtract(&fact(&key, old));
            if value.is_none() {
                self.values.remove_mut(&key);
            }
        }
        if let Some(value) = value {
            self.facts.add(&fact(&key, &value));
            self.values.insert_mut(key, value);
        }
    }

    /// Whether both tables are one in memory; those that are not may still be equal.
    pub fn is(&self, other: &Self) -> bool {
        self.values.ptr_eq(&other.values)
    }

    /// What the table's content hash is made of.
    pub fn facts(&self) -> &FactSum {
        &self.facts
    }
}

fn fact(key: &impl Content, value: &impl Content) -> Digest {
    let mut hasher = ContentHasher::default();
    key.tell(&mut hasher);
    value.tell(&mut hasher);
    hasher.finish_digest()
}

/// What a scene says of two links or objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// They may touch.
    Allowed,
    /// They are checked against each other, whatever allows them to touch.
    Forbidden,
}

/// A verdict, and how it was told.
#[derive(Clone, Copy, Debug)]
struct Told {
    verdict: Verdict,
    /// Counts all that was told before.
    number: u64,
    /// The lesser name came second.
    is_turned: bool,
}

impl Content for Told {
    fn tell(&self, hasher: &mut ContentHasher) {
        hasher.count(self.verdict as usize);
    }
}

/// Two names, the lesser first.
type Pair = (Arc<str>, Arc<str>);

impl Content for Pair {
    fn tell(&self, hasher: &mut ContentHasher) {
        hasher.name(&self.0).name(&self.1);
    }
}

impl Told {
    fn names<'a>(&self, (a, b): &'a Pair) -> (&'a str, &'a str) {
        if self.is_turned { (b, a) } else { (a, b) }
    }
}

fn pair(a: &str, b: &str) -> Pair {
    (a.min(b).into(), a.max(b).into())
}

/// Verdicts on pairs of names, whichever of the two comes first.
#[derive(Clone, Debug, Default)]
pub(super) struct Verdicts {
    of_pairs: Table<Pair, Told>,
    told: u64,
    /// For each name, those that it makes a pair with.
    partners: RedBlackTreeMapSync<Arc<str>, RedBlackTreeSetSync<Arc<str>>>,
}

impl Verdicts {
    /// Pairs with their verdicts, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str, Verdict)> {
        self.of_pairs.iter().map(|(pair, told)| {
            let (a, b) = told.names(pair);
            (a, b, told.verdict)
        })
    }

    /// What is said of a pair.
    pub fn get(&self, a: &str, b: &str) -> Option<Verdict> {
        self.of_pairs
            .get(&pair(a, b))
            .map(|told| told.verdict)
    }

    /// Says something else of a pair, or nothing.
    pub fn set(&mut self, a: &str, b: &str, verdict: Option<Verdict>) {
        if self.get(a, b) == verdict {
            return;
        }
        let pair = pair(a, b);
        for (name, partner) in [(&pair.0, &pair.1), (&pair.1, &pair.0)] {
            let mut partners = self
                .partners
                .get(name)
                .cloned()
                .unwrap_or_else(RedBlackTreeSetSync::new_sync);
            match verdict {
                Some(_) => partners.insert_mut(partner.clone()),
                None => {
                    partners.remove_mut(partner);
                }
            }
            if partners.is_empty() {
                self.partners.remove_mut(name);
            } else {
                self.partners.insert_mut(name.clone(), partners);
            }
        }
        let told = |verdict| Told {
            verdict,
            number: self.told,
            is_turned: a > b,
        };
        self.of_pairs.set(pair, verdict.map(told));
        self.told += 1;
    }

    /// Pairs of a verdict as they were told, one after the other.
    pub fn as_told(&self, verdict: Verdict) -> Vec<(&str, &str)> {
        let mut all: Vec<_> = self
            .of_pairs
            .iter()
            .filter(|(_, told)| told.verdict == verdict)
            .collect();
        all.sort_by_key(|(_, told)| told.number);
        all.into_iter()
            .map(|(pair, told)| told.names(pair))
            .collect()
    }

    /// Says nothing any more of the pairs that a name is in.
    pub fn forget(&mut self, name: &str) {
        for partner in self
            .partners
            .get(name)
            .cloned()
            .iter()
            .flatten()
        {
            self.set(name, partner, None);
        }
    }

    /// Whether both are one in memory; those that are not may still be equal.
    pub fn is(&self, other: &Self) -> bool {
        self.of_pairs.is(&other.of_pairs)
    }

    /// What the content hash is made of.
    pub fn facts(&self) -> &FactSum {
        self.of_pairs.facts()
    }
}

//! What was proved in a request: a segment that comes again, in a later path or in the answer's
//! certificate, is not proved again.

use std::collections::HashMap;

use super::SegmentProof;

/// Numbers that a ledger may hold before it starts anew, 8 MB of them.
const CAPACITY: usize = 1 << 20;

/// Proofs by the exact bits of the two configurations.
#[derive(Debug, Default)]
pub struct Ledger {
    entries: HashMap<u64, Entry>,
    /// Both ends of every segment that was remembered, one after the other.
    ends: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    /// First number in `ends`.
    first: usize,
    proof: SegmentProof,
}

impl Ledger {
    /// Forgets everything, but keeps its memory.
    pub fn clear(&mut self) {
        self.entries.clear();
        self.ends.clear();
    }

    /// The proof of a segment, if it is remembered.
    pub fn get(&self, from: &[f64], to: &[f64]) -> Option<SegmentProof> {
        let entry = self.entries.get(&key(from, to))?;
        let (first, second) = self.ends(entry, from.len())?;
        // Two segments may have one key: the bits decide.
        (same(first, from) && same(second, to)).then_some(entry.proof)
    }

    /// Both ends of a segment that is remembered, of so many numbers each.
    fn ends(&self, entry: &Entry, nq: usize) -> Option<(&[f64], &[f64])> {
        let ends = self
            .ends
            .get(entry.first..entry.first + 2 * nq)?;
        Some(ends.split_at(nq))
    }

    /// Remembers a proof.
    pub fn insert(&mut self, from: &[f64], to: &[f64], proof: SegmentProof) {
        if self.ends.len() > CAPACITY {
            self.clear();
        }
        let first = self.ends.len();
        self.ends.extend_from_slice(from);
        self.ends.extend_from_slice(to);
        self.entries
            .insert(key(from, to), Entry { first, proof });
    }
}

fn same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len()
        && a.iter()
            .zip(b)
            .all(|(a, b)| a.to_bits() == b.to_bits())
}

/// FNV-1a over the words; only a way to find the entry, whose bits are compared.
fn key(from: &[f64], to: &[f64]) -> u64 {
    from.iter()
        .chain(to)
        .fold(0xcbf2_9ce4_8422_2325, mix)
}

fn mix(hash: u64, x: &f64) -> u64 {
    let mixed = (hash ^ x.to_bits()).wrapping_mul(0x0000_0100_0000_01b3);
    mixed.rotate_left(29)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_same_bits_in_the_same_order_are_found() {
        let mut ledger = Ledger::default();
        let proof = SegmentProof {
            clearance_m: 0.5,
            intervals: 3,
        };
        ledger.insert(&[0.0, 1.0], &[2.0, 3.0], proof);
        assert_eq!(ledger.get(&[0.0, 1.0], &[2.0, 3.0]), Some(proof));
        assert_eq!(ledger.get(&[2.0, 3.0], &[0.0, 1.0]), None);
        assert_eq!(ledger.get(&[-0.0, 1.0], &[2.0, 3.0]), None);
        ledger.clear();
        assert_eq!(ledger.get(&[0.0, 1.0], &[2.0, 3.0]), None);
    }

    #[test]
    fn a_full_ledger_starts_anew() {
        let mut ledger = Ledger::default();
        let proof = SegmentProof {
            clearance_m: 0.5,
            intervals: 1,
        };
        let row = vec![0.25; CAPACITY];
        ledger.insert(&row, &row, proof);
        ledger.insert(&[1.0], &[2.0], proof);
        assert_eq!(ledger.get(&row, &row), None);
        assert_eq!(ledger.get(&[1.0], &[2.0]), Some(proof));
    }
}

//! Things that hang together, by union and find.

/// Members in parts; each part is named by its least member.
pub(super) struct Parts {
    parent: Vec<usize>,
}

impl Parts {
    /// Each member a part of its own.
    pub(super) fn apart(count: usize) -> Self {
        Self {
            parent: (0..count).collect(),
        }
    }

    /// The part of a member.
    pub(super) fn of(&mut self, mut member: usize) -> usize {
        while self.parent[member] != member {
            self.parent[member] = self.parent[self.parent[member]];
            member = self.parent[member];
        }
        member
    }

    /// Makes one part of those of the members.
    pub(super) fn join(&mut self, members: impl Iterator<Item = usize>) {
        members.reduce(|one, other| self.join_two(one, other));
    }

    fn join_two(&mut self, one: usize, other: usize) -> usize {
        let parts = [self.of(one), self.of(other)];
        let least = parts[0].min(parts[1]);
        parts
            .into_iter()
            .for_each(|part| self.parent[part] = least);
        least
    }
}

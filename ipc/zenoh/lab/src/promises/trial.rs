//! How long and how often to measure.

/// Which form to run, and from which seed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trial {
    /// The long form.
    pub long: bool,
    /// The seed.
    pub seed: u64,
}

impl Trial {
    /// What the form asks for.
    pub(crate) fn pick<T>(&self, short: T, long: T) -> T {
        if self.long { long } else { short }
    }
}

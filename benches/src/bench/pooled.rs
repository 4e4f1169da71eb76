//! Sets that belong together.

use std::collections::BTreeMap;

/// Names of sets that share the part before the first `_`, where there are at least two of them.
pub(super) fn groups<'a>(sets: impl Iterator<Item = &'a str>) -> BTreeMap<&'a str, Vec<&'a str>> {
    let mut groups: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for set in sets {
        if let Some((family, _)) = set.split_once('_') {
            groups.entry(family).or_default().push(set);
        }
    }
    groups.retain(|_, sets| sets.len() > 1);
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn families_are_what_stands_before_the_first_underscore() {
        let sets = ["hpp_disc", "hpp_ur5_table", "mbm_panda", "own", "own2"];
        assert_eq!(
            groups(sets.into_iter()),
            BTreeMap::from([("hpp", vec!["hpp_disc", "hpp_ur5_table"])])
        );
    }
}

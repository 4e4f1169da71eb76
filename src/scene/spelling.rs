//! Fields that a text has and its format does not: the refusal names the one that may be meant.

/// What a reader says of an unknown field, with the known one nearest to it instead of the list of
/// all; anything else as it is.
pub(crate) fn with_nearest(said: &str) -> String {
    let Some((before, rest)) = said.split_once("unknown field `") else {
        return said.to_owned();
    };
    let Some((field, rest)) = rest.split_once("`, expected ") else {
        return said.to_owned();
    };
    let (list, place) = rest.split_at(rest.find(" at line ").unwrap_or(rest.len()));
    let names = list
        .strip_prefix("one of ")
        .unwrap_or(list)
        .split(", ")
        .flat_map(|names| names.split(" or "));
    let known: Vec<&str> = names
        .map(|name| name.trim_matches('`'))
        .collect();
    match nearest(field, &known) {
        Some(near) => format!("{before}unknown field {field:?}, did you mean `{near}`{place}"),
        None => format!(
            "{before}unknown field {field:?}; known: {}{place}",
            known.join(", ")
        ),
    }
}

/// The word that another one may be meant for: at most a third of its letters differ.
fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let word = word.to_lowercase();
    let distance = |known: &str| strsim::damerau_levenshtein(&word, &known.to_lowercase());
    let near = known
        .iter()
        .copied()
        .min_by_key(|known| distance(known))?;
    (distance(near) <= near.chars().count().div_ceil(3)).then_some(near)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_known_field_is_named_and_the_place_stays() {
        let said = "unknown field `primitves`, expected one of `id`, `primitives`, `primitive_poses` at line 1 column 9";
        let told = "unknown field \"primitves\", did you mean `primitives` at line 1 column 9";
        assert_eq!(with_nearest(said), told);
        let said = "line 3: unknown field `colour`, expected `x` or `y`";
        assert_eq!(
            with_nearest(said),
            "line 3: unknown field \"colour\"; known: x, y"
        );
        assert_eq!(
            with_nearest("missing field `id` at line 1 column 2"),
            "missing field `id` at line 1 column 2"
        );
    }
}

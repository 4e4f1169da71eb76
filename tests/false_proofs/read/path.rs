//! Exported paths: what a controller's loader would find in them.

/// Columns and rows of a CSV.
pub fn csv(text: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut lines = text
        .lines()
        .filter(|line| !line.starts_with('#') && !line.trim().is_empty());
    let header = lines
        .next()
        .unwrap_or_default()
        .split(',')
        .map(|name| name.trim().to_owned())
        .collect();
    let number = |word: &str| word.trim().parse().expect("a number");
    (
        header,
        lines
            .map(|line| line.split(',').map(number).collect())
            .collect(),
    )
}

/// The same of an exported YAML trajectory.
pub fn yaml(text: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let list = |line: &str, key: &str| {
        let inner = line
            .trim()
            .trim_start_matches("- ")
            .strip_prefix(key)?
            .trim()
            .strip_prefix('[')?
            .strip_suffix(']')?;
        Some(
            inner
                .split(',')
                .map(|word| word.trim().trim_matches('"').to_owned())
                .collect::<Vec<String>>(),
        )
    };
    let names = text
        .lines()
        .find_map(|line| list(line, "joint_names:"))
        .unwrap_or_default();
    let number = |word: &String| word.parse().expect("a number");
    let rows = text
        .lines()
        .filter_map(|line| list(line, "positions:"));
    (
        names,
        rows.map(|row| row.iter().map(number).collect())
            .collect(),
    )
}

/// Rows with their columns in the order of `names`.
pub fn ordered(names: &[String], (columns, rows): (Vec<String>, Vec<Vec<f64>>)) -> Vec<Vec<f64>> {
    let place = |name: &String| {
        columns
            .iter()
            .position(|column| column == name)
            .expect("every column is exported")
    };
    let order: Vec<usize> = names.iter().map(place).collect();
    rows.iter()
        .map(|row| {
            order
                .iter()
                .map(|&column| row[column])
                .collect()
        })
        .collect()
}

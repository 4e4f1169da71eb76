//! Medians, quantiles, and how times are written.

/// The value below which this part of the others lies; 0 of none.
pub(crate) fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let index = (part * sorted.len() as f64) as usize;
    sorted
        .get(index.min(sorted.len().saturating_sub(1)))
        .copied()
        .unwrap_or(0.0)
}

/// The middle value; 0 of none.
pub(crate) fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// `a ÷ b`; as much as there can be where b is 0 and a is not.
pub(crate) fn ratio(a: f64, b: f64) -> f64 {
    match (a, b) {
        (0.0, 0.0) => 1.0,
        (_, 0.0) => f64::MAX,
        _ => a / b,
    }
}

/// Seconds for people.
pub(crate) fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.0} us", s * 1e6),
        s if s < 1.0 => format!("{:.3} ms", s * 1e3),
        s => format!("{s:.2} s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values() {
        let values = [3.0, 1.0, 2.0, 4.0];
        assert_eq!(
            [0.0, 0.5, 1.0].map(|part| quantile(&values, part)),
            [1.0, 3.0, 4.0]
        );
        assert_eq!(median(&[]), 0.0);
        assert_eq!(time(0.000_34), "340 us");
        assert_eq!(time(0.0123), "12.300 ms");
    }
}

//! Quantities on the command line, with their units.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::Duration;

/// Units of a length, and how many of each make a metre.
const LENGTHS: [(&str, f64); 4] = [("mm", 1e3), ("cm", 1e2), ("m", 1.0), ("", 1.0)];
/// Units of a time, and how many of each make a second.
const TIMES: [(&str, f64); 3] = [("ms", 1e3), ("us", 1e6), ("s", 1.0)];

/// A length: `0.1mm`, `1cm`, `0.001m`, or `0.001` in metres.
pub(super) fn metres(text: &str) -> Result<f64, String> {
    in_base_unit(text, &LENGTHS)
        .filter(|value| value.is_finite() && *value >= 0.0)
        .ok_or_else(|| {
            "give a length of at least 0 such as 0.1mm, 1cm or 0.001 (metres)".to_owned()
        })
}

/// A time: `20ms`, `1.5s` or `500us`.
pub(super) fn duration(text: &str) -> Result<Duration, String> {
    in_base_unit(text, &TIMES)
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
        .ok_or_else(|| "give a time such as 20ms, 1.5s or 500us".to_owned())
}

/// A number and its unit, the first one that its text ends with; `None` where it has no such.
fn in_base_unit(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let (number, per_base) = units
        .iter()
        .find_map(|(unit, per_base)| Some((text.strip_suffix(*unit)?, per_base)))?;
    // Dividing by 1000 rounds once; multiplying by 0.001 would round twice.
    Some(number.trim().parse::<f64>().ok()? / per_base)
}

/// `NAME=FOLDER`.
pub(super) fn package(text: &str) -> Result<(String, PathBuf), String> {
    match text.split_once('=') {
        Some((name, folder)) if !name.is_empty() && !folder.is_empty() => {
            Ok((name.to_owned(), folder.into()))
        }
        _ => Err("give NAME=FOLDER".to_owned()),
    }
}

/// Numbers and ranges of numbers, both ends included.
pub(super) type Numbers = Vec<RangeInclusive<usize>>;

/// `0,3,7-9`.
pub(super) fn numbers(text: &str) -> Result<Numbers, String> {
    text.split(',')
        .map(range)
        .collect::<Option<_>>()
        .ok_or_else(|| "give numbers and ranges from 0 on such as 0,3,7-9".to_owned())
}

/// `3` or `7-9`.
fn range(part: &str) -> Option<RangeInclusive<usize>> {
    let number = |text: &str| text.trim().parse::<usize>().ok();
    let (first, last) = part.split_once('-').unwrap_or((part, part));
    Some(number(first)?..=number(last)?).filter(|range| !range.is_empty())
}

/// `NAME=VALUE`.
pub(super) fn value(text: &str) -> Result<(String, f64), String> {
    named(text, |value| value.is_finite())
        .ok_or_else(|| "give NAME=VALUE, the value in rad or m".to_owned())
}

/// `NAME=WEIGHT`.
pub(super) fn weight(text: &str) -> Result<(String, f64), String> {
    let is_weight = |weight: f64| weight.is_finite() && weight > 0.0;
    named(text, is_weight)
        .ok_or_else(|| "give NAME=WEIGHT, the weight finite and greater than 0".to_owned())
}

fn named(text: &str, is_valid: impl Fn(f64) -> bool) -> Option<(String, f64)> {
    let (name, number) = text.split_once('=')?;
    let number = number
        .trim()
        .parse()
        .ok()
        .filter(|number| is_valid(*number))?;
    (!name.is_empty()).then(|| (name.to_owned(), number))
}

/// Packages as a map; a later one of the same name wins.
pub(super) fn packages(list: &[(String, PathBuf)]) -> BTreeMap<String, PathBuf> {
    list.iter().cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_are_read_with_their_units() {
        assert_eq!(metres("0.1mm"), Ok(1e-4));
        assert_eq!(metres("1 cm"), Ok(0.01));
        assert_eq!((metres("0.001"), metres("0.001m")), (Ok(1e-3), Ok(1e-3)));
        assert!(
            ["", "mm", "-1mm", "NaN", "1 inch", "inf"]
                .iter()
                .all(|text| metres(text).is_err())
        );
        assert_eq!(duration("20ms"), Ok(Duration::from_millis(20)));
        assert_eq!(duration("1.5s"), Ok(Duration::from_millis(1500)));
        assert_eq!(duration("500us"), Ok(Duration::from_micros(500)));
        assert_eq!(numbers("0,3, 7-9"), Ok(vec![0..=0, 3..=3, 7..=9]));
        assert!(
            ["", "1,", "-1", "3-2", "a", "1-2-3", "1.5"]
                .iter()
                .all(|text| numbers(text).is_err())
        );
        assert_eq!(value("lift=-0.25"), Ok(("lift".to_owned(), -0.25)));
        assert_eq!(weight("lift=2"), Ok(("lift".to_owned(), 2.0)));
        assert!(
            ["lift", "=1", "lift=", "lift=x", "lift=inf"]
                .iter()
                .all(|text| value(text).is_err())
        );
        assert!(
            ["lift=0", "lift=-1", "lift=NaN"]
                .iter()
                .all(|text| weight(text).is_err())
        );
        assert!(
            ["20", "", "s", "-1s", "1e30s", "NaNs"]
                .iter()
                .all(|text| duration(text).is_err())
        );
    }
}

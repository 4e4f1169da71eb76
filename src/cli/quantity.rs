//! Quantities on the command line, with their units.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

/// A length: `0.1mm`, `1cm`, `0.001m`, or `0.001` in metres.
pub(super) fn metres(text: &str) -> Result<f64, String> {
    let expected = "give a length of at least 0 such as 0.1mm, 1cm or 0.001 (metres)";
    let (number, per_metre) = match text {
        _ if text.ends_with("mm") => (&text[..text.len() - 2], 1e3),
        _ if text.ends_with("cm") => (&text[..text.len() - 2], 1e2),
        _ => (text.strip_suffix('m').unwrap_or(text), 1.0),
    };
    // Dividing by 1000 rounds once; multiplying by 0.001 would round twice.
    let value = number.trim().parse::<f64>().ok().map(|value| value / per_metre);
    value.filter(|value| value.is_finite() && *value >= 0.0).ok_or_else(|| expected.to_owned())
}

/// A time: `20ms`, `1.5s` or `500us`.
pub(super) fn duration(text: &str) -> Result<Duration, String> {
    let expected = "give a time such as 20ms, 1.5s or 500us";
    let (number, per_second) = match text {
        _ if text.ends_with("ms") => (&text[..text.len() - 2], 1e3),
        _ if text.ends_with("us") => (&text[..text.len() - 2], 1e6),
        _ => (text.strip_suffix('s').ok_or(expected)?, 1.0),
    };
    let seconds = number.trim().parse::<f64>().map_err(|_| expected.to_owned())? / per_second;
    Duration::try_from_secs_f64(seconds).map_err(|_| expected.to_owned())
}

/// `NAME=FOLDER`.
pub(super) fn package(text: &str) -> Result<(String, PathBuf), String> {
    match text.split_once('=') {
        Some((name, folder)) if !name.is_empty() && !folder.is_empty() => Ok((name.to_owned(), folder.into())),
        _ => Err("give NAME=FOLDER".to_owned()),
    }
}

/// Packages as a map; a later one of the same name wins.
pub(super) fn packages(list: &[(String, PathBuf)]) -> BTreeMap<String, PathBuf> {
    list.iter().cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_and_times_have_units() {
        assert_eq!(metres("0.1mm"), Ok(1e-4));
        assert_eq!(metres("1 cm"), Ok(0.01));
        assert_eq!((metres("0.001"), metres("0.001m")), (Ok(1e-3), Ok(1e-3)));
        assert!(["", "mm", "-1mm", "NaN", "1 inch", "inf"].iter().all(|text| metres(text).is_err()));
        assert_eq!(duration("20ms"), Ok(Duration::from_millis(20)));
        assert_eq!(duration("1.5s"), Ok(Duration::from_millis(1500)));
        assert_eq!(duration("500us"), Ok(Duration::from_micros(500)));
        assert!(["20", "", "s", "-1s", "1e30s", "NaNs"].iter().all(|text| duration(text).is_err()));
    }
}

//! Values on the command line: quantities with their units, names.

use std::path::PathBuf;
use std::time::Duration;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use taut::optimize::Mode;

/// A mode by its name.
pub(crate) fn mode() -> impl TypedValueParser<Value = Mode> {
    PossibleValuesParser::new(Mode::ALL.map(Mode::name)).map(|name| named_mode(&name))
}

fn named_mode(name: &str) -> Mode {
    Mode::ALL
        .into_iter()
        .find(|mode| mode.name() == name)
        .unwrap_or_default()
}

/// A length: `0.1mm`, `1cm`, `0.001m`, or `0.001` in metres.
pub(crate) fn metres(text: &str) -> Result<f64, String> {
    // Dividing by 1000 rounds once; multiplying by 0.001 would round twice.
    scaled(text, &[("mm", 1e3), ("cm", 1e2), ("m", 1.0), ("", 1.0)])
        .filter(|value| value.is_finite() && *value >= 0.0)
        .ok_or_else(|| {
            "give a length of at least 0 such as 0.1mm, 1cm or 0.001 (metres)".to_owned()
        })
}

/// A time: `20ms`, `1.5s` or `500us`.
pub(crate) fn duration(text: &str) -> Result<Duration, String> {
    scaled(text, &[("ms", 1e3), ("us", 1e6), ("s", 1.0)])
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
        .ok_or_else(|| "give a time such as 20ms, 1.5s or 500us".to_owned())
}

/// The number before the first of these units that the text ends with, divided by its factor.
fn scaled(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let (number, factor) = units
        .iter()
        .find_map(|(unit, factor)| Some((text.strip_suffix(unit)?, factor)))?;
    Some(number.trim().parse::<f64>().ok()? / factor)
}

/// `NAME=FOLDER`.
pub(crate) fn package(text: &str) -> Result<(String, PathBuf), String> {
    match text.split_once('=') {
        Some((name, folder)) if !name.is_empty() && !folder.is_empty() => {
            Ok((name.to_owned(), folder.into()))
        }
        _ => Err("give NAME=FOLDER".to_owned()),
    }
}

/// Requests per second.
pub(crate) fn rate(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|rate: &f64| rate.is_finite() && *rate > 0.0)
        .ok_or_else(|| "give requests per second, more than 0".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_are_read_with_their_units() {
        assert_eq!(metres("0.1mm"), Ok(1e-4));
        assert_eq!(metres("1 cm"), Ok(0.01));
        assert_eq!((metres("0.001"), metres("0.001m")), (Ok(1e-3), Ok(1e-3)));
        for text in ["", "mm", "-1mm", "NaN", "1 inch", "inf"] {
            assert!(metres(text).is_err(), "{text}");
        }
        assert_eq!(duration("20ms"), Ok(Duration::from_millis(20)));
        assert_eq!(duration("1.5s"), Ok(Duration::from_millis(1500)));
        assert_eq!(duration("500us"), Ok(Duration::from_micros(500)));
        for text in ["20", "", "s", "-1s", "1e30s", "NaNs"] {
            assert!(duration(text).is_err(), "{text}");
        }
        assert!(rate("0").is_err() && rate("inf").is_err() && rate("1.5") == Ok(1.5));
    }
}

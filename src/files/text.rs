//! Bytes of a file as text: the encoding that a byte order mark, an XML declaration or the bytes
//! themselves tell.

use std::path::Path;

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

use super::FileError;

/// The text of a file: UTF-8, unless it begins with the byte order mark of UTF-16.
///
/// # Errors
/// A file that cannot be read, or is in another encoding.
pub(super) fn read(file: &Path) -> Result<String, FileError> {
    let bytes = bytes(file)?;
    let encoding = Encoding::for_bom(&bytes).map_or(UTF_8, |(encoding, _)| encoding);
    decoded(&bytes, encoding).map_err(|text| FileError::content(file, text))
}

fn bytes(file: &Path) -> Result<Vec<u8>, FileError> {
    std::fs::read(file).map_err(|error| FileError::Unreadable {
        file: file.to_owned(),
        reason: error.to_string(),
    })
}

/// The text of an XML file, in whatever encoding it says it has; and what is odd about that.
///
/// # Errors
/// Bytes that are not in the encoding that they say.
pub(super) fn xml(bytes: &[u8]) -> Result<(String, Option<String>), String> {
    if let Some((encoding, _)) = Encoding::for_bom(bytes) {
        return Ok((decoded(bytes, encoding)?, None));
    }
    match bytes {
        [b'<', 0, ..] => return Ok((decoded(bytes, UTF_16LE)?, None)),
        [0, b'<', ..] => return Ok((decoded(bytes, UTF_16BE)?, None)),
        _ => {}
    }
    let label = declared(bytes);
    let encoding = match label {
        None => UTF_8,
        Some(label) => Encoding::for_label(label).ok_or_else(|| {
            let label = String::from_utf8_lossy(label);
            format!("line 1: the encoding {label:?} is unknown; save the file as UTF-8 and say so: encoding=\"UTF-8\"")
        })?,
    };
    // A declaration in plain letters cannot be one of UTF-16.
    let encoding = if [UTF_16LE, UTF_16BE].contains(&encoding) {
        UTF_8
    } else {
        encoding
    };
    match decoded(bytes, encoding) {
        Ok(text) => Ok((text, None)),
        // Readers of robots do not look at what a comment is made of.
        Err(error) if encoding == UTF_8 => {
            let text = format!(
                "{error}; it is read as ISO-8859-1: save it as UTF-8, or declare its encoding"
            );
            Ok((decoded(bytes, WINDOWS_1252)?, Some(text)))
        }
        Err(error) => Err(error),
    }
}

/// The encoding that an XML declaration names.
fn declared(bytes: &[u8]) -> Option<&[u8]> {
    let bytes = bytes.trim_ascii_start();
    if !bytes.starts_with(b"<?xml") {
        return None;
    }
    let end = bytes.windows(2).position(|two| two == b"?>")?;
    let declaration = &bytes[..end];
    let name = b"encoding";
    let at = declaration
        .windows(name.len())
        .position(|word| word == name)?;
    let rest = declaration[at + name.len()..]
        .trim_ascii_start()
        .strip_prefix(b"=")?
        .trim_ascii_start();
    let (quote, rest) = rest.split_first()?;
    rest.split(|byte| byte == quote).next()
}

fn decoded(bytes: &[u8], encoding: &'static Encoding) -> Result<String, String> {
    let (text, encoding, has_errors) = encoding.decode(bytes);
    if !has_errors {
        return Ok(text.into_owned());
    }
    let before = text
        .split('\u{fffd}')
        .next()
        .unwrap_or_default();
    let line = before.matches('\n').count() + 1;
    Err(format!("line {line} is not {}", encoding.name()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "<robot name=\"Jörg\"/>\n";

    fn utf_16(text: &str, to: fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(to).collect()
    }

    #[test]
    fn an_encoding_is_found_by_mark_declaration_or_bytes() {
        let latin = |text: &str| {
            text.chars()
                .map(|c| c as u8)
                .collect::<Vec<u8>>()
        };
        let declared =
            |label: &str| format!("\n<?xml version='1.0' encoding = \"{label}\" ?>{TEXT}");
        for bytes in [
            TEXT.as_bytes().to_vec(),
            [b"\xef\xbb\xbf", TEXT.as_bytes()].concat(),
            utf_16(TEXT, u16::to_le_bytes),
            utf_16(TEXT, u16::to_be_bytes),
            utf_16(&format!("\u{feff}{TEXT}"), u16::to_le_bytes),
            latin(&declared("ISO-8859-1")),
            latin(&declared("latin1")),
            declared("utf-8").into_bytes(),
            // Written by a program that says what it does not do.
            declared("UTF-16").into_bytes(),
        ] {
            let (text, odd) = xml(&bytes).unwrap();
            assert!(text.ends_with(TEXT) && odd.is_none(), "{text:?}, {odd:?}");
        }
        let (text, odd) = xml(&latin(&format!("\n{TEXT}"))).unwrap();
        assert!(
            text.ends_with(TEXT)
                && odd
                    .clone()
                    .unwrap()
                    .starts_with("line 2 is not UTF-8"),
            "{odd:?}"
        );
        let error = xml(&latin(&declared("klingon"))).unwrap_err();
        assert!(
            error.contains("\"klingon\"") && error.contains("UTF-8"),
            "{error}"
        );
    }
}

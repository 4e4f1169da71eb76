//! Sections of a payload as they are laid out and read, in place.

use super::{Section, WireError};
use crate::limits::{MAX_TEXT, PAYLOAD_ALIGN};
use bytemuck::Pod;

/// The bytes of a section of `limit` entries at most, each `size` bytes.
pub(crate) fn section_bytes<'a>(
    payload: &'a [u8],
    name: &'static str,
    section: Section,
    size: usize,
    limit: usize,
) -> Result<&'a [u8], WireError> {
    let offset = section.offset as usize;
    let count = section.count as usize;
    if count == 0 {
        return Ok(&[]);
    }
    if count > limit {
        return Err(WireError::SectionLimit {
            section: name,
            found: count,
            limit,
        });
    }
    let out_of_bounds = WireError::SectionBounds {
        section: name,
        offset: section.offset,
        count: section.count,
        payload: payload.len(),
    };
    let end = count
        .checked_mul(size)
        .and_then(|bytes| bytes.checked_add(offset));
    match end.and_then(|end| payload.get(offset..end)) {
        Some(bytes) if offset.is_multiple_of(PAYLOAD_ALIGN) => Ok(bytes),
        _ => Err(out_of_bounds),
    }
}

/// A section as records, in place.
pub(crate) fn records<'a, T: Pod>(
    payload: &'a [u8],
    name: &'static str,
    section: Section,
    limit: usize,
) -> Result<&'a [T], WireError> {
    let bytes = section_bytes(payload, name, section, size_of::<T>(), limit)?;
    if bytes.is_empty() {
        // Its address need not be aligned.
        return Ok(&[]);
    }
    bytemuck::try_cast_slice(bytes).map_err(|_| WireError::SectionBounds {
        section: name,
        offset: section.offset,
        count: section.count,
        payload: payload.len(),
    })
}

/// A section as numbers, in place.
pub(crate) fn numbers<'a>(
    payload: &'a [u8],
    name: &'static str,
    section: Section,
    limit: usize,
) -> Result<&'a [f64], WireError> {
    records(payload, name, section, limit)
}

/// A section as text, in place.
pub(crate) fn text<'a>(
    payload: &'a [u8],
    name: &'static str,
    section: Section,
) -> Result<&'a str, WireError> {
    let bytes = section_bytes(payload, name, section, 1, MAX_TEXT)?;
    std::str::from_utf8(bytes).map_err(|_| WireError::Text(name))
}

pub(super) trait SliceOfOne<T> {
    fn as_slice_of_one(&self) -> &[T];
}

impl<T> SliceOfOne<T> for Option<&T> {
    fn as_slice_of_one(&self) -> &[T] {
        self.map_or(&[], std::slice::from_ref)
    }
}

pub(super) fn place_records<T>(end: &mut usize, entries: &[T]) -> Section {
    place(end, entries.len(), size_of::<T>())
}

/// Reserves `count` entries of `size` bytes behind `end`, 8-aligned. An absent section lies
/// nowhere.
pub(super) fn place(end: &mut usize, count: usize, size: usize) -> Section {
    if count == 0 {
        return Section::default();
    }
    let offset = end.next_multiple_of(PAYLOAD_ALIGN);
    *end = offset + count * size;
    Section {
        offset: offset as u32,
        count: count as u32,
    }
}

pub(super) fn put<T: Pod>(payload: &mut [u8], section: Section, entries: &[T]) {
    let bytes: &[u8] = bytemuck::cast_slice(entries);
    let start = section.offset as usize;
    payload[start..start + bytes.len()].copy_from_slice(bytes);
}

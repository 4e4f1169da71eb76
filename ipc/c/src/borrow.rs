//! What a caller points to. All reading and writing of foreign memory is here.

use crate::handle::wrong;
use std::ffi::{CStr, c_char};
use taut_ipc::planner::PlannerError;

/// A string that may be missing.
///
/// # Safety
/// NULL, or a string that ends with a zero and stays as it is during the call.
pub(crate) unsafe fn maybe_text(
    what: &str,
    text: *const c_char,
) -> Result<Option<String>, PlannerError> {
    if text.is_null() {
        return Ok(None);
    }
    // SAFETY: not null, and the caller gives a string that ends with a zero.
    let bytes = unsafe { CStr::from_ptr(text) };
    match bytes.to_str() {
        Ok(text) => Ok(Some(text.to_owned())),
        Err(error) => Err(wrong(format!(
            "{what} is no UTF-8: {error}; give names as UTF-8"
        ))),
    }
}

/// A string.
///
/// # Safety
/// As [`maybe_text`].
pub(crate) unsafe fn text(what: &str, text: *const c_char) -> Result<String, PlannerError> {
    // SAFETY: the caller's promise is the same.
    unsafe { maybe_text(what, text) }?.ok_or_else(|| wrong(format!("{what} is NULL; give a name")))
}

/// So many numbers or pointers; NULL is no array, but may be one of none.
///
/// # Safety
/// NULL, or `count` values that stay as they are during the call.
pub(crate) unsafe fn array<'a, T: Copy>(
    what: &str,
    first: *const T,
    count: usize,
) -> Result<&'a [T], PlannerError> {
    if count == 0 {
        return Ok(&[]);
    }
    if first.is_null() {
        return Err(wrong(format!(
            "{what} is NULL and should be {count} values"
        )));
    }
    if !first.is_aligned() || count > isize::MAX as usize / size_of::<T>().max(1) {
        return Err(wrong(format!(
            "{what} at {first:p} with {count} values is no array of this type"
        )));
    }
    // SAFETY: not null, aligned, not larger than memory, and the caller gives so many values.
    Ok(unsafe { std::slice::from_raw_parts(first, count) })
}

/// So many strings.
///
/// # Safety
/// As [`array`], each value as [`text`].
pub(crate) unsafe fn texts(
    what: &str,
    first: *const *const c_char,
    count: usize,
) -> Result<Vec<String>, PlannerError> {
    // SAFETY: the caller's promise is the same.
    let pointers = unsafe { array(what, first, count) }?;
    let text_of = |(index, pointer): (usize, &*const c_char)| {
        // SAFETY: the caller promises a string behind each.
        unsafe { text(&format!("{what}[{index}]"), *pointer) }
    };
    pointers
        .iter()
        .enumerate()
        .map(text_of)
        .collect()
}

/// Writes a result where the caller wants it, if anywhere.
///
/// # Safety
/// NULL, or memory of the caller's of this type, aligned.
pub(crate) unsafe fn give<T>(place: *mut T, value: T) {
    if !place.is_null() {
        // SAFETY: not null, and the caller's own; nothing that was there is dropped, C has no
        // destructors.
        unsafe { place.write(value) };
    }
}

/// Writes as much of a struct as the caller's header knows.
///
/// # Safety
/// NULL, or `size` bytes of the caller's.
pub(crate) unsafe fn give_sized<T: Copy>(place: *mut T, size: usize, value: T) {
    if place.is_null() {
        return;
    }
    let known = size.min(size_of::<T>());
    let bytes = place.cast::<u8>();
    // SAFETY: the caller gives `size` bytes; `known` of them are written from the value, the others
    // with zeros.
    unsafe {
        std::ptr::copy_nonoverlapping((&raw const value).cast::<u8>(), bytes, known);
        bytes.add(known).write_bytes(0, size - known);
    }
}

/// Refuses a place for a result that is missing.
pub(crate) fn needed<T>(what: &str, place: *mut T) -> Result<*mut T, PlannerError> {
    if place.is_null() {
        Err(wrong(format!(
            "{what} is NULL; give the place where it is to go"
        )))
    } else {
        Ok(place)
    }
}

/// A struct whose first field is the size that the caller's header gave it: what the caller does
/// not know has its default, what the caller knows and this library does not must be 0.
///
/// # Safety
/// NULL (all defaults), or a struct as large as its first field says. Every bit pattern is a `T`.
pub(crate) unsafe fn sized<T: Copy>(
    what: &str,
    given: *const T,
    default: T,
) -> Result<T, PlannerError> {
    if given.is_null() {
        return Ok(default);
    }
    // SAFETY: the first field of every such struct is its size.
    let size = unsafe { given.cast::<usize>().read_unaligned() };
    let known = size_of::<T>();
    if size < size_of::<usize>() || size > 16 * known {
        return Err(wrong(format!(
            "{what} says that it has {size} bytes; valid: {known}, which its function of defaults fills in"
        )));
    }
    // SAFETY: the caller gives so many bytes.
    let bytes = unsafe { std::slice::from_raw_parts(given.cast::<u8>(), size) };
    if bytes.iter().skip(known).any(|byte| *byte != 0) {
        return Err(wrong(format!(
            "{what} sets what this library does not know; use header and library of one release"
        )));
    }
    let mut value = default;
    // SAFETY: at most `known` bytes go into `value`, and every bit pattern is a value of these
    // structs of numbers and pointers.
    unsafe {
        std::ptr::copy_nonoverlapping(
            bytes.as_ptr(),
            (&raw mut value).cast::<u8>(),
            size.min(known),
        )
    };
    Ok(value)
}

//! What a request may say beyond robot, scene and path.

use crate::borrow::{give_sized, sized};
use crate::options_table::{DEFAULT, Options, enter_arrays, enter_flags, enter_numbers};
use taut_ipc::planner::{PlannerError, Request};

/// Fills in options with what a request means that says nothing more. `size` is sizeof *options.
///
/// # Safety
/// `options` points to `size` bytes, or is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_options_default(options: *mut Options, size: usize) {
    // SAFETY: the caller promises that it is NULL or its own, and so large.
    unsafe { give_sized(options, size, Options { size, ..DEFAULT }) };
}

/// The request that options mean.
///
/// # Safety
/// NULL, or options whose pointers lead where the header says.
pub(crate) unsafe fn request(
    robot: String,
    scene: Option<String>,
    options: *const Options,
) -> Result<Request, PlannerError> {
    // SAFETY: the caller promises that its size is right.
    let options = unsafe { sized("options", options, DEFAULT) }?;
    let mut request = Request {
        scene,
        ..Request::new(&robot, None)
    };
    enter_numbers(&options, &mut request)?;
    enter_flags(&options, &mut request)?;
    // SAFETY: the caller's promise is the same.
    unsafe { enter_arrays(&options, &mut request) }?;
    Ok(request)
}

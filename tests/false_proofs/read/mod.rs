//! The gate's own readers: of mesh files, against what they were written to say, and of exported
//! paths.

pub mod mesh;
pub mod path;

//! `taut-zenoh-lab client`, hidden: a process that asks as it is told, line by line.
pub(crate) fn run() -> Result<u8, crate::error::Error> { Ok(0) }

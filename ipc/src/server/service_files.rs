//! Files of the services, which daemons make and clients open.

use crate::instance::Instance;
use crate::memory::{SHM_FOLDER, of_instance};
use crate::services;
use std::path::{Path, PathBuf};

/// What the file of a service in `services` is called behind the point.
const STATIC: &str = "service";
/// What the memory of a service is called behind the point.
const DYNAMIC: &str = "dynamic";

/// Whether every service has its file and its memory. Only daemons make them, so there are none
/// that would not be needed.
pub(super) fn are_services_whole(instance: &Instance) -> bool {
    let files = static_files(instance);
    let memory = dynamic_files(instance);
    files.len() >= services::ALL.len() && memory.len() >= services::ALL.len()
}

/// The files of the services that name their settings.
pub(super) fn static_files(instance: &Instance) -> Vec<PathBuf> {
    let files = of_instance(instance, &instance.root().join("services"));
    with_extension(files, STATIC)
}

/// The memory of the services themselves, not of their ports.
pub(super) fn dynamic_files(instance: &Instance) -> Vec<PathBuf> {
    with_extension(of_instance(instance, Path::new(SHM_FOLDER)), DYNAMIC)
}

fn with_extension(mut files: Vec<PathBuf>, extension: &str) -> Vec<PathBuf> {
    files.retain(|file| {
        file.extension()
            .is_some_and(|it| it == extension)
    });
    files
}

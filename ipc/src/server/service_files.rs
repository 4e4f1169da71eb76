//! Files of the services, which daemons make and clients open.

use crate::instance::Instance;
use crate::memory::{SHM_FOLDER, of_instance};
use crate::services;
use std::path::{Path, PathBuf};

/// What the file of a service in `services` is called behind the point.
const STATIC: &str = "service";
/// What the memory of a service is called behind the point.
const DYNAMIC: &str = "dynamic";

/// Services that every client has open: all but the two that are published.
const OF_EVERY_CLIENT: usize = services::ALL.len() - 2;

/// Whether all services are there.
pub(super) fn are_all_there(instance: &Instance) -> bool {
    whole(instance) >= services::ALL.len()
}

/// Whether those are there that clients of a daemon that ended go on with.
pub(super) fn are_of_clients(instance: &Instance) -> bool {
    whole(instance) >= OF_EVERY_CLIENT
}

/// How many services are there, if each has its file and its memory; only daemons make them. 0 where
/// one has not.
fn whole(instance: &Instance) -> usize {
    let files = static_files(instance).len();
    match dynamic_files(instance).len() == files {
        true => files,
        false => 0,
    }
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

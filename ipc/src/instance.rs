//! Where a daemon and its clients meet: a name and a root folder.

use crate::limits::SOCKET_PATH_MAX;
use crate::wire::label_id;
use std::fs::{DirBuilder, Metadata, Permissions};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

/// Where POSIX shared memory lies on Linux.
pub const SHM_FOLDER: &str = "/dev/shm";

/// Environment variable that names the instance: `name`, `name:/root` or `:/root`.
pub const INSTANCE_VARIABLE: &str = "TAUT_INSTANCE";
/// Name of the instance when nobody says otherwise.
pub const DEFAULT_NAME: &str = "main";
/// Longest name of an instance, in bytes.
pub const NAME_MAX: usize = 24;

/// Digits of a port's id and the suffix of its socket, behind root and prefix.
const SOCKET_TAIL: usize = 39 + ".event".len();

/// Why an instance cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum InstanceError {
    /// The name has other characters or another length.
    #[error("instance name `{0}`: use 1 to {NAME_MAX} of a-z, 0-9, `_`, `-`")]
    Name(String),
    /// The root is no absolute path of plain UTF-8.
    #[error("instance root `{0}`: use an absolute path in UTF-8 without `..`")]
    Root(PathBuf),
    /// Sockets below this root would have too long a path.
    #[error(
        "instance root `{root}` has {found} bytes, with this name at most {limit} fit a socket's path; choose a shorter root, such as /dev/shm/taut"
    )]
    RootTooLong {
        /// The root.
        root: PathBuf,
        /// Its bytes.
        found: usize,
        /// Bytes it may have.
        limit: usize,
    },
    /// The root belongs to somebody else or is open to others.
    #[error(
        "instance root `{root}` has owner {uid} and mode {mode:o}, it has to belong to user {me} with mode 700; remove it or choose another root"
    )]
    RootNotPrivate {
        /// The root.
        root: PathBuf,
        /// Its owner.
        uid: u32,
        /// Its permission bits.
        mode: u32,
        /// The user of this process.
        me: u32,
    },
    /// A file of the instance cannot be made, opened or read.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// A name and a root folder; daemon and clients with equal ones find each other.
///
/// Everything the instance keeps in shared memory starts with [`Self::prefix`], everything else
/// lies below [`Self::root`]. Both differ between instances, so that one can be wiped without
/// touching another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Instance {
    name: String,
    root: PathBuf,
    prefix: String,
}

impl Instance {
    /// The instance `name` below `root`.
    ///
    /// # Errors
    /// [`InstanceError`] if the name or root cannot be used. Nothing is created yet.
    pub fn new(name: &str, root: impl Into<PathBuf>) -> Result<Self, InstanceError> {
        let root = root.into();
        let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "_-".contains(c);
        if name.is_empty() || name.len() > NAME_MAX || !name.chars().all(allowed) {
            return Err(InstanceError::Name(name.to_owned()));
        }
        let text = match root.to_str() {
            Some(text) if root.is_absolute() && !text.contains("..") => text.to_owned(),
            _ => return Err(InstanceError::Root(root)),
        };
        let identity = format!("{}:{name}:{text}", own_uid());
        let prefix = format!("taut-{name}-{:08x}.", label_id(&identity) as u32);
        let limit = SOCKET_PATH_MAX - 1 - prefix.len() - SOCKET_TAIL;
        if text.len() > limit {
            return Err(InstanceError::RootTooLong {
                root,
                found: text.len(),
                limit,
            });
        }
        Ok(Self {
            name: name.to_owned(),
            root,
            prefix,
        })
    }

    /// The instance `name` below the user's runtime folder.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn named(name: &str) -> Result<Self, InstanceError> {
        Self::new(name, default_root(name))
    }

    /// The instance that [`INSTANCE_VARIABLE`] names, else the default one.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn from_environment() -> Result<Self, InstanceError> {
        Self::parse(&std::env::var(INSTANCE_VARIABLE).unwrap_or_default())
    }

    /// The instance that a text names: `name`, `name:/root` or `:/root`; the default one if it is
    /// empty.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn parse(text: &str) -> Result<Self, InstanceError> {
        match text.split_once(':') {
            Some(("", root)) => Self::new(DEFAULT_NAME, root),
            Some((name, root)) => Self::new(name, root),
            None if text.is_empty() => Self::named(DEFAULT_NAME),
            None => Self::named(text),
        }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The folder of its sockets, lock and service files.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// How the names of its shared-memory files start. Ends with a dot, so that none is the start
    /// of another.
    pub fn prefix(&self) -> &str {
        &self.prefix
    }

    /// Creates the root, mode 700, or checks that an existing one is private.
    ///
    /// # Errors
    /// [`InstanceError::File`] if it cannot be made, [`InstanceError::RootNotPrivate`] if others
    /// may use it.
    pub fn prepare(&self) -> Result<(), InstanceError> {
        if !self.root.is_dir() {
            let made = DirBuilder::new()
                .recursive(true)
                .mode(0o700)
                .create(&self.root);
            // Set again: another thread's umask may have taken rights away.
            made.and_then(|()| std::fs::set_permissions(&self.root, Permissions::from_mode(0o700)))
                .map_err(|source| self.file_error(&self.root, source))?;
        }
        self.check_private()
    }

    /// As [`Self::prepare`], where the root was this user's alone until somebody removed it: a client
    /// that lives may have made it again meanwhile, for a socket, with rights of others.
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub fn prepare_again(&self) -> Result<(), InstanceError> {
        // Fails on somebody else's, which the check tells.
        let _ = std::fs::set_permissions(&self.root, Permissions::from_mode(0o700));
        self.prepare()
    }

    /// Checks that the root belongs to this user alone.
    pub(crate) fn check_private(&self) -> Result<(), InstanceError> {
        let meta = std::fs::metadata(&self.root);
        let meta: Metadata = meta.map_err(|source| self.file_error(&self.root, source))?;
        let uid = meta.uid();
        let mode = meta.permissions().mode() & 0o777;
        let me = own_uid();
        if uid != me || mode & 0o077 != 0 {
            return Err(InstanceError::RootNotPrivate {
                root: self.root.clone(),
                uid,
                mode,
                me,
            });
        }
        Ok(())
    }

    pub(crate) fn file_error(&self, path: &Path, source: std::io::Error) -> InstanceError {
        InstanceError::File {
            path: path.to_owned(),
            source,
        }
    }
}

/// `$XDG_RUNTIME_DIR/taut/<name>`, else `/dev/shm/taut-<uid>-<name>`, else the same in the folder
/// for temporary files. The latter folders are everybody's, so there the root is one level that can
/// be checked as a whole.
fn default_root(name: &str) -> PathBuf {
    let runtime = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    if let Some(dir) = runtime.filter(|dir| dir.is_absolute() && dir.is_dir()) {
        return dir.join("taut").join(name);
    }
    let shm = Path::new(SHM_FOLDER);
    let base = if shm.is_dir() {
        shm.to_owned()
    } else {
        std::env::temp_dir()
    };
    base.join(format!("taut-{}-{name}", own_uid()))
}

fn own_uid() -> u32 {
    rustix::process::geteuid().as_raw()
}

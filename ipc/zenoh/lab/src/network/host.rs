//! A host: a namespace, an address and a folder for its instances.

use std::fs::File;
use std::net::Ipv4Addr;
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};
use std::process::Command;

use rustix::thread::{LinkNameSpaceType, move_into_link_name_space};
use taut_ipc::own_daemon::Folder;
use taut_ipc::{INSTANCE_VARIABLE, Instance};

use super::namespace::Namespace;
use crate::error::Error;

/// Everything of it is gone when this is dropped, but for processes: they are dropped before.
#[derive(Debug)]
pub(crate) struct Host {
    name: String,
    address: Ipv4Addr,
    namespace: Namespace,
    /// Instances of different hosts meet in the machine's shared memory; by their roots they differ.
    folder: Folder,
    /// Folders of the other hosts, whose files it does not see.
    hidden: Vec<PathBuf>,
}

/// Starts a program where these folders, named before `--`, are empty. The mounts are those of
/// `ip netns exec` and go with the program.
const HIDE: &str =
    r#"while [ "$1" != -- ]; do mount -t tmpfs none "$1"; shift; done; shift; exec "$@""#;

impl Host {
    pub(super) fn create(name: &str, number: u8) -> Result<Self, Error> {
        Ok(Self {
            name: name.to_owned(),
            address: Ipv4Addr::new(10, 77, 0, number),
            namespace: Namespace::create(name)?,
            folder: Folder::create(&format!("lab-{name}"))?,
            hidden: Vec::new(),
        })
    }

    /// Lets its programs not see the files of others.
    pub(super) fn hide(&mut self, folders: &[PathBuf]) {
        let own = self.folder().to_owned();
        let others = folders.iter().filter(|folder| **folder != own);
        self.hidden = others.cloned().collect();
    }

    /// Its name.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Its address on every link.
    pub(crate) fn address(&self) -> Ipv4Addr {
        self.address
    }

    /// Its folder.
    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub(super) fn namespace(&self) -> &str {
        self.namespace.name()
    }

    /// An instance of this host's.
    pub(crate) fn instance(&self, name: &str) -> Result<Instance, Error> {
        Ok(Instance::new(name, self.folder().join(name))?)
    }

    /// A program on this host that finds this instance in its environment and ends with the thread
    /// that starts it.
    pub(crate) fn command(&self, program: &Path, instance: &Instance) -> Command {
        let mut command = Command::new("ip");
        command
            .args(["netns", "exec", self.namespace()])
            .args(["setpriv", "--pdeathsig", "KILL", "--"])
            .args(["sh", "-c", HIDE, "sh"])
            .args(&self.hidden)
            .arg("--")
            .arg(program)
            .current_dir(self.folder())
            .env(
                INSTANCE_VARIABLE,
                format!("{}:{}", instance.name(), instance.root().display()),
            );
        command
    }

    /// Does something as on this host: what it opens stays there.
    pub(crate) fn within<T: Send>(
        &self,
        work: impl FnOnce() -> std::io::Result<T> + Send,
    ) -> Result<T, Error> {
        let file = format!("/run/netns/{}", self.namespace());
        let enter = || {
            let namespace = File::open(&file)?;
            move_into_link_name_space(namespace.as_fd(), Some(LinkNameSpaceType::Network))?;
            work()
        };
        let done = std::thread::scope(|scope| {
            scope
                .spawn(enter)
                .join()
                .expect("what is done on a host does not panic")
        });
        done.map_err(|error| Error::Network {
            what: format!("host {}", self.name),
            reason: error.to_string(),
        })
    }
}

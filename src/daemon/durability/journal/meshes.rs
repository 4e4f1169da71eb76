//! Meshes on disk, each in a file under its content hash.

use std::collections::{BTreeSet, HashMap};
use std::fs::DirEntry;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Weak};

use taut::shape::Mesh;

use crate::daemon::durability::persisted::MeshRecord;

/// The folder of meshes.
pub(super) struct Meshes {
    folder: PathBuf,
    /// Those whose file is known to be there.
    written: BTreeSet<u64>,
    /// Those that were read: what uses one mesh shares it again.
    read: HashMap<u64, Weak<Mesh>>,
}

impl Meshes {
    /// The meshes of a folder, which is made when it is first needed.
    pub(super) fn new(folder: PathBuf) -> Self {
        Self {
            folder,
            written: BTreeSet::new(),
            read: HashMap::new(),
        }
    }

    fn file(&self, hash: u64) -> PathBuf {
        self.folder.join(format!("{hash:016x}"))
    }

    fn make_folder(&self) -> std::io::Result<()> {
        match std::fs::create_dir(&self.folder) {
            Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => Err(error),
            _ => Ok(()),
        }
    }

    /// Writes a mesh, unless its file is there.
    pub(super) fn keep(&mut self, mesh: &Mesh) -> Result<(), String> {
        if self.written.contains(&mesh.hash()) {
            return Ok(());
        }
        self.write(mesh.hash(), &encoded(mesh)?)?;
        self.written.insert(mesh.hash());
        Ok(())
    }

    fn write(&self, hash: u64, bytes: &[u8]) -> Result<(), String> {
        let file = self.file(hash);
        let new = self.folder.join("new");
        let written = self
            .make_folder()
            .and_then(|()| std::fs::write(&new, bytes))
            .and_then(|()| std::fs::rename(&new, &file));
        written.map_err(|error| {
            let _ = std::fs::remove_file(&new);
            format!("{}: {error}", file.display())
        })
    }

    /// Reads a mesh; one that is not what its name says is refused.
    pub(super) fn find(&mut self, hash: u64) -> Result<Arc<Mesh>, String> {
        if let Some(mesh) = self.read.get(&hash).and_then(Weak::upgrade) {
            return Ok(mesh);
        }
        let file = self.file(hash);
        let mesh = read(&file, hash).map_err(|reason| format!("{}: {reason}", file.display()))?;
        let mesh = Arc::new(mesh);
        self.written.insert(hash);
        self.read.insert(hash, Arc::downgrade(&mesh));
        Ok(mesh)
    }

    /// Removes all others.
    pub(super) fn retain(&mut self, used: &BTreeSet<u64>) {
        let Ok(entries) = std::fs::read_dir(&self.folder) else {
            return;
        };
        for entry in entries.flatten() {
            if hash_of(&entry).is_none_or(|hash| !used.contains(&hash)) {
                // One that stays takes room and does no harm.
                let _ = std::fs::remove_file(entry.path());
            }
        }
        self.written.retain(|hash| used.contains(hash));
        self.read.retain(|hash, _| used.contains(hash));
    }
}

fn encoded(mesh: &Mesh) -> Result<Vec<u8>, String> {
    let record = MeshRecord::from(mesh);
    let bytes = bincode::serde::encode_to_vec(record, bincode::config::standard());
    bytes.map_err(|error| error.to_string())
}

fn read(file: &Path, hash: u64) -> Result<Mesh, String> {
    let bytes = std::fs::read(file).map_err(|error| error.to_string())?;
    let record = bincode::serde::decode_from_slice(&bytes, bincode::config::standard());
    let (record, _): (MeshRecord, usize) = record.map_err(|error| error.to_string())?;
    record.restore(hash)
}

/// The hash that names a file.
fn hash_of(entry: &DirEntry) -> Option<u64> {
    u64::from_str_radix(entry.file_name().to_str()?, 16).ok()
}

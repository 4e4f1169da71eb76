//! Meshes and clouds on disk, each in a file under its content hash.

use std::collections::{BTreeSet, HashMap};
use std::fs::DirEntry;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Weak};

use taut::shape::{Cloud, Mesh, PlacedShape};

use crate::daemon::durability::persisted::{Apart, Find};

/// What stands apart from the journal.
pub(super) struct Large {
    meshes: Folder<Mesh>,
    clouds: Folder<Cloud>,
}

impl Large {
    /// What is beside the journal of a folder.
    pub(super) fn new(folder: &Path) -> Self {
        Self {
            meshes: Folder::new(folder),
            clouds: Folder::new(folder),
        }
    }

    /// Folders of all kinds.
    pub(super) fn folders(&self) -> [&Path; 2] {
        [&self.meshes.folder, &self.clouds.folder]
    }

    /// Writes those of some shapes, unless their files are there.
    pub(super) fn keep<'a>(
        &mut self,
        mut shapes: impl Iterator<Item = &'a PlacedShape>,
    ) -> Result<(), String> {
        shapes.try_for_each(|placed| {
            self.meshes.keep(placed)?;
            self.clouds.keep(placed)
        })
    }

    /// Removes all others.
    pub(super) fn retain(&mut self, shapes: &[&PlacedShape]) {
        self.meshes.retain(shapes);
        self.clouds.retain(shapes);
    }
}

impl Find for Large {
    fn mesh(&mut self, hash: u64) -> Result<Arc<Mesh>, String> {
        self.meshes.find(hash)
    }

    fn cloud(&mut self, hash: u64) -> Result<Arc<Cloud>, String> {
        self.clouds.find(hash)
    }
}

/// The folder of one kind.
struct Folder<T> {
    folder: PathBuf,
    /// Those whose file is known to be there.
    written: BTreeSet<u64>,
    /// Those that were read: what uses one shares it again.
    read: HashMap<u64, Weak<T>>,
}

impl<T: Apart> Folder<T> {
    /// Made when it is first needed.
    fn new(beside: &Path) -> Self {
        Self {
            folder: beside.join(T::FOLDER),
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

    /// Writes what a shape has of this kind, unless its file is there.
    fn keep(&mut self, placed: &PlacedShape) -> Result<(), String> {
        let Some(content) = T::of(placed) else {
            return Ok(());
        };
        if !self.written.contains(&content.hash()) {
            self.write(content.hash(), &encoded(&**content)?)?;
            self.written.insert(content.hash());
        }
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

    /// Reads one; one that is not what its name says is refused.
    fn find(&mut self, hash: u64) -> Result<Arc<T>, String> {
        if let Some(known) = self.read.get(&hash).and_then(Weak::upgrade) {
            return Ok(known);
        }
        let file = self.file(hash);
        let content = read::<T>(&file, hash);
        let content = content.map_err(|reason| format!("{}: {reason}", file.display()))?;
        let content = Arc::new(content);
        self.written.insert(hash);
        self.read.insert(hash, Arc::downgrade(&content));
        Ok(content)
    }

    /// Removes all but those of some shapes.
    fn retain(&mut self, shapes: &[&PlacedShape]) {
        let used = shapes.iter().filter_map(|placed| T::of(placed));
        let used: BTreeSet<u64> = used.map(|content| content.hash()).collect();
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

fn encoded<T: Apart>(content: &T) -> Result<Vec<u8>, String> {
    let record = content.record();
    let bytes = bincode::serde::encode_to_vec(record, bincode::config::standard());
    bytes.map_err(|error| error.to_string())
}

fn read<T: Apart>(file: &Path, hash: u64) -> Result<T, String> {
    let bytes = std::fs::read(file).map_err(|error| error.to_string())?;
    let record = bincode::serde::decode_from_slice(&bytes, bincode::config::standard());
    let (record, _): (T::Record, usize) = record.map_err(|error| error.to_string())?;
    T::restored(record, hash)
}

/// The hash that names a file.
fn hash_of(entry: &DirEntry) -> Option<u64> {
    u64::from_str_radix(entry.file_name().to_str()?, 16).ok()
}

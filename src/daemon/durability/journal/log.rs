//! The journal's file: records one after the other; what is half written at its end was told to
//! nobody.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::record::Record;
use crate::daemon::durability::persisted::JOURNAL;
use crate::daemon::durability::record_log;

/// A file of this many bytes is never written anew only to be smaller.
const SMALL: u64 = 1024 * 1024;
/// A file this many times as large as when it was written anew is written anew.
const GROWTH: u64 = 4;

/// Why a journal is not read.
#[derive(Debug, thiserror::Error)]
pub(super) enum LogError {
    /// The system.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Bytes that were not written like this.
    #[error(
        "{path}: {why}; it may hold what was acknowledged, so nothing older is served: move it away, or use --no-state"
    )]
    Bytes {
        /// The file.
        path: PathBuf,
        /// What it is instead, or where it is damaged, and how.
        why: String,
    },
}

/// What a file holds; a torn record's bytes were told to nobody.
pub(super) type Contents = record_log::Contents<Record>;

/// Reads a journal; one that is not there is empty.
pub(super) fn read(path: &Path) -> Result<Contents, LogError> {
    match std::fs::read(path) {
        Ok(bytes) => parse(path, &bytes),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Contents::default()),
        Err(source) => Err(LogError::File {
            path: path.to_owned(),
            source,
        }),
    }
}

fn parse(path: &Path, bytes: &[u8]) -> Result<Contents, LogError> {
    JOURNAL
        .parse(bytes)
        .map_err(|why| LogError::Bytes {
            path: path.to_owned(),
            why,
        })
}

/// The file while it is written.
pub(super) struct Log {
    path: PathBuf,
    /// None until it is written anew: at first, and after a write that failed.
    file: Option<File>,
    bytes: u64,
    /// Bytes when it was last written anew.
    least: u64,
}

impl Log {
    /// Begins with a file that is written anew first.
    pub(super) fn new(path: PathBuf) -> Self {
        Self {
            path,
            file: None,
            bytes: 0,
            least: 0,
        }
    }

    /// Whether records can be added to it.
    pub(super) fn is_open(&self) -> bool {
        self.file.is_some()
    }

    /// Has everything written next time.
    pub(super) fn give_up(&mut self) {
        self.file = None;
    }

    /// What the system says, with the file.
    pub(super) fn error(&self, error: &std::io::Error) -> String {
        format!("{}: {error}", self.path.display())
    }

    /// Whether everything has to be written, not only what changed.
    pub(super) fn needs_all(&mut self) -> bool {
        // A file that somebody removed takes records all the same, and nobody would find them.
        if self.file.as_ref().is_some_and(is_removed) {
            self.file = None;
        }
        self.file.is_none() || self.bytes > SMALL.max(GROWTH * self.least)
    }

    /// Adds records to the file.
    pub(super) fn append(&mut self, records: &[u8]) -> std::io::Result<()> {
        let Some(file) = &mut self.file else {
            return Err(std::io::Error::other(
                "the journal has to be written anew first",
            ));
        };
        if let Err(error) = file.write_all(records) {
            // What was written of it must not stand before later records.
            let _ = file.set_len(self.bytes);
            self.file = None;
            return Err(error);
        }
        self.bytes += records.len() as u64;
        Ok(())
    }

    /// Puts a file with these records only in the place of the old one.
    pub(super) fn replace(&mut self, records: &[u8]) -> std::io::Result<()> {
        let new = self.path.with_extension("new");
        let written = write_new(&new, records);
        if let Err(error) = written.and_then(|()| std::fs::rename(&new, &self.path)) {
            let _ = std::fs::remove_file(&new);
            return Err(error);
        }
        self.file = Some(
            OpenOptions::new()
                .append(true)
                .open(&self.path)?,
        );
        self.bytes = (JOURNAL.start().len() + records.len()) as u64;
        self.least = self.bytes;
        Ok(())
    }
}

fn write_new(path: &Path, records: &[u8]) -> std::io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(&JOURNAL.start())?;
    file.write_all(records)
}

fn is_removed(file: &File) -> bool {
    file.metadata()
        .is_ok_and(|metadata| metadata.nlink() == 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::daemon::durability::record_log::{HEADER, encode};

    fn gone(label: &str) -> Record {
        Record::SceneGone {
            label: label.to_owned(),
        }
    }

    fn labels(contents: &Contents) -> Vec<&str> {
        let labels = contents
            .records
            .iter()
            .map(|record| match record {
                Record::SceneGone { label } => label.as_str(),
                other => panic!("{other:?}"),
            });
        labels.collect()
    }

    #[test]
    fn records_come_back_and_a_torn_end_is_dropped_but_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        assert_eq!(read(&path).unwrap().records.len(), 0);
        let mut log = Log::new(path.clone());
        assert!(log.needs_all() && log.append(b"x").is_err());
        let mut first = Vec::new();
        encode(&gone("a"), &mut first).unwrap();
        log.replace(&first).unwrap();
        let mut second = Vec::new();
        encode(&gone("b"), &mut second).unwrap();
        log.append(&second).unwrap();
        assert!(!log.needs_all());
        let whole = std::fs::read(&path).unwrap();
        assert_eq!(
            (labels(&read(&path).unwrap()), read(&path).unwrap().torn),
            (vec!["a", "b"], 0)
        );
        for cut in 1..second.len() {
            std::fs::write(&path, &whole[..whole.len() - cut]).unwrap();
            let contents = read(&path).unwrap();
            assert_eq!(
                (labels(&contents), contents.torn),
                (vec!["a"], second.len() - cut)
            );
        }
        let mut wrong = whole.clone();
        wrong[JOURNAL.start().len() + HEADER + 1] ^= 1;
        std::fs::write(&path, &wrong).unwrap();
        let error = read(&path).err().unwrap().to_string();
        assert!(
            error.contains("at byte 15: a checksum is wrong") && error.contains("--no-state"),
            "{error}"
        );
        std::fs::write(&path, b"something else").unwrap();
        assert!(
            read(&path)
                .err()
                .unwrap()
                .to_string()
                .contains("it is no journal")
        );
        std::fs::write(&path, b"taut journal 1\n").unwrap();
        let error = read(&path).err().unwrap().to_string();
        assert!(
            error.contains("a journal of version 1, this release reads version 3"),
            "{error}"
        );
    }

    #[test]
    fn a_file_that_grew_is_written_anew() {
        let folder = tempfile::tempdir().unwrap();
        let mut log = Log::new(folder.path().join("journal"));
        log.replace(&[]).unwrap();
        let mut record = Vec::new();
        encode(&gone(&"x".repeat(100_000)), &mut record).unwrap();
        let count = (0..).find(|_| {
            log.append(&record).unwrap();
            log.needs_all()
        });
        assert_eq!(count, Some(10), "just above {SMALL} bytes");
    }

    #[test]
    fn a_file_that_somebody_removed_is_written_anew() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        let mut log = Log::new(path.clone());
        log.replace(b"").unwrap();
        assert!(!log.needs_all());
        std::fs::remove_file(&path).unwrap();
        assert!(
            log.needs_all() && log.append(b"x").is_err(),
            "nobody would find it"
        );
    }
}

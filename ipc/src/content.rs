//! Robots and scenes from files of this machine, for a daemon that does not see them.
//!
//! A message that loads one names paths. [`carry`] has the same conversation with any daemon: it
//! names the files by their content, the daemon says which names it misses and whose content it
//! does not have, and these are sent in pieces. What it has from anybody is not sent again.

use crate::control::{ControlReply, ControlRequest, FileId, Files, Refusal, RobotSource};
use crate::limits::{FILE_MAX, FILES_MAX, GIVE_MAX};
use crate::wire::Code;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use taut_packages::Packages;

/// Endings of the names of files of meshes, clouds and octomaps: besides a robot's own files,
/// nothing else is sent, whatever the daemon wants.
const SENT: [&str; 8] = ["stl", "obj", "dae", "pcd", "npy", "xyz", "bt", "ot"];
/// How often a message is sent again: names, then contents, and both once more for each time that
/// somebody else's files push these out.
const MOST_ROUNDS: usize = 16;
/// How often a file is begun again that others push out meanwhile.
const MOST_LOSSES: usize = 3;

/// How far a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress<'a> {
    /// The file.
    pub file: &'a Path,
    /// Bytes that are there.
    pub sent: u64,
    /// Its bytes.
    pub bytes: u64,
}

/// Sends a message; where it loads a robot or scene from paths of this machine, with the files
/// themselves. `tell` sends one message and gives its reply; `progress` hears of each piece.
///
/// A file that cannot be read, or that is none to be sent, is a reply too: a refusal with the
/// file's path.
///
/// # Errors
/// What `tell` gives.
pub fn carry<E>(
    message: ControlRequest,
    tell: &mut dyn FnMut(&ControlRequest) -> Result<ControlReply, E>,
    progress: &mut dyn FnMut(Progress<'_>),
) -> Result<ControlReply, E> {
    Parcel::of(message).send(tell, progress)
}

/// A message, and the files of this machine that it names. What was sent once is sent again with the
/// same contents, to whomever, or is refused where a file is another meanwhile.
#[derive(Clone, Debug)]
pub struct Parcel {
    message: ControlRequest,
    luggage: Option<Luggage>,
}

impl Parcel {
    /// Of a message; no file is looked at yet.
    pub fn of(message: ControlRequest) -> Self {
        let luggage = Luggage::of(&message);
        Self { message, luggage }
    }

    /// The message.
    pub fn message(&self) -> &ControlRequest {
        &self.message
    }

    /// As [`carry`].
    ///
    /// # Errors
    /// What `tell` gives.
    pub fn send<E>(
        &mut self,
        tell: &mut dyn FnMut(&ControlRequest) -> Result<ControlReply, E>,
        progress: &mut dyn FnMut(Progress<'_>),
    ) -> Result<ControlReply, E> {
        let Some(luggage) = &mut self.luggage else {
            return tell(&self.message);
        };
        let mut courier = Courier {
            luggage,
            tell,
            progress,
        };
        match courier.carry(&mut self.message) {
            Ok(reply) => Ok(reply),
            Err(Stop::Refused(refusal)) => Ok(ControlReply::Refused(refusal)),
            Err(Stop::Failed(error)) => Err(error),
        }
    }
}

/// Why nothing more is sent.
enum Stop<E> {
    Refused(Refusal),
    Failed(E),
}

impl<E> From<Refusal> for Stop<E> {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

/// The files of one message.
#[derive(Clone, Debug)]
struct Luggage {
    /// The robot's own files.
    own: Vec<PathBuf>,
    /// Where relative names start.
    folder: PathBuf,
    packages: Packages,
    files: Files,
    paths: BTreeMap<FileId, PathBuf>,
}

impl Luggage {
    /// Of a message that names paths.
    fn of(message: &ControlRequest) -> Option<Self> {
        match message {
            ControlRequest::LoadRobot {
                source,
                files: None,
                ..
            } => Some(Self::of_robot(source)),
            ControlRequest::LoadScene {
                base_dir,
                files: None,
                ..
            }
            | ControlRequest::DiffScene {
                base_dir,
                files: None,
                ..
            } => {
                let root = || PathBuf::from("/");
                let folder = base_dir.clone().unwrap_or_else(root);
                Some(Self::new(Vec::new(), folder, BTreeMap::new()))
            }
            _ => None,
        }
    }

    fn of_robot(source: &RobotSource) -> Self {
        let urdf = source
            .spherized_urdf
            .as_ref()
            .unwrap_or(&source.urdf);
        let folder = urdf.parent().unwrap_or(Path::new("/"));
        let own = [urdf].into_iter().chain(&source.srdf);
        Self::new(
            own.cloned().collect(),
            folder.to_owned(),
            source.packages.clone(),
        )
    }

    fn new(own: Vec<PathBuf>, folder: PathBuf, named: BTreeMap<String, PathBuf>) -> Self {
        Self {
            own,
            folder,
            packages: Packages::with_environment(named),
            files: Files::new(),
            paths: BTreeMap::new(),
        }
    }

    /// Names a file by its content.
    fn pack(&mut self, name: String, path: PathBuf) -> Result<(), Refusal> {
        let id = id_of(&path)?;
        self.paths.insert(id, path);
        self.files.insert(name, id);
        Ok(())
    }

    fn pack_own(&mut self) -> Result<(), Refusal> {
        for path in self.own.clone() {
            self.pack(path.display().to_string(), path)?;
        }
        Ok(())
    }

    /// The file of a mesh or cloud that a robot or scene calls so.
    fn mesh(&self, name: &str) -> Result<PathBuf, Refusal> {
        let path = self
            .packages
            .resolve(name, &self.folder)
            .map_err(|reason| {
                Refusal::new(Code::InvalidModel, format!("file {name:?}: {reason}"))
            })?;
        let ending = path.extension().unwrap_or_default();
        if SENT
            .iter()
            .any(|known| ending.eq_ignore_ascii_case(known))
        {
            return Ok(path);
        }
        let text = format!(
            "{}: the daemon wants it, and it is no file of a mesh, cloud or octomap: {}; nothing else is sent",
            path.display(),
            SENT.join(", ")
        );
        Err(Refusal::new(Code::InvalidModel, text))
    }
}

struct Courier<'a, E> {
    luggage: &'a mut Luggage,
    tell: &'a mut dyn FnMut(&ControlRequest) -> Result<ControlReply, E>,
    progress: &'a mut dyn FnMut(Progress<'_>),
}

impl<E> Courier<'_, E> {
    fn carry(&mut self, message: &mut ControlRequest) -> Result<ControlReply, Stop<E>> {
        if self.luggage.files.is_empty() {
            self.luggage.pack_own()?;
        }
        for _ in 0..MOST_ROUNDS {
            set_files(message, self.luggage.files.clone());
            match self.ask(message)? {
                ControlReply::Wanted(names) => self.bring(names)?,
                reply => return Ok(reply),
            }
        }
        let text = "the daemon forgets files before it has all of them; let it keep more: files_mb in its daemon.toml";
        Err(Refusal::new(Code::ResourceExhausted, text).into())
    }

    fn ask(&mut self, message: &ControlRequest) -> Result<ControlReply, Stop<E>> {
        (self.tell)(message).map_err(Stop::Failed)
    }

    /// Names the files that have no names yet, and sends the others, each content once.
    fn bring(&mut self, names: Vec<String>) -> Result<(), Stop<E>> {
        let mut contents = BTreeSet::new();
        for name in names {
            match self.luggage.files.get(&name) {
                Some(id) => {
                    contents.insert(*id);
                }
                None => self.name(name)?,
            }
        }
        contents
            .into_iter()
            .try_for_each(|id| self.give(id))
    }

    fn name(&mut self, name: String) -> Result<(), Refusal> {
        if self.luggage.files.len() >= FILES_MAX {
            let text = format!("more than {FILES_MAX} files");
            return Err(Refusal::new(Code::ResourceExhausted, text));
        }
        let path = self.luggage.mesh(&name)?;
        self.luggage.pack(name, path)
    }

    fn give(&mut self, file: FileId) -> Result<(), Stop<E>> {
        let path = self.luggage.paths[&file].clone();
        let mut open = File::open(&path).map_err(|error| unreadable(&path, &error))?;
        let mut offset = 0;
        let mut losses = 0;
        loop {
            let bytes =
                piece(&mut open, file, offset).map_err(|error| unreadable(&path, &error))?;
            let there = self.give_piece(&path, file, offset, bytes)?;
            (self.progress)(Progress {
                file: &path,
                sent: there,
                bytes: file.bytes,
            });
            if there >= file.bytes {
                return Ok(());
            }
            losses += usize::from(there <= offset);
            if losses > MOST_LOSSES {
                return Err(pushed_out(&path).into());
            }
            offset = there;
        }
    }

    /// Sends a piece; gives how much of the file is there.
    fn give_piece(
        &mut self,
        path: &Path,
        file: FileId,
        offset: u64,
        bytes: Vec<u8>,
    ) -> Result<u64, Stop<E>> {
        let reply = self.ask(&ControlRequest::Give {
            file,
            offset,
            bytes,
        })?;
        match reply {
            ControlReply::Given { bytes } => Ok(bytes),
            ControlReply::Refused(refusal) => Err(Stop::Refused(Refusal {
                message: format!("{}: {}", path.display(), refusal.message),
                ..refusal
            })),
            _ => {
                let text = "the daemon takes no files; use client and daemon of the same release";
                Err(Refusal::new(Code::MalformedRequest, text).into())
            }
        }
    }
}

fn set_files(message: &mut ControlRequest, given: Files) {
    match message {
        ControlRequest::LoadRobot { files, .. }
        | ControlRequest::LoadScene { files, .. }
        | ControlRequest::DiffScene { files, .. } => *files = Some(given),
        _ => {}
    }
}

/// The name of a file by its content.
fn id_of(path: &Path) -> Result<FileId, Refusal> {
    let (sha256, bytes) = hashed(path).map_err(|error| unreadable(path, &error))?;
    if bytes <= FILE_MAX {
        return Ok(FileId { sha256, bytes });
    }
    let text = format!(
        "{}: {bytes} bytes; at most {FILE_MAX} are sent: make the mesh coarser",
        path.display()
    );
    Err(Refusal::new(Code::ResourceExhausted, text))
}

/// The hash of a file, and its size; of one that is too large, of its beginning.
fn hashed(path: &Path) -> std::io::Result<([u8; 32], u64)> {
    let mut file = File::open(path)?.take(FILE_MAX + 1);
    let mut hash = Sha256::new();
    let mut buffer = vec![0; GIVE_MAX];
    let mut bytes = 0;
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok((hash.finalize().into(), bytes)),
            read => {
                hash.update(&buffer[..read]);
                bytes += read as u64;
            }
        }
    }
}

/// The piece of a file that begins there.
fn piece(open: &mut File, file: FileId, offset: u64) -> std::io::Result<Vec<u8>> {
    let left = file.bytes - offset;
    let mut bytes = vec![0; left.min(GIVE_MAX as u64) as usize];
    open.seek(SeekFrom::Start(offset))?;
    open.read_exact(&mut bytes)?;
    Ok(bytes)
}

fn unreadable(path: &Path, error: &std::io::Error) -> Refusal {
    let text = format!("{}: {error}", path.display());
    Refusal::new(Code::UnreadableFile, text)
}

fn pushed_out(path: &Path) -> Refusal {
    let text = format!(
        "{}: other files push it out of the daemon's memory; let it keep more: files_mb in its daemon.toml",
        path.display()
    );
    Refusal::new(Code::ResourceExhausted, text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    /// Takes files whose content is what their names say, and loads what it has all files of.
    #[derive(Default)]
    struct FakeDaemon(BTreeMap<FileId, Vec<u8>>);

    impl FakeDaemon {
        fn tell(&mut self, message: &ControlRequest) -> ControlReply {
            match message {
                ControlRequest::Give { file, bytes, .. } => self.take(*file, bytes.clone()),
                ControlRequest::LoadRobot { source, files, .. } => {
                    let name = source.urdf.display().to_string();
                    let file = files.as_ref().unwrap().get(&name);
                    match file.is_some_and(|file| self.0.contains_key(file)) {
                        true => ControlReply::Done,
                        false => ControlReply::Wanted(vec![name]),
                    }
                }
                other => panic!("{other:?}"),
            }
        }

        fn take(&mut self, file: FileId, bytes: Vec<u8>) -> ControlReply {
            let hash: [u8; 32] = Sha256::digest(&bytes).into();
            if hash != file.sha256 {
                let refusal = Refusal::new(Code::MalformedRequest, "other content");
                return ControlReply::Refused(refusal);
            }
            self.0.insert(file, bytes);
            ControlReply::Given { bytes: file.bytes }
        }
    }

    fn sent(parcel: &mut Parcel, daemon: &mut FakeDaemon) -> ControlReply {
        let mut tell = |message: &ControlRequest| Ok::<_, Infallible>(daemon.tell(message));
        parcel.send(&mut tell, &mut |_| {}).unwrap()
    }

    #[test]
    fn what_is_sent_again_is_what_was_sent_or_it_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let urdf = folder.path().join("arm.urdf");
        std::fs::write(&urdf, "<robot/>").unwrap();
        let source = RobotSource {
            urdf: urdf.clone(),
            ..RobotSource::default()
        };
        let mut parcel = Parcel::of(ControlRequest::LoadRobot {
            label: "arm".to_owned(),
            source,
            replace: false,
            files: None,
        });
        let [mut first, mut second, mut third] = std::array::from_fn(|_| FakeDaemon::default());
        assert_eq!(sent(&mut parcel, &mut first), ControlReply::Done);
        assert_eq!(sent(&mut parcel, &mut second), ControlReply::Done);
        assert_eq!(first.0, second.0);
        // Another file of that name is another robot, which nobody asked for.
        std::fs::write(&urdf, "<ROBOT/>").unwrap();
        assert_eq!(sent(&mut parcel, &mut first), ControlReply::Done);
        let refused = sent(&mut parcel, &mut third);
        assert!(matches!(refused, ControlReply::Refused(_)), "{refused:?}");
        assert!(third.0.is_empty());
    }
}

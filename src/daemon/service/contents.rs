//! Files that clients gave, by their content: what robots and scenes are read from where their
//! client is on another machine.
//!
//! Memory is taken by what has come, never by what somebody says will come. Where it is used up,
//! what nobody has asked for longest goes first, half-given files too.

use std::collections::HashMap;
use std::sync::Arc;

use taut::files::GivenFiles;
use taut_ipc::control::{FileId, Files, Refusal};
use taut_ipc::limits::{FILE_MAX, FILE_NAME_MAX, FILES_MAX, GIVE_MAX};
use taut_ipc::wire::Code;

use super::event::Ticket;
use crate::daemon::translate::Unread;

/// Files that are remembered at once, of whatever size.
const MOST_FILES: usize = 2 * FILES_MAX;

/// When to try again where there is no room for a file now.
const RETRY_MS: u32 = 500;

/// The files.
pub(crate) struct Contents {
    /// Bytes that they may have together.
    most: u64,
    used: u64,
    /// Counts what is asked for.
    clock: u64,
    files: HashMap<FileId, Kept>,
}

struct Kept {
    state: State,
    asked_for: u64,
}

enum State {
    /// Pieces, in order.
    Coming(Vec<Vec<u8>>, u64),
    /// All of it is there and is being compared with its name; who waits for that.
    Checked(Vec<Ticket>),
    /// As it should be.
    Whole(Arc<[u8]>),
}

/// What follows from a piece.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Taken {
    /// So many bytes of the file are there.
    UpTo(u64),
    /// All of it is there: these are to be compared with its name.
    ToCheck(Vec<Vec<u8>>),
    /// They are already.
    Waits,
}

impl Contents {
    /// At most so many bytes, and no file yet.
    pub(crate) fn new(most: u64) -> Self {
        Self {
            most,
            used: 0,
            clock: 0,
            files: HashMap::new(),
        }
    }

    /// Takes a piece of a file; who sends it waits where all of it is there.
    ///
    /// # Errors
    /// A file or piece that is too large.
    pub(crate) fn give(
        &mut self,
        ticket: Ticket,
        file: FileId,
        offset: u64,
        bytes: Vec<u8>,
    ) -> Result<Taken, Refusal> {
        self.check_piece(&file, bytes.len())?;
        let there = match self.ask_for(&file) {
            Some(State::Whole(_)) => return Ok(Taken::UpTo(file.bytes)),
            Some(State::Checked(waiting)) => {
                waiting.push(ticket);
                return Ok(Taken::Waits);
            }
            Some(State::Coming(_, there)) => *there,
            None => 0,
        };
        let new = new_part(there, file.bytes, offset, bytes);
        self.make_room(&file, new.len() as u64)?;
        Ok(self.append(ticket, file, new))
    }

    /// All bytes of a file were compared with its name; gives who waits for it.
    pub(crate) fn checked(&mut self, file: &FileId, content: Option<Arc<[u8]>>) -> Vec<Ticket> {
        let Some(mut kept) = self.files.remove(file) else {
            return Vec::new();
        };
        let whole = content.map(State::Whole);
        let State::Checked(waiting) = &mut kept.state else {
            unreachable!("a file is compared once, and stays until then")
        };
        let waiting = std::mem::take(waiting);
        match whole {
            Some(state) => {
                let asked_for = kept.asked_for;
                self.files
                    .insert(*file, Kept { state, asked_for });
            }
            None => self.used -= file.bytes,
        }
        waiting
    }

    /// The contents of a robot's or scene's files.
    ///
    /// # Errors
    /// Names or sizes beyond what may be given; names whose contents are not there.
    pub(crate) fn gather(&mut self, files: &Files) -> Result<GivenFiles, Unread> {
        self.check_files(files)?;
        let mut given = GivenFiles::new();
        let mut missing = Vec::new();
        for (name, file) in files {
            match self.ask_for(file) {
                Some(State::Whole(bytes)) => {
                    given.insert(name.clone(), bytes.clone());
                }
                _ => missing.push(name.clone()),
            }
        }
        match missing.is_empty() {
            true => Ok(given),
            false => Err(Unread::Wanted(missing)),
        }
    }

    /// A file, which is in use now.
    fn ask_for(&mut self, file: &FileId) -> Option<&mut State> {
        self.clock += 1;
        let kept = self.files.get_mut(file)?;
        kept.asked_for = self.clock;
        Some(&mut kept.state)
    }

    fn append(&mut self, ticket: Ticket, file: FileId, new: Vec<u8>) -> Taken {
        self.used += new.len() as u64;
        let asked_for = self.clock;
        let kept = self.files.entry(file).or_insert_with(|| Kept {
            state: State::Coming(Vec::new(), 0),
            asked_for,
        });
        let State::Coming(pieces, there) = &mut kept.state else {
            unreachable!("only what is coming is appended to")
        };
        *there += new.len() as u64;
        push(pieces, new);
        if *there < file.bytes {
            return Taken::UpTo(*there);
        }
        let pieces = std::mem::take(pieces);
        kept.state = State::Checked(vec![ticket]);
        Taken::ToCheck(pieces)
    }

    /// Drops what nobody has asked for longest, until so many bytes of a file find room.
    fn make_room(&mut self, file: &FileId, bytes: u64) -> Result<(), Refusal> {
        while self.used + bytes > self.most || self.files.len() >= MOST_FILES {
            let oldest = self
                .files
                .iter()
                .filter(|(id, kept)| *id != file && kept.state.may_go())
                .min_by_key(|(_, kept)| kept.asked_for)
                .map(|(id, _)| *id);
            // What is being compared or read is soon done.
            let kept = oldest.and_then(|id| self.files.remove(&id));
            self.used -= kept.ok_or_else(no_room)?.state.bytes();
        }
        Ok(())
    }

    fn check_piece(&self, file: &FileId, piece: usize) -> Result<(), Refusal> {
        if piece > GIVE_MAX {
            let text = format!("a piece of {piece} bytes; at most {GIVE_MAX}");
            return Err(Refusal::new(Code::MalformedRequest, text));
        }
        self.check_size(file.bytes)
    }

    fn check_size(&self, bytes: u64) -> Result<(), Refusal> {
        let most = FILE_MAX.min(self.most);
        if bytes <= most {
            return Ok(());
        }
        let text = format!("a file of {bytes} bytes; this daemon takes at most {most}");
        Err(Refusal::new(Code::ResourceExhausted, text))
    }

    fn check_files(&self, files: &Files) -> Result<(), Refusal> {
        let count = files.len();
        if count > FILES_MAX {
            let text = format!("{count} files of one robot or scene; at most {FILES_MAX}");
            return Err(Refusal::new(Code::ResourceExhausted, text));
        }
        for (name, file) in files {
            check_name(name)?;
            self.check_size(file.bytes)?;
        }
        self.check_sum(files)
    }

    /// Whether all of them may be here at once.
    fn check_sum(&self, files: &Files) -> Result<(), Refusal> {
        let mut sizes: Vec<&FileId> = files.values().collect();
        sizes.sort_unstable();
        sizes.dedup();
        let sum: u64 = sizes.iter().map(|file| file.bytes).sum();
        let most = self.most;
        if sum <= most {
            return Ok(());
        }
        let text = format!(
            "files of {sum} bytes together; this daemon keeps at most {most}: let it keep more by files_mb in its daemon.toml"
        );
        Err(Refusal::new(Code::ResourceExhausted, text))
    }
}

impl State {
    /// Whether its memory is free once it goes: nobody compares it or reads from it.
    fn may_go(&self) -> bool {
        match self {
            Self::Coming(..) => true,
            Self::Checked(_) => false,
            Self::Whole(bytes) => Arc::strong_count(bytes) == 1,
        }
    }

    fn bytes(&self) -> u64 {
        match self {
            Self::Coming(_, there) => *there,
            Self::Checked(_) => 0,
            Self::Whole(bytes) => bytes.len() as u64,
        }
    }
}

fn no_room() -> Refusal {
    Refusal {
        retry_after_ms: RETRY_MS,
        ..Refusal::new(
            Code::Overloaded,
            "files that others give leave no room for it now; send it again",
        )
    }
}

fn check_name(name: &str) -> Result<(), Refusal> {
    let bytes = name.len();
    if bytes <= FILE_NAME_MAX {
        return Ok(());
    }
    let text = format!("a file name of {bytes} bytes; at most {FILE_NAME_MAX}");
    Err(Refusal::new(Code::MalformedRequest, text))
}

/// What a piece has beyond what is there of a file: nothing where there is a gap before it.
fn new_part(there: u64, whole: u64, offset: u64, mut bytes: Vec<u8>) -> Vec<u8> {
    let known = match there.checked_sub(offset) {
        Some(known) => known.min(bytes.len() as u64) as usize,
        None => bytes.len(),
    };
    bytes.drain(..known);
    bytes.truncate((whole - there).min(GIVE_MAX as u64) as usize);
    bytes
}

/// Appends to pieces; small ones become one, for each costs memory of its own.
fn push(pieces: &mut Vec<Vec<u8>>, new: Vec<u8>) {
    match pieces.last_mut() {
        Some(last) if last.len() + new.len() <= GIVE_MAX => last.extend_from_slice(&new),
        _ => pieces.push(new),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use sha2::{Digest, Sha256};

    use super::*;

    /// Room for two files and a half.
    const MOST: u64 = 2_500;
    const FILE: usize = 1_000;

    fn file(number: u8) -> (FileId, Vec<u8>) {
        let bytes: Vec<u8> = (0..FILE).map(|i| (i as u8) ^ number).collect();
        let id = FileId {
            sha256: Sha256::digest(&bytes).into(),
            bytes: FILE as u64,
        };
        (id, bytes)
    }

    /// A piece that somebody sends of one of four files; some are garbage.
    fn piece() -> impl Strategy<Value = (u8, usize, usize, bool)> {
        (0_u8..4, 0..FILE + 10, 0..FILE, prop::bool::weighted(0.02))
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        /// Whatever comes in whatever order, what is there is what its name says, no more is kept
        /// than may be, and who goes on from where it is told gets the file there.
        #[test]
        fn what_is_there_is_what_its_name_says(pieces in prop::collection::vec(piece(), 0..200)) {
            let mut contents = Contents::new(MOST);
            for (number, offset, len, is_garbage) in pieces {
                let (id, whole) = file(number);
                let end = (offset + len).min(FILE);
                let mut bytes = whole.get(offset..end).unwrap_or_default().to_vec();
                if is_garbage {
                    bytes.iter_mut().for_each(|byte| *byte = !*byte);
                }
                let offset = offset as u64;
                let taken = contents_give(&mut contents, id, offset, bytes);
                settle(&mut contents, id, taken);
                check(&contents);
            }
            // One that goes on where it is told.
            let (id, whole) = file(3);
            let mut there = 0;
            let mut tries = 0;
            while there < FILE {
                tries += 1;
                prop_assert!(tries < 100, "{there} of {FILE}");
                let end = (there + 300).min(FILE);
                let bytes = whole[there..end].to_vec();
                let taken = contents_give(&mut contents, id, there as u64, bytes);
                there = settle(&mut contents, id, taken);
                check(&contents);
            }
            let files = Files::from([("a".to_owned(), id)]);
            let given = contents.gather(&files).unwrap();
            prop_assert_eq!(&*given["a"], &whole[..]);
        }
    }

    fn contents_give(contents: &mut Contents, id: FileId, offset: u64, bytes: Vec<u8>) -> Taken {
        contents.give(1, id, offset, bytes).unwrap()
    }

    /// Compares what is to be compared; gives how much is there.
    fn settle(contents: &mut Contents, id: FileId, taken: Taken) -> usize {
        match taken {
            Taken::UpTo(there) => there as usize,
            Taken::Waits => unreachable!("nothing is left to be compared"),
            Taken::ToCheck(pieces) => {
                let bytes = pieces.concat();
                assert_eq!(bytes.len() as u64, id.bytes);
                let hash: [u8; 32] = Sha256::digest(&bytes).into();
                let content = (hash == id.sha256).then(|| Arc::from(bytes));
                let there = if content.is_some() { FILE } else { 0 };
                assert_eq!(contents.checked(&id, content), [1]);
                there
            }
        }
    }

    /// What is counted is what is there, and no more than may be.
    fn check(contents: &Contents) {
        let kept = contents.files.values();
        let sum: u64 = kept.map(|kept| kept.state.bytes()).sum();
        assert_eq!(sum, contents.used);
        assert!(sum <= MOST, "{sum}");
    }
}

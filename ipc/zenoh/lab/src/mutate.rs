//! Messages to a gateway that are nearly right, and what comes back.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use taut_ipc::control::{self, ControlReply, ControlRequest};
use taut_ipc::limits::WIRE_VERSION;
use taut_ipc::wire::{
    Code, Envelope, EnvelopeKind, Mode, NO_GROUP, RequestHeader, ResponseHeader, Section,
};
use zenoh::query::Reply;
use zenoh::{Session, Wait};

use crate::bare::open;
use crate::error::Error;
use crate::orders::{Mutating, Tally};
use crate::random::Random;

/// Queries at once.
const AT_ONCE: usize = 64;
/// When a query without an answer counts as one that hangs.
const PATIENCE: Duration = Duration::from_secs(20);
/// Clients that the messages say they are of.
const CLIENTS: usize = 24;
/// Waypoints of the path that is sent.
const WAYPOINTS: usize = 8;
/// Words that are odd as a length, an index, an id or a number.
const ODD: [u64; 8] = [
    0,
    1,
    u64::MAX,
    0x7ff0_0000_0000_0000,
    0x7ff8_0000_0000_0001,
    0xffff_ffff,
    1 << 31,
    0x0010_0000_0000_0000,
];

/// Sends them all, and waits for all answers.
pub(crate) fn send(mutating: &Mutating) -> Result<Tally, Error> {
    let session = open("peer", &None, &Some(mutating.connect.clone()))?;
    let window = Arc::new(Window::default());
    let mut random = Random::new(mutating.seed);
    for _ in 0..mutating.count {
        let message = Message::choose(mutating, &mut random);
        match message.is_query {
            true => ask(&session, message, &window)?,
            // Nobody answers what is put.
            false => put(&session, message)?,
        }
    }
    Ok(window.all_answered())
}

/// A message that may be wrong in every part.
struct Message {
    key: String,
    payload: Vec<u8>,
    attachment: Vec<u8>,
    is_query: bool,
}

impl Message {
    fn choose(mutating: &Mutating, random: &mut Random) -> Self {
        let envelope = Envelope {
            wire_version: WIRE_VERSION,
            client: random.below(CLIENTS) as u64 + 1,
            request: random.next(),
            ..Envelope::default()
        };
        let mut message = match random.below(10) {
            0..6 => Self::request(mutating, envelope),
            6 => Self::again(mutating, envelope),
            7 | 8 => Self::control(mutating, envelope, random),
            _ => Self::put(mutating, random),
        };
        match random.below(3) {
            0 => mutate(&mut message.attachment, random),
            1 => mutate(&mut message.payload, random),
            _ => {
                mutate(&mut message.attachment, random);
                mutate(&mut message.payload, random);
            }
        }
        message
    }

    fn query(daemon: &str, name: &str, kind: EnvelopeKind, envelope: Envelope) -> Self {
        let envelope = Envelope {
            kind: kind.into(),
            ..envelope
        };
        let mut attachment = bytemuck::bytes_of(&envelope).to_vec();
        attachment.extend_from_slice(b"lab/mutate");
        Self {
            key: format!("taut/v1/{daemon}/{name}"),
            payload: Vec::new(),
            attachment,
            is_query: true,
        }
    }

    fn request(mutating: &Mutating, envelope: Envelope) -> Self {
        Self {
            payload: request(mutating, envelope.request),
            ..Self::query(
                &mutating.daemon,
                "optimize",
                EnvelopeKind::Request,
                envelope,
            )
        }
    }

    fn again(mutating: &Mutating, envelope: Envelope) -> Self {
        Self::query(&mutating.daemon, "optimize", EnvelopeKind::Again, envelope)
    }

    fn control(mutating: &Mutating, envelope: Envelope, random: &mut Random) -> Self {
        let requests = [
            ControlRequest::List,
            ControlRequest::Stats,
            // A label of nothing: mutated, they may say to unload it.
            ControlRequest::Describe {
                label: "nothing".to_owned(),
            },
            ControlRequest::ShowScene {
                label: "nothing".to_owned(),
                version: 0,
                base_version: 0,
            },
        ];
        let request = &requests[random.below(requests.len())];
        Self {
            payload: control::encode(request).unwrap_or_default(),
            ..Self::query(&mutating.daemon, "control", EnvelopeKind::Control, envelope)
        }
    }

    fn put(mutating: &Mutating, random: &mut Random) -> Self {
        let daemon = &mutating.daemon;
        let number = random.next();
        let keys = [
            format!("taut/v1/{daemon}/cancel/{:016x}/{number:016x}", number % 32),
            format!("taut/v1/{daemon}/finish/{number:x}/x"),
            format!("taut/v1/{daemon}/status"),
            format!("taut/v1/{daemon}/scene/{number:016x}/event"),
        ];
        let mut payload = vec![0; random.below(2_000)];
        fill(&mut payload, random);
        Self {
            key: keys[random.below(keys.len())].clone(),
            payload,
            attachment: Vec::new(),
            is_query: false,
        }
    }
}

/// A request that would be answered: a short path, checked where nothing is.
fn request(mutating: &Mutating, request_id: u64) -> Vec<u8> {
    let header = RequestHeader {
        wire_version: WIRE_VERSION,
        header_len: size_of::<RequestHeader>() as u32,
        request_id,
        robot_id: mutating.robot_id,
        layout_hash: mutating.layout_hash,
        scene_id: mutating.scene_id,
        mode: Mode::Check.into(),
        group: NO_GROUP,
        deadline_ns: 50_000_000,
        work_budget: 1_000,
        waypoints: WAYPOINTS as u32,
        variables: 2,
        path: Section {
            offset: 0,
            count: 2 * WAYPOINTS as u32,
        },
        ..RequestHeader::default()
    };
    let mut bytes = bytemuck::bytes_of(&header).to_vec();
    for index in 0..WAYPOINTS {
        let row = [-4.2 + 0.001 * index as f64, -3.8];
        bytes.extend_from_slice(bytemuck::cast_slice(&row));
    }
    bytes
}

/// Changes some bits, a word, the length, or all.
fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    let length = bytes.len();
    match random.below(8) {
        0..3 => flip(bytes, random),
        3..5 => put_word(bytes, random),
        5 => bytes.truncate(random.below(length + 1)),
        6 => {
            bytes.resize(length + random.below(300), 0);
            fill(&mut bytes[length..], random);
        }
        _ => fill(bytes, random),
    }
}

fn flip(bytes: &mut [u8], random: &mut Random) {
    for _ in 0..=random.below(4) {
        let index = random.below(bytes.len());
        if let Some(byte) = bytes.get_mut(index) {
            *byte ^= 1 << random.below(8);
        }
    }
}

/// An odd number where some field of four or eight bytes is.
fn put_word(bytes: &mut [u8], random: &mut Random) {
    let word = ODD[random.below(ODD.len())].to_le_bytes();
    let size = 4 << random.below(2);
    let index = random.below(bytes.len() / size) * size;
    if let Some(place) = bytes.get_mut(index..index + size) {
        place.copy_from_slice(&word[..size]);
    }
}

fn fill(bytes: &mut [u8], random: &mut Random) {
    for byte in bytes {
        *byte = random.next() as u8;
    }
}

fn put(session: &Session, message: Message) -> Result<(), Error> {
    let put = session
        .put(message.key, message.payload)
        .attachment(message.attachment)
        .wait();
    put.map_err(|error| Error::Zenoh(error.to_string()))
}

/// Asks as soon as fewer than [`AT_ONCE`] wait.
fn ask(session: &Session, message: Message, window: &Arc<Window>) -> Result<(), Error> {
    let is_control = message.key.ends_with("control");
    let mut open = Open::of(window.clone());
    session
        .get(message.key)
        .payload(message.payload)
        .attachment(message.attachment)
        .timeout(PATIENCE)
        // Zenoh drops it, and with it what is open, at the end of the query.
        .callback_mut(move |reply| open.heard(is_control, &reply))
        .wait()
        .map_err(|error| Error::Zenoh(error.to_string()))
}

/// The queries that wait, and what came of the others.
#[derive(Default)]
struct Window {
    state: Mutex<(usize, Tally)>,
    fewer: Condvar,
}

impl Window {
    fn lock(&self) -> MutexGuard<'_, (usize, Tally)> {
        self.state
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until fewer than so many wait.
    fn wait_for(&self, fewer_than: usize) -> MutexGuard<'_, (usize, Tally)> {
        self.fewer
            .wait_while(self.lock(), |(open, _)| *open >= fewer_than)
            .unwrap_or_else(PoisonError::into_inner)
    }

    fn all_answered(&self) -> Tally {
        self.wait_for(1).1.clone()
    }
}

/// A query that waits.
struct Open {
    window: Arc<Window>,
    end: Option<String>,
}

impl Open {
    fn of(window: Arc<Window>) -> Self {
        let mut state = window.wait_for(AT_ONCE);
        state.0 += 1;
        state.1.sent += 1;
        drop(state);
        Self { window, end: None }
    }

    fn heard(&mut self, is_control: bool, reply: &Reply) {
        self.end = Some(match reply.result() {
            Ok(sample) if is_control => of_control(&sample.payload().to_bytes()),
            Ok(sample) => of_request(&sample.payload().to_bytes()),
            // What Zenoh itself makes of a query that nobody ends.
            Err(error)
                if error
                    .payload()
                    .to_bytes()
                    .starts_with(b"Timeout") =>
            {
                return;
            }
            Err(_) => "an error".to_owned(),
        });
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        let mut state = self.window.lock();
        state.0 -= 1;
        match self.end.take() {
            Some(end) => *state.1.ends.entry(end).or_default() += 1,
            None => state.1.endless += 1,
        }
        self.window.fewer.notify_all();
    }
}

fn of_request(bytes: &[u8]) -> String {
    let size = size_of::<ResponseHeader>();
    let Some(header) = bytes.get(..size) else {
        return "a short answer".to_owned();
    };
    let header: ResponseHeader = bytemuck::pod_read_unaligned(header);
    named(header.code)
}

fn of_control(bytes: &[u8]) -> String {
    match control::decode(bytes) {
        Ok(ControlReply::Refused(refusal)) => named(refusal.code),
        Ok(_) => "Success".to_owned(),
        Err(_) => "no reply".to_owned(),
    }
}

fn named(code: i32) -> String {
    Code::try_from(code).map_or_else(|_| format!("code {code}"), |code| format!("{code:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_bytes_can_be_mutated() {
        let mut random = Random::new(3);
        for length in [0, 1, 3, 7, 48, 300] {
            for _ in 0..200 {
                mutate(&mut vec![0; length], &mut random);
            }
        }
    }
}

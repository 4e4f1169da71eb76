//! Messages that are none: each is refused, and the gateway serves on.
//!
//! `TAUT_MESSAGES=1000000 cargo test --release --test garbage -- --nocapture` is the long form.
#![allow(missing_docs)]

mod world;

use taut_ipc::control::{ControlRequest, encode};
use taut_ipc::wire::{Code, EnvelopeKind, Mode};
use taut_zenoh::{Zenoh, names};
use world::{NAME, World, attachment, message, request, told};
use zenoh::bytes::ZBytes;
use zenoh::{Session, Wait};

/// Queries under way at once.
const AT_ONCE: usize = 64;

struct Noise(u64);

impl Noise {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % limit as u64) as usize
    }

    /// Changes, cuts or lengthens.
    fn garble(&mut self, bytes: &ZBytes) -> ZBytes {
        let mut bytes = bytes.to_bytes().to_vec();
        for _ in 0..self.below(6) {
            if bytes.is_empty() {
                break;
            }
            let at = self.below(bytes.len());
            match self.below(4) {
                0 => bytes[at] = [0, 1, 0x7f, 0xff][self.below(4)],
                1 => bytes[at] ^= 1 << self.below(8),
                2 => bytes.truncate(at),
                _ => bytes.insert(at, self.below(256) as u8),
            }
        }
        bytes.into()
    }
}

/// Resident memory of this process in KiB.
fn resident() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status
        .lines()
        .find(|line| line.starts_with("VmRSS"));
    let number = line.unwrap().split_whitespace().nth(1);
    number.unwrap().parse().unwrap()
}

/// Sends some, and waits for the end of each; gives how many had a reply.
fn burst(session: &Session, noise: &mut Noise, count: usize) -> usize {
    let asked: Vec<_> = (0..count)
        .map(|_| one(session, noise))
        .collect();
    asked
        .into_iter()
        .filter(|replies| replies.recv().is_ok())
        .count()
}

fn one(
    session: &Session,
    noise: &mut Noise,
) -> zenoh::handlers::FifoChannelHandler<zenoh::query::Reply> {
    let id = noise.below(1 << 20) as u64;
    let client = noise.below(4) as u64;
    let kind = [
        EnvelopeKind::Request,
        EnvelopeKind::Again,
        EnvelopeKind::Control,
    ][noise.below(3)];
    let sender = attachment(kind, client, id);
    let is_control = noise.below(3) == 0;
    let payload = match is_control {
        true => encode(&ControlRequest::List).unwrap().into(),
        false => message(&request(Mode::Check, id)),
    };
    let key = match is_control {
        true => names::control(NAME),
        false => names::optimize(NAME),
    };
    session
        .get(key)
        .attachment(noise.garble(&sender))
        .payload(noise.garble(&payload))
        .timeout(std::time::Duration::from_secs(20))
        .wait()
        .unwrap()
}

#[test]
fn garbage_is_refused_and_the_gateway_serves_on() {
    let messages = std::env::var("TAUT_MESSAGES");
    let messages: usize = messages.map_or(10_000, |text| text.parse().unwrap());
    let world = World::new();
    let session = world.session();
    let mut noise = Noise(0x9e37_79b9_7f4a_7c15);
    let mut replied = 0;
    let mut memory = Vec::new();
    for sent in (0..messages).step_by(AT_ONCE) {
        if sent * 4 >= messages * memory.len() {
            memory.push(resident());
        }
        replied += burst(&session, &mut noise, AT_ONCE);
    }
    memory.push(resident());
    println!(
        "{messages} messages, {replied} replies, KiB of memory after each quarter: {memory:?}"
    );
    // Ports of a hundred clients, who come and go, are there after the first half.
    assert!(
        memory[4] < memory[2] + memory[2] / 4 + 32 * 1024,
        "{memory:?}"
    );
    assert!(replied * 10 >= messages * 9, "{replied} of {messages}");
    let zenoh = Zenoh::connect(&world.network()).unwrap();
    let told = told(&zenoh, &request(Mode::Check, 1));
    assert_eq!(told, [(Code::Success, 1.0)]);
}

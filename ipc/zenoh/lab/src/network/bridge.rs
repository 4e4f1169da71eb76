//! Two TUN devices and what carries packets between them: the kernel's own emulation of delay and loss
//! (netem) is not in every kernel.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tun_rs::{DeviceBuilder, InterruptEvent, SyncDevice};

use super::weather::{Sky, Weather};
use crate::error::Error;
use crate::random::Random;

/// Longest packet; the devices' MTU is that of Ethernet.
const PACKET: usize = 2048;
const MTU: u16 = 1500;
/// Packets that a device keeps for the bridge: as many as a window of some megabytes has.
const QUEUE: u32 = 10_000;

/// A packet, and when it is to arrive.
type Posted = (Instant, Vec<u8>);

/// Carries packets between two devices until it is dropped, which removes both.
pub(super) struct Bridge {
    sky: Arc<Sky>,
    end: Arc<InterruptEvent>,
    threads: Vec<JoinHandle<()>>,
}

impl Bridge {
    /// Makes both devices, in this process's namespace, down. What is lost is the same for equal
    /// seeds and packets.
    pub(super) fn create(names: [&str; 2], seed: u64) -> Result<Self, Error> {
        let [first, second] = [device(names[0])?, device(names[1])?];
        let end = InterruptEvent::new().map_err(failed("the end of a bridge"))?;
        let mut bridge = Self {
            sky: Arc::default(),
            end: Arc::new(end),
            threads: Vec::new(),
        };
        bridge.carry(first.clone(), second.clone(), Random::new(seed));
        bridge.carry(second, first, Random::new(!seed));
        Ok(bridge)
    }

    /// Lets it be so from now on.
    pub(super) fn set(&self, weather: Weather) {
        self.sky.set(weather);
    }

    /// Starts the two threads of a direction.
    fn carry(&mut self, from: Arc<SyncDevice>, to: Arc<SyncDevice>, random: Random) {
        let (post, posted) = channel();
        let sky = self.sky.clone();
        let end = self.end.clone();
        self.threads.push(std::thread::spawn(move || {
            read(&from, &sky, &end, random, &post)
        }));
        self.threads
            .push(std::thread::spawn(move || write(&to, &posted)));
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        // Fails only where it has been triggered already.
        let _ = self.end.trigger();
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

fn device(name: &str) -> Result<Arc<SyncDevice>, Error> {
    let device = DeviceBuilder::new()
        .name(name)
        .mtu(MTU)
        .tx_queue_len(QUEUE)
        .enable(false)
        .build_sync();
    device.map(Arc::new).map_err(failed(name))
}

fn failed(what: &str) -> impl Fn(std::io::Error) -> Error {
    move |error| Error::Network {
        what: what.to_owned(),
        reason: error.to_string(),
    }
}

/// Takes packets of a device and posts those that are not lost, until the end. A device that is down
/// has none.
fn read(
    from: &SyncDevice,
    sky: &Sky,
    end: &InterruptEvent,
    mut random: Random,
    post: &Sender<Posted>,
) {
    let mut packet = [0; PACKET];
    while !end.is_trigger() {
        match from.recv_intr(&mut packet, end) {
            Ok(_) if sky.loses(random.next()) => (),
            Ok(bytes) => {
                let due = Instant::now() + sky.delay();
                // The other thread ends after this one.
                let _ = post.send((due, packet[..bytes].to_vec()));
            }
            Err(_) => std::thread::sleep(Duration::from_millis(1)),
        }
    }
}

/// Gives packets to a device when they are due, in order. One that it does not take (the device is
/// down) is lost.
fn write(to: &SyncDevice, posted: &Receiver<Posted>) {
    for (due, packet) in posted {
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        let _ = to.send(&packet);
    }
}

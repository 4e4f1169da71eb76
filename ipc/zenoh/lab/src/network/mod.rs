//! Hosts that are network namespaces, made with iproute2, and links between them.

mod bridge;
mod host;
mod ip;
mod leftovers;
mod namespace;
mod weather;

use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use bridge::Bridge;
pub(crate) use host::Host;
use ip::ip;
pub(crate) use weather::Weather;

use crate::error::Error;

/// Numbers the devices of this process.
static DEVICES: AtomicU32 = AtomicU32::new(0);

/// Makes hosts with these names; labs that were killed are cleared away first.
pub(crate) fn hosts<const N: usize>(names: [&str; N]) -> Result<[Host; N], Error> {
    leftovers::sweep()?;
    let made: Result<Vec<Host>, Error> = names
        .iter()
        .zip(1..)
        .map(|(name, number)| Host::create(name, number))
        .collect();
    let mut made = made?;
    let folders: Vec<PathBuf> = made
        .iter()
        .map(|host| host.folder().to_owned())
        .collect();
    made.iter_mut()
        .for_each(|host| host.hide(&folders));
    Ok(made.try_into().expect("as many hosts as names"))
}

/// Joins two hosts by a cable: the kernel's, as fast as loopback.
pub(crate) fn cable(first: &Host, second: &Host) -> Result<(), Error> {
    let [one, other] = device_names();
    ip(&format!("link add {one} type veth peer name {other}"))?;
    plug(&one, first, second)?;
    plug(&other, second, first)
}

/// A link with weather. It is gone when this is dropped.
pub(crate) struct Link(Bridge);

impl Link {
    /// Joins two hosts. What is lost is the same for equal seeds and packets.
    pub(crate) fn between(first: &Host, second: &Host, seed: u64) -> Result<Self, Error> {
        let [one, other] = device_names();
        let bridge = Bridge::create([&one, &other], seed)?;
        plug(&one, first, second)?;
        plug(&other, second, first)?;
        Ok(Self(bridge))
    }

    /// Lets it be so from now on.
    pub(crate) fn set(&self, weather: Weather) {
        self.0.set(weather);
    }
}

/// Two names that no other process takes, at most 15 bytes.
fn device_names() -> [String; 2] {
    let number = DEVICES.fetch_add(2, Ordering::Relaxed);
    [number, number + 1].map(|number| format!("tl{}x{number}", std::process::id()))
}

/// Makes a device one of a host's, as its way to another.
fn plug(device: &str, host: &Host, other: &Host) -> Result<(), Error> {
    let name = host.namespace();
    ip(&format!("link set {device} netns {name}"))?;
    ip(&format!(
        "-n {name} addr add {} peer {} dev {device}",
        host.address(),
        other.address()
    ))?;
    ip(&format!("-n {name} link set {device} up"))?;
    Ok(())
}

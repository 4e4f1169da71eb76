//! The lab itself: links do what they are told, hosts are apart, and nothing stays behind.

use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use super::trial::Trial;
use crate::error::Error;
use crate::network::{Host, Link, Weather, hosts};
use crate::row::Row;
use crate::statistics::{median, time};

const PATIENCE: Duration = Duration::from_millis(400);
/// Packets at once: fewer than a socket keeps.
const GROUP: u64 = 50;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let [first, second] = hosts(["a", "b"])?;
    let link = Link::between(&first, &second, trial.seed)?;
    let pair = Pair::on(&first, &second)?;
    let packets = trial.pick(2_000, 20_000);
    let mut rows = Vec::new();
    rows.push(is_whole("clear", &pair, packets)?);
    link.set(Weather::far(100, 0.0));
    rows.extend(delayed(&pair)?);
    link.set(Weather::far(0, 0.05));
    rows.push(lossy(&pair, packets)?);
    link.set(Weather::CUT);
    rows.push(Row::none("packets through a cut link", pair.through(200)?));
    link.set(Weather::CLEAR);
    rows.push(is_whole("healed", &pair, packets)?);
    Ok(rows)
}

/// Nothing is lost where no loss is asked for.
fn is_whole(what: &str, pair: &Pair, packets: u64) -> Result<Row, Error> {
    let through = pair.through(packets)?;
    Ok(Row::none(
        format!("packets lost on a {what} link, of {packets}"),
        packets - through,
    ))
}

/// Every round trip takes as long as both ways together; later only by what the machine takes.
fn delayed(pair: &Pair) -> Result<[Row; 2], Error> {
    let times = (0..20)
        .map(|_| pair.round_trip())
        .collect::<Result<Vec<f64>, Error>>()?;
    let middle = median(&times);
    let early = times.iter().filter(|&&time| time < 0.1).count();
    Ok([
        Row::none(
            "round trips below 100 ms where the link takes 50 ms a way, of 20",
            early as u64,
        ),
        Row::time(
            format!("round trip of 100 ms, median {}: above it", time(middle)),
            0.005,
            middle - 0.1,
        ),
    ])
}

/// By a binomial's five standard deviations.
fn lossy(pair: &Pair, packets: u64) -> Result<Row, Error> {
    let lost = packets - pair.through(packets)?;
    let part = lost as f64 / packets as f64;
    let allowed = 5.0 * (0.05 * 0.95 / packets as f64).sqrt();
    Ok(Row::is(
        format!("packets lost of {packets} at 5 %"),
        &format!("5 % +- {:.2}", allowed * 1e2),
        format!("{:.2} %", part * 1e2),
        (part - 0.05).abs() <= allowed,
    ))
}

/// A socket on each of two hosts.
struct Pair {
    sends: UdpSocket,
    answers: UdpSocket,
}

impl Pair {
    fn on(first: &Host, second: &Host) -> Result<Self, Error> {
        let socket = |host: &Host| {
            let address = SocketAddr::from((host.address(), 4000));
            host.within(|| {
                let socket = UdpSocket::bind(address)?;
                socket.set_read_timeout(Some(PATIENCE))?;
                Ok(socket)
            })
        };
        let pair = Self {
            sends: socket(first)?,
            answers: socket(second)?,
        };
        let of_second = SocketAddr::from((second.address(), 4000));
        pair.sends.connect(of_second).map_err(system)?;
        Ok(pair)
    }

    /// Sends so many, one way, a few at a time; tells how many came.
    fn through(&self, packets: u64) -> Result<u64, Error> {
        let mut came = 0;
        for group in 0..packets.div_ceil(GROUP) {
            let count = GROUP.min(packets - GROUP * group);
            for _ in 0..count {
                self.sends.send(b"packet").map_err(system)?;
            }
            came += self.take(count, Duration::from_millis(20))?;
        }
        Ok(came + self.take(packets - came, PATIENCE)?)
    }

    /// Takes what comes, until that many have or none comes any more.
    fn take(&self, count: u64, patience: Duration) -> Result<u64, Error> {
        self.answers
            .set_read_timeout(Some(patience))
            .map_err(system)?;
        let mut packet = [0; 64];
        let came = (0..count).take_while(|_| self.answers.recv(&mut packet).is_ok());
        Ok(came.count() as u64)
    }

    fn round_trip(&self) -> Result<f64, Error> {
        let mut packet = [0; 64];
        let start = Instant::now();
        self.sends.send(b"there").map_err(system)?;
        let (bytes, from) = self
            .answers
            .recv_from(&mut packet)
            .map_err(system)?;
        self.answers
            .send_to(&packet[..bytes], from)
            .map_err(system)?;
        self.sends.recv(&mut packet).map_err(system)?;
        Ok(start.elapsed().as_secs_f64())
    }
}

fn system(source: std::io::Error) -> Error {
    Error::System {
        what: "a packet",
        source,
    }
}

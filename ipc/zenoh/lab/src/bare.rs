//! Zenoh alone: the anchor of what a round trip costs.

use std::io::Write;
use std::time::{Duration, Instant};

use zenoh::bytes::ZBytes;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{ConsolidationMode, Query};
use zenoh::{Config, Session, Wait};

use crate::error::Error;

/// What the echo answers to.
const KEY: &str = "lab/echo";
const PATIENCE: Duration = Duration::from_secs(20);

/// Answer as many bytes as asked for, until standard input is closed
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// peer, client or router
    #[arg(long, default_value = "peer")]
    mode: String,
    /// Where to listen
    #[arg(long)]
    listen: Option<String>,
    /// Whom to connect to
    #[arg(long)]
    connect: Option<String>,
}

/// `taut-zenoh-lab echo`, hidden.
pub(crate) fn serve(arguments: &Arguments) -> Result<u8, Error> {
    let session = open(&arguments.mode, &arguments.listen, &arguments.connect)?;
    let _echo = session
        .declare_queryable(KEY)
        .complete(true)
        .callback(answer)
        .wait()
        .map_err(failed)?;
    // A parent that is gone does not read.
    let _ = writeln!(std::io::stdout(), "ready");
    let _ = std::io::stdin().read_line(&mut String::new());
    Ok(0)
}

/// The first eight bytes of a request say how many its answer has.
fn answer(query: Query) {
    let bytes = query
        .payload()
        .map(|payload| payload.to_bytes().into_owned())
        .unwrap_or_default();
    let Some(head) = bytes.first_chunk::<8>() else {
        return;
    };
    let mut back = bytes.clone();
    back.resize(u64::from_le_bytes(*head) as usize, 0);
    // A caller that is gone needs none.
    let _ = query
        .reply(query.key_expr(), back)
        .express(true)
        .wait();
}

/// A session with direct links, on what it is told to and nothing else.
pub(crate) fn open(
    mode: &str,
    listen: &Option<String>,
    connect: &Option<String>,
) -> Result<Session, Error> {
    let mut config = Config::default();
    let list = |one: &Option<String>| format!("{:?}", one.iter().collect::<Vec<_>>());
    let entries = [
        ("mode", format!("{mode:?}")),
        ("listen/endpoints", list(listen)),
        ("connect/endpoints", list(connect)),
        ("scouting/multicast/enabled", "false".to_owned()),
        ("scouting/gossip/enabled", "false".to_owned()),
    ];
    for (key, value) in entries {
        config
            .insert_json5(key, &value)
            .map_err(failed)?;
    }
    zenoh::open(config).wait().map_err(failed)
}

fn failed(error: impl std::fmt::Display) -> Error {
    Error::Zenoh(error.to_string())
}

/// Asks an echo.
pub(crate) struct Caller(Session);

impl Caller {
    /// Connects, and waits until the echo answers.
    pub(crate) fn open(connect: &str) -> Result<Self, Error> {
        let caller = Self(open("peer", &None, &Some(connect.to_owned()))?);
        let end = Instant::now() + PATIENCE;
        while caller.round(64, 64)?.is_none() {
            if Instant::now() > end {
                return Err(failed("the echo does not answer"));
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        Ok(caller)
    }

    /// Time from asking to the first reply (s); `None` where there is none.
    pub(crate) fn round(&self, there: usize, back: usize) -> Result<Option<f64>, Error> {
        let start = Instant::now();
        let mut request = vec![1; there.max(8)];
        request[..8].copy_from_slice(&(back as u64).to_le_bytes());
        let replies = self
            .0
            .get(KEY)
            .payload(ZBytes::from(request))
            .consolidation(ConsolidationMode::None)
            .congestion_control(CongestionControl::Block)
            .priority(Priority::DataHigh)
            .express(there <= 4096)
            .timeout(PATIENCE)
            .wait()
            .map_err(failed)?;
        let Ok(reply) = replies.recv() else {
            return Ok(None);
        };
        let came = reply
            .result()
            .is_ok_and(|sample| sample.payload().len() == back.max(8).min(sample.payload().len()));
        Ok(came.then(|| start.elapsed().as_secs_f64()))
    }
}

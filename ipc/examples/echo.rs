//! Round trip of a path through the transport alone:
//! `cargo run --release -p taut-ipc --example echo`.
//!
//! Starts itself again as the daemon, sends paths of several sizes and prints the median and the
//! 99th percentile. What a real daemon takes beyond this is its own work.

use std::process::{Child, Command};
use std::time::{Duration, Instant};
use taut_ipc::server::{IncomingRequest, Server};
use taut_ipc::wire::{Code, Mode, ResponseBody, ResponseHeader, Status};
use taut_ipc::{Client, DaemonState, Instance};

const ROUNDS: usize = 20_000;
const PATIENCE: Duration = Duration::from_secs(5);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let root = std::env::temp_dir().join(format!("taut-echo-{}", std::process::id()));
    match std::env::args().nth(1) {
        Some(root) => serve(&Instance::new("echo", root)?),
        None => {
            let instance = Instance::new("echo", &root)?;
            let mut daemon = Command::new(std::env::current_exe()?)
                .arg(&root)
                .spawn()?;
            let result = measure(&instance, &mut daemon);
            daemon.kill()?;
            daemon.wait()?;
            // The next daemon of this instance wipes what the killed one left.
            drop(Server::create(&instance)?);
            std::fs::remove_dir_all(&root)?;
            result
        }
    }
}

fn serve(instance: &Instance) -> Result<(), Box<dyn std::error::Error>> {
    let server = Server::create(instance)?;
    loop {
        while let Some(request) = server.receive()? {
            echo(request)?;
        }
        server.wait(Duration::from_secs(60))?;
    }
}

fn echo(mut request: IncomingRequest) -> Result<(), Box<dyn std::error::Error>> {
    let view = request.view()?;
    let path = view.path.to_vec();
    let header = ResponseHeader {
        status: Status::Final.into(),
        code: Code::Success.into(),
        waypoints: view.header.waypoints,
        variables: view.header.variables,
        ..ResponseHeader::default()
    };
    request.send(
        &header,
        &ResponseBody {
            path: &path,
            ..ResponseBody::default()
        },
    )?;
    Ok(())
}

fn measure(instance: &Instance, daemon: &mut Child) -> Result<(), Box<dyn std::error::Error>> {
    while !matches!(
        taut_ipc::daemon_state(instance)?,
        DaemonState::Running { .. }
    ) {
        if daemon.try_wait()?.is_some() {
            return Err("the daemon ended".into());
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let client = Client::connect(instance)?;
    println!(
        "{:>10} {:>10} {:>10}   {ROUNDS} rounds, two processes",
        "bytes", "p50 us", "p99 us"
    );
    for waypoints in [1, 64, 1024, 16_384, 131_072] {
        let mut times = Vec::with_capacity(ROUNDS);
        for _ in 0..if waypoints > 1024 {
            ROUNDS / 20
        } else {
            ROUNDS
        } {
            let start = Instant::now();
            round_trip(&client, waypoints)?;
            times.push(start.elapsed().as_secs_f64() * 1e6);
        }
        times.sort_by(f64::total_cmp);
        let at = |part: f64| times[(times.len() as f64 * part) as usize];
        println!(
            "{:>10} {:>10.1} {:>10.1}",
            waypoints * 64,
            at(0.5),
            at(0.99)
        );
    }
    Ok(())
}

fn round_trip(client: &Client, waypoints: u32) -> Result<(), taut_ipc::ClientError> {
    let mut request = client.request(waypoints, 8);
    request.header.mode = Mode::Check.into();
    let mut loan = request.loan()?;
    loan.path_mut().fill(1.0);
    let response = loan.send()?.wait(PATIENCE)?;
    assert_eq!(response.path().len(), waypoints as usize * 8);
    Ok(())
}

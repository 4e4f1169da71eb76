//! `daemon.toml`: what `taut serve` is started with.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::net::SocketAddr;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use taut::files::{FileError, Geometry, RobotFiles};
use taut::optimize::Settings;
use taut_ipc::limits::{ACTIVE_REQUESTS_PER_CLIENT, MAX_PAYLOAD};

use crate::daemon::observe::live::check_address;

/// The configuration; every entry has a default, unknown ones are refused.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Instance to serve: `name`, `name:/root`, or empty for the default one. `--instance` and
    /// `TAUT_INSTANCE` go before it.
    pub instance: String,
    /// Worker threads; 0 = as many as there are cores.
    pub workers: usize,
    /// Niceness of the threads that compute and answer, 0 to 19; control loops of this machine go
    /// before them.
    pub niceness: i32,
    /// Clearance of requests that name none (m).
    pub clearance_m: f64,
    /// Requests that may wait.
    pub queue: usize,
    /// What one client may have.
    pub quota: Quota,
    /// Where Prometheus reads, such as 127.0.0.1:9464: an address of this machine only. Nowhere if
    /// it is missing.
    pub metrics: Option<SocketAddr>,
    /// Where the page is served that shows what runs and the last answers, such as 127.0.0.1:8642:
    /// an address of this machine only. Nowhere if it is missing; `--http` goes before it.
    pub http: Option<SocketAddr>,
    /// Megabytes that files may have together which clients of other machines give.
    pub files_mb: u64,
    /// Status messages per second, at least 2: the second that follows a client's death ends its
    /// connection.
    pub status_rate_hz: f64,
    /// Folder that keeps robots and scenes while no daemon runs; the default one (see
    /// [`crate::daemon::state`]) where it is missing, nothing is kept where it is empty.
    pub state: Option<PathBuf>,
    /// How long the daemon may give no sign of life before its supervisor restarts it (s).
    pub watchdog_s: f64,
    /// Lets a request with [`crate::daemon::shell::worker::PANIC_SEED`] panic, one with
    /// [`crate::daemon::shell::worker::HANG_SEED`] hang until it is told to stop, and one with
    /// [`crate::daemon::shell::worker::BREAK_SEED`] end its thread. For tests only.
    pub fault_injection: bool,
    /// Robots to load.
    pub robots: Vec<RobotConfig>,
    /// Scenes to load.
    pub scenes: Vec<SceneConfig>,
    /// Problem files whose robot and scene to load.
    pub problems: Vec<ProblemConfig>,
}

/// What one client may have; a connection is a client.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Quota {
    /// Requests in flight.
    pub in_flight: usize,
    /// Bytes of its requests in flight.
    pub bytes: usize,
    /// Share of the workers' time over some seconds, beyond which its requests are refused; 1 = no
    /// limit, others get their turn all the same.
    pub cpu_share: f64,
}

impl Default for Quota {
    fn default() -> Self {
        Self {
            in_flight: ACTIVE_REQUESTS_PER_CLIENT,
            bytes: 4 * MAX_PAYLOAD,
            cpu_share: 1.0,
        }
    }
}

/// A robot to load; names of files start at the folder of the configuration.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotConfig {
    /// Its label.
    pub label: String,
    /// Its URDF.
    pub urdf: PathBuf,
    /// Its SRDF.
    pub srdf: Option<PathBuf>,
    /// Folders of packages by name.
    #[serde(default)]
    pub packages: BTreeMap<String, PathBuf>,
    /// Columns of a path; all movable joints where it is missing.
    pub variables: Option<Vec<String>>,
    /// Link pairs that may touch, besides the SRDF's.
    #[serde(default)]
    pub allowed_collisions: Vec<(String, String)>,
}

/// A scene to load.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneConfig {
    /// Its label.
    pub label: String,
    /// Its file, or a problem file.
    pub file: PathBuf,
}

/// A problem whose robot and scene to load.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProblemConfig {
    /// Its file.
    pub file: PathBuf,
    /// Label of the robot; the robot's own name where it is missing.
    pub robot: Option<String>,
    /// Label of the scene; the problem's name where it is missing.
    pub scene: Option<String>,
    /// Which of the robot's models to take.
    #[serde(default)]
    pub geometry: GeometryConfig,
}

/// Which of a robot's models to take.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GeometryConfig {
    /// Its own shapes.
    #[default]
    Given,
    /// Its spheres.
    Spheres,
}

impl From<GeometryConfig> for Geometry {
    fn from(geometry: GeometryConfig) -> Self {
        match geometry {
            GeometryConfig::Given => Self::Given,
            GeometryConfig::Spheres => Self::Spheres,
        }
    }
}

impl Default for Config {
    fn default() -> Self {
        Self {
            instance: String::new(),
            workers: 0,
            niceness: 0,
            clearance_m: Settings::DEFAULT_CLEARANCE_M,
            queue: 256,
            quota: Quota::default(),
            metrics: None,
            http: None,
            files_mb: 1024,
            status_rate_hz: 2.0,
            state: None,
            watchdog_s: 10.0,
            fault_injection: false,
            robots: Vec::new(),
            scenes: Vec::new(),
            problems: Vec::new(),
        }
    }
}

impl Config {
    /// Reads a configuration.
    ///
    /// # Errors
    /// A file that cannot be read, an unknown entry, or a value out of its range, with line and
    /// valid entries.
    pub fn read(file: &Path) -> Result<Self, FileError> {
        let text = std::fs::read_to_string(file).map_err(|error| FileError::Unreadable {
            file: file.to_owned(),
            reason: error.to_string(),
        })?;
        let mut config = Self::parse(&text).map_err(|text| FileError::Content {
            file: file.to_owned(),
            text,
        })?;
        config.start_names_at(file.parent().unwrap_or(Path::new("")));
        Ok(config)
    }

    fn parse(text: &str) -> Result<Self, String> {
        let config: Self = toml::from_str(text).map_err(|error| one_line(text, &error))?;
        config.check()?;
        Ok(config)
    }

    /// Threads that compute.
    pub fn worker_count(&self) -> usize {
        match self.workers {
            0 => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            count => count,
        }
    }

    fn check(&self) -> Result<(), String> {
        check_clearance(self.clearance_m)?;
        self.check_numbers()?;
        self.quota.check()?;
        self.check_addresses()?;
        check_niceness("niceness", self.niceness)?;
        self.check_workers()
    }

    fn check_numbers(&self) -> Result<(), String> {
        within("status_rate_hz", self.status_rate_hz, 2.0..=50.0)?;
        within("watchdog_s", self.watchdog_s, 1.0..=3600.0)?;
        within("files_mb", self.files_mb, 1..=1_048_576)?;
        within("queue", self.queue, 1..=65_536)
    }

    fn check_addresses(&self) -> Result<(), String> {
        self.metrics.map_or(Ok(()), check_metrics)?;
        self.http
            .map_or(Ok(()), |address| check_address("http", address))
    }

    fn check_workers(&self) -> Result<(), String> {
        let workers = self.workers;
        match workers {
            0..=1024 => Ok(()),
            _ => Err(format!(
                "workers is {workers}; valid: 0 (one per core) to 1024"
            )),
        }
    }

    fn start_names_at(&mut self, folder: &Path) {
        for name in self.names() {
            *name = folder.join(&*name);
        }
    }

    /// The names of files and folders in it.
    fn names(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let state = self.state.as_mut();
        let state = state.filter(|state| !state.as_os_str().is_empty());
        let robots = self
            .robots
            .iter_mut()
            .flat_map(RobotConfig::names);
        let scenes = self
            .scenes
            .iter_mut()
            .map(|scene| &mut scene.file);
        let problems = self
            .problems
            .iter_mut()
            .map(|problem| &mut problem.file);
        state
            .into_iter()
            .chain(robots)
            .chain(scenes)
            .chain(problems)
    }
}

impl RobotConfig {
    /// Its files.
    pub(crate) fn files(&self) -> RobotFiles {
        RobotFiles {
            urdf: self.urdf.clone(),
            srdf: self.srdf.clone(),
            packages: self.packages.clone(),
            variables: self.variables.clone(),
            allowed_collisions: self.allowed_collisions.clone(),
            ..RobotFiles::default()
        }
    }

    /// Its names of files and folders.
    fn names(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        [&mut self.urdf]
            .into_iter()
            .chain(&mut self.srdf)
            .chain(self.packages.values_mut())
    }
}

impl Quota {
    fn check(&self) -> Result<(), String> {
        let most = ACTIVE_REQUESTS_PER_CLIENT;
        within("quota.in_flight", self.in_flight, 1..=most)?;
        self.check_bytes()?;
        self.check_share()
    }

    fn check_bytes(&self) -> Result<(), String> {
        let bytes = self.bytes;
        if bytes >= MAX_PAYLOAD {
            return Ok(());
        }
        Err(format!(
            "quota.bytes is {bytes}; valid: at least {MAX_PAYLOAD}, one request"
        ))
    }

    fn check_share(&self) -> Result<(), String> {
        let share = self.cpu_share;
        if share > 0.0 && share <= 1.0 {
            return Ok(());
        }
        Err(format!(
            "quota.cpu_share is {share}; valid: more than 0, at most 1"
        ))
    }
}

fn check_clearance(clearance_m: f64) -> Result<(), String> {
    if clearance_m.is_finite() && clearance_m > 0.0 {
        return Ok(());
    }
    Err(format!(
        "clearance_m is {clearance_m}; it must be finite and greater than 0"
    ))
}

/// Refuses what is no niceness that every process may take.
pub fn check_niceness(entry: &str, niceness: i32) -> Result<(), String> {
    within(entry, niceness, 0..=19)
}

fn check_metrics(address: SocketAddr) -> Result<(), String> {
    if address.ip().is_loopback() {
        return Ok(());
    }
    Err(format!(
        "metrics is {address}; valid: an address of this machine, such as 127.0.0.1:9464"
    ))
}

fn within<T: PartialOrd + Display>(
    entry: &str,
    value: T,
    valid: RangeInclusive<T>,
) -> Result<(), String> {
    if valid.contains(&value) {
        return Ok(());
    }
    let (least, most) = valid.into_inner();
    Err(format!("{entry} is {value}; valid: {least} to {most}"))
}

/// What TOML says is wrong, with the line, without the picture.
fn one_line(text: &str, error: &toml::de::Error) -> String {
    let line = error.span().map_or(0, |span| {
        text[..span.start.min(text.len())]
            .matches('\n')
            .count()
            + 1
    });
    format!("line {line}: {}", error.message().replace('\n', " "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_has_a_default_and_unknown_ones_are_refused() {
        let config: Config = toml::from_str("").unwrap();
        assert_eq!((config.queue, config.worker_count() > 0), (256, true));
        let text = "workers = 2\n\n[[scenes]]\nlabel = \"a\"\nfile = \"b\"\nclearence = 3\n";
        let error = one_line(text, &toml::from_str::<Config>(text).unwrap_err());
        assert!(
            error.starts_with("line 6: unknown field `clearence`") && !error.contains('\n'),
            "{error}"
        );
        for (text, part) in [
            ("queue = 0", "1 to 65536"),
            ("files_mb = 0", "1 to 1048576"),
            ("clearance_m = nan", "finite"),
            ("status_rate_hz = 1", "2 to"),
            ("niceness = -1", "0 to 19"),
            ("niceness = 20", "0 to 19"),
            ("quota = { in_flight = 0 }", "1 to"),
            ("metrics = '0.0.0.0:1'", "of this machine"),
            ("http = '0.0.0.0:8642'", "of this machine"),
            ("quota = { cpu_share = 0.0 }", "more than 0"),
        ] {
            let error = toml::from_str::<Config>(text)
                .unwrap()
                .check()
                .unwrap_err();
            assert!(error.contains(part), "{error}");
        }
    }
}

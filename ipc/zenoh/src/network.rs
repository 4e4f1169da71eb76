//! A session of Zenoh with the settings that the service needs.

use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use zenoh::{Config, Session, Wait};

/// Where gateways listen and clients connect unless somebody says otherwise.
pub const LOOPBACK: &str = "tcp/127.0.0.1:7447";
/// Where a node listens: the router tells others which port it is.
pub const ANY_PORT: &str = "tcp/127.0.0.1:0";
/// Most bytes of a message: a payload, its header, and some.
const MESSAGE_MAX: usize = 17 * 1024 * 1024;

/// Who is listened to, and who is connected to.
#[derive(Clone, Debug, Default)]
pub struct Network {
    /// Endpoints to listen at.
    pub listen: Vec<String>,
    /// Endpoints of gateways or routers.
    pub connect: Vec<String>,
    /// Zenoh's own configuration, which wins.
    pub config: Option<PathBuf>,
    /// Whether peers that a router names are linked to directly, as nodes of rmw_zenoh are.
    pub finds_peers: bool,
}

/// Why there is no session.
#[derive(Debug, thiserror::Error)]
pub enum NetworkError {
    /// The configuration cannot be read.
    #[error("{path}: {source}")]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The configuration is none.
    #[error("{path}: {reason}; see Zenoh's DEFAULT_CONFIG.json5 for what there is")]
    Config {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// An endpoint or setting is refused.
    #[error("{setting} = {value}: {reason}; endpoints look like tcp/HOST:PORT or tls/HOST:PORT")]
    Setting {
        /// Its name in Zenoh's configuration.
        setting: String,
        /// What it was to be.
        value: String,
        /// What Zenoh said.
        reason: String,
    },
    /// The session cannot be opened.
    #[error("no session of Zenoh: {0}")]
    Open(String),
    /// Something cannot be declared.
    #[error("cannot declare {what}: {reason}")]
    Declare {
        /// What.
        what: String,
        /// What Zenoh said.
        reason: String,
    },
}

impl Network {
    /// Connects to these endpoints, and listens to nobody.
    pub fn to(endpoints: &[impl AsRef<str>]) -> Self {
        let connect = endpoints
            .iter()
            .map(|endpoint| endpoint.as_ref().to_owned());
        Self {
            connect: connect.collect(),
            ..Self::default()
        }
    }

    /// Opens the session.
    ///
    /// # Errors
    /// [`NetworkError`]. Gateways that are not there yet are no error.
    pub fn open(&self) -> Result<Session, NetworkError> {
        let config = self.config()?;
        zenoh::open(config)
            .wait()
            .map_err(|error| NetworkError::Open(reason(&error)))
    }

    /// Ours, then the file's, then what was named one by one.
    fn config(&self) -> Result<Config, NetworkError> {
        let mut config = Config::default();
        for (setting, value) in settings() {
            insert(&mut config, setting, &value)?;
        }
        insert(&mut config, GOSSIP, &json!(self.finds_peers))?;
        if let Some(path) = &self.config {
            let file = read(path)?;
            merge(&mut config, path, "", &file)?;
        }
        for (setting, endpoints) in [
            ("listen/endpoints", &self.listen),
            ("connect/endpoints", &self.connect),
        ] {
            if !endpoints.is_empty() {
                insert(&mut config, setting, &json!(endpoints))?;
            }
        }
        Ok(config)
    }
}

/// By which a router tells a peer of others.
const GOSSIP: &str = "scouting/gossip/enabled";

/// Direct links, nobody found by chance, a dead link noticed within a second, and nobody waited for
/// longer.
fn settings() -> [(&'static str, Value); 9] {
    let block = "transport/link/tx/queue/congestion_control/block/wait_before_close";
    let retry = json!({ "period_init_ms": 50, "period_max_ms": 1000, "period_increase_factor": 2 });
    [
        ("mode", json!("peer")),
        // A peer would listen everywhere.
        ("listen/endpoints", json!([])),
        ("scouting/multicast/enabled", json!(false)),
        ("connect/timeout_ms", json!(-1)),
        ("connect/exit_on_failure", json!(false)),
        ("connect/retry", retry),
        ("transport/link/tx/lease", json!(1000)),
        (block, json!(1_000_000)),
        ("transport/link/rx/max_message_size", json!(MESSAGE_MAX)),
    ]
}

fn insert(config: &mut Config, setting: &str, value: &Value) -> Result<(), NetworkError> {
    let value = value.to_string();
    config
        .insert_json5(setting, &value)
        .map_err(|error| NetworkError::Setting {
            setting: setting.to_owned(),
            value,
            reason: reason(&error),
        })
}

fn read(path: &Path) -> Result<Map<String, Value>, NetworkError> {
    let text = std::fs::read_to_string(path);
    let text = text.map_err(|source| NetworkError::Unreadable {
        path: path.to_owned(),
        source,
    })?;
    json5::from_str(&text).map_err(|error| wrong(path, error))
}

fn wrong(path: &Path, reason: impl std::fmt::Display) -> NetworkError {
    NetworkError::Config {
        path: path.to_owned(),
        reason: reason.to_string(),
    }
}

/// What Zenoh said, without the lines of its source that it ends with.
fn reason(error: &impl std::fmt::Display) -> String {
    let text = error.to_string();
    let said = text.split(" at /").next();
    said.unwrap_or_default().to_owned()
}

/// Sets what a file sets, and nothing else. What is no tree of settings (endpoints of each mode) is
/// set as a whole.
fn merge(
    config: &mut Config,
    path: &Path,
    above: &str,
    settings: &Map<String, Value>,
) -> Result<(), NetworkError> {
    for (name, value) in settings {
        let setting = match above {
            "" => name.clone(),
            _ => format!("{above}/{name}"),
        };
        let inner = value
            .as_object()
            .filter(|inner| !inner.is_empty());
        if inner.is_some_and(|inner| merge(config, path, &setting, inner).is_ok()) {
            continue;
        }
        let set = insert(config, &setting, value);
        set.map_err(|error| wrong(path, error))?;
    }
    Ok(())
}

/// What Zenoh said when something was declared.
pub(crate) fn declared<T, E: std::fmt::Display>(
    what: &str,
    result: Result<T, E>,
) -> Result<T, NetworkError> {
    result.map_err(|error| NetworkError::Declare {
        what: what.to_owned(),
        reason: reason(&error),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(text: &str) -> Result<Config, NetworkError> {
        let folder = std::env::temp_dir();
        let path = folder.join(format!("taut-{}-{:p}.json5", std::process::id(), text));
        std::fs::write(&path, text).unwrap();
        let network = Network {
            config: Some(path.clone()),
            ..Network::default()
        };
        let config = network.config();
        std::fs::remove_file(path).unwrap();
        config
    }

    fn value(config: &Config, key: &str) -> String {
        config.get_json(key).unwrap()
    }

    #[test]
    fn a_file_sets_what_it_names_and_leaves_the_rest() {
        let text = "{ mode: 'client', connect: { endpoints: ['tcp/[::1]:7'] }, \
                    transport: { link: { tx: { lease: 3000 } } } }";
        let config = config(text).unwrap();
        assert_eq!(value(&config, "mode"), "\"client\"");
        assert_eq!(value(&config, "transport/link/tx/lease"), "3000");
        assert_eq!(value(&config, "scouting/multicast/enabled"), "false");
        assert_eq!(value(&config, "connect/endpoints"), "[\"tcp/[::1]:7\"]");
        let max = value(&config, "transport/link/rx/max_message_size");
        assert_eq!(max, MESSAGE_MAX.to_string());
    }

    #[test]
    fn endpoints_of_each_mode_are_set_as_a_whole() {
        let config = config("{ listen: { endpoints: { peer: ['tcp/[::1]:7'] } } }").unwrap();
        assert!(value(&config, "listen/endpoints").contains("tcp/[::1]:7"));
    }

    #[test]
    fn wrong_settings_are_named() {
        let error = config("{ scouting: { multicats: { enabled: true } } }").unwrap_err();
        assert!(error.to_string().contains("multicats"), "{error}");
        let error = config("{ mode: ").unwrap_err();
        assert!(error.to_string().contains("json5"), "{error}");
    }
}

//! Keys on the network, below `taut/v1`.

use crate::call::Gateway;

const DAEMON_TOKENS: &str = "taut/v1/live/d";
const CLIENT_TOKENS: &str = "taut/v1/live/c";
const UNFIT_TOKENS: &str = "taut/v1/live/x";
/// Longest name of a daemon, in bytes.
pub const NAME_MAX: usize = 64;

/// Whether a daemon may be called so.
pub fn is_name(name: &str) -> bool {
    let is_allowed = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    (1..=NAME_MAX).contains(&name.len()) && name != "live" && name.chars().all(is_allowed)
}

/// Requests to a daemon.
pub fn optimize(daemon: &str) -> String {
    format!("taut/v1/{daemon}/optimize")
}

/// Control messages to a daemon.
pub fn control(daemon: &str) -> String {
    format!("taut/v1/{daemon}/control")
}

/// What a daemon does; `*` = of all daemons.
pub fn status(daemon: &str) -> String {
    format!("taut/v1/{daemon}/status")
}

/// Changes of a scene of a daemon.
pub fn scene_event(daemon: &str, scene: u64) -> String {
    format!("taut/v1/{daemon}/scene/{scene:016x}/event")
}

/// Changes of all scenes of a daemon; `*` = of all daemons.
pub fn scene_events(daemon: &str) -> String {
    format!("taut/v1/{daemon}/scene/*/event")
}

/// What is wanted of a request that was sent before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Drop it.
    Cancel,
    /// Answer with the best so far.
    Finish,
}

impl Wish {
    fn word(self) -> &'static str {
        match self {
            Self::Cancel => "cancel",
            Self::Finish => "finish",
        }
    }

    /// Where it is said of one request.
    pub fn key(self, daemon: &str, client: u64, request: u64) -> String {
        let word = self.word();
        format!("taut/v1/{daemon}/{word}/{client:016x}/{request:016x}")
    }

    /// Where it is said of all requests to a daemon.
    pub fn all(self, daemon: &str) -> String {
        let word = self.word();
        format!("taut/v1/{daemon}/{word}/*/*")
    }
}

/// Client and request of a key of a [`Wish`].
pub fn client_and_request(key: &str) -> Option<(u64, u64)> {
    let mut parts = key.rsplit('/');
    let request = hexadecimal(parts.next()?)?;
    let client = hexadecimal(parts.next()?)?;
    Some((client, request))
}

/// The token of a gateway whose daemon is there.
pub fn daemon_token(gateway: &Gateway) -> String {
    format!("{DAEMON_TOKENS}/{}/{:016x}", gateway.name, gateway.boot)
}

/// The tokens of all gateways.
pub fn daemon_tokens() -> String {
    format!("{DAEMON_TOKENS}/*/*")
}

/// The gateway that a token tells of.
pub fn gateway_of(key: &str) -> Option<Gateway> {
    let rest = key
        .strip_prefix(DAEMON_TOKENS)?
        .strip_prefix('/')?;
    let (name, boot) = rest.split_once('/')?;
    let boot = hexadecimal(boot)?;
    is_name(name).then(|| Gateway {
        name: name.into(),
        boot,
    })
}

/// Longest reason in a token, in bytes.
pub const REASON_MAX: usize = 240;

/// The token of a gateway whose daemon cannot be served, with the reason: in hexadecimal digits, for
/// a key takes not every letter.
pub fn unfit_token(daemon: &str, reason: &str) -> String {
    let reason = &reason[..reason.floor_char_boundary(REASON_MAX)];
    let digits: String = reason
        .bytes()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    format!("{UNFIT_TOKENS}/{daemon}/{digits}")
}

/// The tokens of all gateways whose daemons cannot be served.
pub fn unfit_tokens() -> String {
    format!("{UNFIT_TOKENS}/*/*")
}

/// Daemon and reason of such a token.
pub fn unfit_of(key: &str) -> Option<(&str, String)> {
    let rest = key
        .strip_prefix(UNFIT_TOKENS)?
        .strip_prefix('/')?;
    let (daemon, digits) = rest.split_once('/')?;
    let is_sound = is_name(daemon) && digits.len() <= 2 * REASON_MAX && digits.len() % 2 == 0;
    let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok();
    let bytes: Option<Vec<u8>> = digits.as_bytes().chunks(2).map(byte).collect();
    let reason = String::from_utf8(bytes?).ok()?;
    let is_line = !reason.chars().any(char::is_control);
    (is_sound && is_line).then_some((daemon, reason))
}

/// The token of a client.
pub fn client_token(client: u64) -> String {
    format!("{CLIENT_TOKENS}/{client:016x}")
}

/// The tokens of all clients.
pub fn client_tokens() -> String {
    format!("{CLIENT_TOKENS}/*")
}

/// The client that a token tells of.
pub fn client_of(key: &str) -> Option<u64> {
    key.strip_prefix(CLIENT_TOKENS)?
        .strip_prefix('/')
        .and_then(hexadecimal)
}

/// The daemon that a key below its name belongs to.
pub fn daemon_of(key: &str) -> Option<&str> {
    let rest = key.strip_prefix("taut/v1/")?;
    rest.split('/').next()
}

/// Exactly as they are written: what is written in two ways could be two clients.
fn hexadecimal(digits: &str) -> Option<u64> {
    let number = u64::from_str_radix(digits, 16).ok()?;
    (format!("{number:016x}") == digits).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        let gateway = Gateway {
            name: "cell-7.left".into(),
            boot: 0xab,
        };
        assert_eq!(gateway_of(&daemon_token(&gateway)), Some(gateway));
        assert_eq!(client_of(&client_token(7)), Some(7));
        let key = Wish::Cancel.key("cell", 1, u64::MAX);
        assert_eq!(client_and_request(&key), Some((1, u64::MAX)));
        assert_eq!(daemon_of(&key), Some("cell"));
    }

    #[test]
    fn a_reason_survives_the_way_as_a_key_and_nothing_else_is_one() {
        let reason = "wire version 9, this side speaks 1; é * / ?";
        let key = unfit_token("cell", reason);
        assert_eq!(unfit_of(&key), Some(("cell", reason.to_owned())));
        let long = unfit_token("cell", &"é".repeat(REASON_MAX));
        assert_eq!(unfit_of(&long).unwrap().1.len(), REASON_MAX);
        for key in [
            "taut/v1/live/x/cell/6",
            "taut/v1/live/x/cell/zz",
            "taut/v1/live/x/cell/0a",
            "taut/v1/live/x/cell/ff",
            "taut/v1/live/x/a b/61",
            "taut/v1/live/x/cell/+1",
            &format!("taut/v1/live/x/cell/{}", "61".repeat(REASON_MAX + 1)),
        ] {
            assert_eq!(unfit_of(key), None, "{key}");
        }
    }

    #[test]
    fn other_keys_are_nobodys() {
        for key in [
            "",
            "taut/v1/live/d/a",
            "taut/v1/live/d/a/1",
            "taut/v1/live/d/a b/0000000000000001",
        ] {
            assert_eq!(gateway_of(key), None, "{key}");
        }
        for key in [
            "taut/v1/live/c/+000000000000001",
            "taut/v1/live/c/000000000000000G",
            "x/7",
        ] {
            assert_eq!(client_of(key), None, "{key}");
        }
        assert_eq!(client_and_request("taut/v1/a/cancel/1/2"), None);
        assert!(!is_name("") && !is_name("live") && !is_name("a/b") && !is_name("*"));
    }
}

//! The page: on this machine's own address, and to this machine's own name only.

use std::net::SocketAddr;

use tiny_http::{Header, Method, Request, Response};

use super::Live;
use crate::view::live_page;

/// Refuses what another machine could reach: whoever sees the page sees every robot, scene and
/// path.
///
/// # Errors
/// What is wrong, with a valid address.
pub fn check_address(what: &str, address: SocketAddr) -> Result<(), String> {
    if address.ip().is_loopback() {
        return Ok(());
    }
    Err(format!(
        "{what} is {address}; valid: an address of this machine only, such as 127.0.0.1:8642"
    ))
}

/// Answers what the page asks for.
pub(in crate::daemon) fn answer(request: Request, live: &Live) {
    let host = request
        .headers()
        .iter()
        .find(|header| header.field.equiv("Host"));
    let (status, kind, body) = if !host.is_some_and(|host| is_own_name(host.value.as_str())) {
        // A foreign page whose name was made to lead here sends that name.
        (
            403,
            "text/plain",
            "this page is for 127.0.0.1, ::1 and localhost only\n".to_owned(),
        )
    } else if *request.method() != Method::Get {
        (405, "text/plain", "only GET\n".to_owned())
    } else {
        match request.url() {
            "/" => (200, "text/html", live_page()),
            "/state" => (200, "application/json", live.json()),
            other => match other
                .strip_prefix("/answer/")
                .and_then(|number| live.picture(number.parse().ok()?))
            {
                Some(picture) => (200, "application/json", picture),
                None => (
                    404,
                    "text/plain",
                    "no such page, or an answer that is not kept any more; see /\n".to_owned(),
                ),
            },
        }
    };
    let header = |text: &str| text.parse::<Header>().expect("a header");
    let response = Response::from_string(body)
        .with_status_code(status)
        .with_header(header(&format!("Content-Type: {kind}; charset=utf-8")))
        .with_header(header("Cache-Control: no-store"))
        .with_header(header("X-Content-Type-Options: nosniff"))
        .with_header(header("X-Frame-Options: DENY"));
    // A reader that went away needs no answer.
    let _ = request.respond(response);
}

/// Whether a `Host` header names this machine by a name that nobody else can give.
fn is_own_name(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.chars().all(|digit| digit.is_ascii_digit()) => name,
        _ => host,
    };
    ["127.0.0.1", "[::1]", "localhost"]
        .iter()
        .any(|own| name.eq_ignore_ascii_case(own))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_of_this_machine_are_answered() {
        for own in [
            "127.0.0.1:8642",
            "localhost",
            "LOCALHOST:1",
            "[::1]:8642",
            "[::1]",
        ] {
            assert!(is_own_name(own), "{own}");
        }
        for foreign in [
            "evil.example",
            "evil.example:8642",
            "127.0.0.1.evil.example",
            "localhost:1.evil",
            "",
            ":8642",
        ] {
            assert!(!is_own_name(foreign), "{foreign}");
        }
    }

    #[test]
    fn only_addresses_of_this_machine_are_served() {
        check_address("http", "[::1]:0".parse().unwrap()).unwrap();
        let error = check_address("http", "0.0.0.0:8642".parse().unwrap()).unwrap_err();
        assert!(
            error.contains("0.0.0.0:8642") && error.contains("127.0.0.1:8642"),
            "{error}"
        );
    }
}

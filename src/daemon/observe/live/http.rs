//! The page: on this machine's own address, and to this machine's own name only.

use std::io::Cursor;
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
pub(crate) fn answer(request: Request, live: &Live) {
    let page = if !is_to_own_name(&request) {
        // A foreign page whose name was made to lead here sends that name.
        Page::text(403, "this page is for 127.0.0.1, ::1 and localhost only\n")
    } else if *request.method() != Method::Get {
        Page::text(405, "only GET\n")
    } else {
        found(request.url(), live)
    };
    // A reader that went away needs no answer.
    let _ = request.respond(page.response());
}

/// What a request is answered with.
struct Page {
    status: u16,
    kind: &'static str,
    body: String,
}

impl Page {
    fn text(status: u16, text: &str) -> Self {
        Self {
            status,
            kind: "text/plain",
            body: text.to_owned(),
        }
    }

    fn json(body: String) -> Self {
        Self {
            status: 200,
            kind: "application/json",
            body,
        }
    }

    fn html(body: String) -> Self {
        Self {
            status: 200,
            kind: "text/html",
            body,
        }
    }

    fn missing() -> Self {
        Self::text(
            404,
            "no such page, or an answer that is not kept any more; see /\n",
        )
    }

    fn response(self) -> Response<Cursor<Vec<u8>>> {
        let kind = format!("Content-Type: {}; charset=utf-8", self.kind);
        Response::from_string(self.body)
            .with_status_code(self.status)
            .with_header(header(&kind))
            .with_header(header("Cache-Control: no-store"))
            .with_header(header("X-Content-Type-Options: nosniff"))
            .with_header(header("X-Frame-Options: DENY"))
    }
}

fn header(text: &str) -> Header {
    text.parse().expect("a header")
}

fn found(url: &str, live: &Live) -> Page {
    match url {
        "/" => Page::html(live_page()),
        "/state" => Page::json(live.json()),
        other => picture(other, live).map_or_else(Page::missing, Page::json),
    }
}

fn picture(url: &str, live: &Live) -> Option<String> {
    let number = url.strip_prefix("/answer/")?;
    live.picture(number.parse().ok()?)
}

fn is_to_own_name(request: &Request) -> bool {
    let mut headers = request.headers().iter();
    let host = headers.find(|header| header.field.equiv("Host"));
    host.is_some_and(|host| is_own_name(host.value.as_str()))
}

/// Whether a `Host` header names this machine by a name that nobody else can give.
fn is_own_name(host: &str) -> bool {
    let name = without_port(host);
    let own = ["127.0.0.1", "[::1]", "localhost"];
    own.iter()
        .any(|own| name.eq_ignore_ascii_case(own))
}

fn without_port(host: &str) -> &str {
    match host.rsplit_once(':') {
        Some((name, port)) if is_number(port) => name,
        _ => host,
    }
}

fn is_number(text: &str) -> bool {
    text.chars().all(|digit| digit.is_ascii_digit())
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

//! Pictures of answers: a robot, its scene and its paths as a page draws them, and that page.
//!
//! `page/` holds the page's sources and what its script makes of them (`page.js`); nothing else is
//! needed to build.

// A new kind of shape, core or joint is an error here, not another one's arm.
#![deny(clippy::wildcard_enum_match_arm)]

mod kept;
mod picture;
mod region;
mod shapes;
mod urdf_text;

pub(crate) use picture::{Picture, Sight};

const HEAD: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
const SCRIPT: &str = include_str!("page/page.js");

/// The page of one picture, whole in itself.
pub(crate) fn page(picture: &Picture) -> String {
    let data =
        serde_json::to_string(picture).expect("a picture holds only strings, booleans and numbers");
    // No text of a user's may end the element that it stands in.
    filled("still", &data.replace('<', "\\u003c"))
}

/// The page that asks the daemon that serves it.
pub(crate) fn live_page() -> String {
    filled("live", "null")
}

fn filled(kind: &str, data: &str) -> String {
    let parts = [
        ("@kind@", kind),
        ("@style@", STYLE),
        ("@script@", SCRIPT),
        ("@data@", data),
    ];
    let mut page = String::with_capacity(HEAD.len() + STYLE.len() + SCRIPT.len() + data.len());
    let mut rest = HEAD;
    for (mark, text) in parts {
        rest = fill(&mut page, rest, mark, text);
    }
    page + rest
}

/// Adds what stands before a mark, and the text in its place; gives what stands after it.
fn fill<'a>(page: &mut String, rest: &'a str, mark: &str, text: &str) -> &'a str {
    let (before, after) = rest
        .split_once(mark)
        .expect("page.html has every mark, in this order");
    page.push_str(before);
    page.push_str(text);
    after
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_page_is_filled_and_names_no_other_place() {
        let page = super::live_page();
        assert!(!page.contains("@data@") && page.contains("data-kind=\"live\""));
        for tag in ["src=\"http", "href=\"http", "url(http", "@import"] {
            assert!(!page.contains(tag), "{tag}");
        }
    }
}

//! What README.md and the pages of `docs/` say of `taut-zenoh` is so.
#![allow(missing_docs)]

#[allow(dead_code)]
#[path = "../../../tests/common/pages.rs"]
mod pages;

use pages::{Mention, Page, pages_of_users, takes};
use std::path::Path;
use std::process::Command;

/// The words after `taut-zenoh` that a page names, also by `taut zenoh`; nothing where it names
/// another command.
fn words(mention: &Mention) -> Option<&[String]> {
    let (program, words) = mention.command.split_first()?;
    if program == "taut-zenoh" {
        return Some(words);
    }
    let (first, words) = words.split_first()?;
    (first == "zenoh").then_some(words)
}

/// What `taut-zenoh` and these words take.
fn help(words: &[String]) -> String {
    let mut program = Command::new(env!("CARGO_BIN_EXE_taut-zenoh"));
    let output = program
        .args(words)
        .arg("--help")
        .output()
        .unwrap();
    assert!(output.status.success(), "no such command: {words:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn every_command_and_option_that_a_page_names_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let pages = pages_of_users(&root);
    let mut named = 0;
    for mention in pages.iter().flat_map(Page::mentions) {
        let Some(words) = words(&mention) else {
            continue;
        };
        let help = help(words);
        for option in &mention.options {
            assert!(takes(&help, option), "`{}`: no {option}", mention.text);
            named += 1;
        }
    }
    assert!(named > 8, "{named} options; have the pages another form?");
}

/// The pages tell of every option, and of no other way to call the program.
#[test]
fn every_option_is_on_the_page() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (command, page) in [
        ("serve", "reach"),
        ("attach", "reach"),
        ("doctor", "reach"),
        ("ros", "ros2"),
    ] {
        let page = Page::read(root.join(format!("docs/{page}.md")));
        let help = help(&[command.to_owned()]);
        let options = help
            .split_whitespace()
            .filter(|word| word.starts_with("--") && *word != "--help");
        for option in options {
            assert!(takes(&page.text, option), "`{command}` takes {option}");
        }
    }
}

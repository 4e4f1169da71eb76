//! What README.md and the pages of `docs/` say of `taut-bench` is so.

#[allow(dead_code)]
#[path = "../../tests/common/pages.rs"]
mod pages;

use std::path::Path;
use std::process::Command;

use pages::{Mention, Page, pages_of_users, takes};

/// The words after `taut-bench` that a page names, also by `taut bench`; nothing where it names
/// another command.
fn words(mention: &Mention) -> Option<&[String]> {
    let (program, words) = mention.command.split_first()?;
    let is_ours = program == "taut-bench"
        || words
            .first()
            .is_some_and(|word| word == "bench");
    is_ours.then_some(words)
}

/// What `taut-bench` and these words take.
fn help(words: &[String]) -> String {
    let mut program = Command::new(env!("CARGO_BIN_EXE_taut-bench"));
    let output = program
        .args(words)
        .arg("--help")
        .output()
        .unwrap();
    assert!(output.status.success(), "no such command: {words:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn every_option_that_a_page_names_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
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
    assert!(named > 5, "{named} options; have the pages another form?");
}

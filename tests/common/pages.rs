//! README.md and the pages of `docs/`, as tests look at them.

use std::fs;
use std::path::{Path, PathBuf};

/// A page in Markdown.
pub struct Page {
    pub file: PathBuf,
    pub text: String,
}

/// A fenced block of a page.
pub struct Block {
    pub language: String,
    pub text: String,
    /// What stands in a comment right before it.
    pub note: String,
}

/// A command or an option of the project's programs that a page names.
#[derive(Debug)]
pub struct Mention {
    /// `taut check` and the like; nothing where an option stands alone.
    pub command: Vec<String>,
    pub options: Vec<String>,
    pub text: String,
}

impl Page {
    pub fn read(file: PathBuf) -> Self {
        let text =
            fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        Self { file, text }
    }

    pub fn blocks(&self) -> Vec<Block> {
        let mut blocks = Vec::new();
        let mut note = String::new();
        let mut lines = self.text.lines();
        while let Some(line) = lines.next() {
            if let Some(language) = line.strip_prefix("```") {
                let text: Vec<&str> = lines
                    .by_ref()
                    .take_while(|line| *line != "```")
                    .collect();
                blocks.push(Block {
                    language: language.to_owned(),
                    text: text.join("\n"),
                    note: std::mem::take(&mut note),
                });
            } else if !line.is_empty() {
                note = comment(line).unwrap_or_default().to_owned();
            }
        }
        blocks
    }

    /// The text outside of fenced blocks.
    pub fn prose(&self) -> String {
        self.text.split("\n```").step_by(2).collect()
    }

    /// Where its links lead within the project, from the page's folder.
    pub fn links(&self) -> Vec<PathBuf> {
        let prose = self.prose();
        let targets = prose
            .split("](")
            .skip(1)
            .filter_map(|rest| rest.split([')', '#']).next());
        let folder = self.file.parent().unwrap();
        targets
            .filter(|target| !target.is_empty() && !target.contains("://"))
            .map(|target| folder.join(target))
            .collect()
    }

    /// Commands and options of `taut`, `taut-bench` and `taut-zenoh`, in blocks of commands and in the text.
    pub fn mentions(&self) -> Vec<Mention> {
        let prose = self.prose();
        let spans = prose
            .split('`')
            .skip(1)
            .step_by(2)
            .map(str::to_owned);
        let lines = self
            .blocks()
            .into_iter()
            .filter(|block| block.language == "sh")
            .flat_map(|block| commands(&block.text));
        spans
            .chain(lines)
            .filter_map(|text| Mention::of(&text))
            .collect()
    }
}

impl Mention {
    fn of(text: &str) -> Option<Self> {
        let mut words = text.split_whitespace();
        let first = words.next()?;
        let command = match first {
            "taut" | "taut-bench" | "taut-zenoh" => {
                let next = words.next().filter(|word| is_name(word));
                let is_scene = next == Some("scene");
                let more = words
                    .next()
                    .filter(|word| is_scene && is_name(word));
                let words = [Some(first), next, more].into_iter().flatten();
                words.map(str::to_owned).collect()
            }
            option if option.starts_with("--") => Vec::new(),
            _ => return None,
        };
        let options = text
            .split_whitespace()
            .filter_map(option)
            .collect();
        Some(Self {
            command,
            options,
            text: text.to_owned(),
        })
    }
}

/// README.md and what lies in `docs/`.
pub fn pages_of_users(root: &Path) -> Vec<Page> {
    let folder = fs::read_dir(root.join("docs")).expect("the folder docs");
    let files = folder.map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = files
        .filter(|file| {
            file.extension()
                .is_some_and(|extension| extension == "md")
        })
        .collect();
    files.sort();
    files.insert(0, root.join("README.md"));
    files.into_iter().map(Page::read).collect()
}

/// Whether a help text has an option.
pub fn takes(help: &str, option: &str) -> bool {
    help.split(|letter: char| !(letter.is_ascii_alphanumeric() || letter == '-'))
        .any(|word| word == option)
}

fn comment(line: &str) -> Option<&str> {
    line.strip_prefix("<!-- ")?.strip_suffix(" -->")
}

/// The commands of a block, one by one, without what is said of them.
fn commands(block: &str) -> Vec<String> {
    let lines = block
        .lines()
        .map(|line| line.split(" #").next().unwrap_or_default());
    let commands = lines.flat_map(|line| line.split([';', '&', '|']));
    commands
        .map(|command| command.trim().to_owned())
        .collect()
}

fn is_name(word: &str) -> bool {
    word.chars()
        .all(|letter| letter.is_ascii_lowercase() || letter == '-')
}

/// `--name` of `--name=value`.
fn option(word: &str) -> Option<String> {
    let name = word.strip_prefix("--")?;
    let end = name
        .find(|letter: char| !(letter.is_ascii_lowercase() || letter == '-'))
        .unwrap_or(name.len());
    Some(format!("--{}", &name[..end]))
}

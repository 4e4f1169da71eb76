//! Which files of a crate import which, read from their text: `use` and paths that begin with
//! `crate`, `super`, `self` or a module that the file declares. Modules that are only declared or
//! handed on (`pub use`) count as no import.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A module, by its path from the crate's root.
type Module = Vec<String>;

/// The modules of a crate, each a file.
pub struct Crate {
    modules: BTreeMap<Module, Source>,
}

struct Source {
    file: PathBuf,
    code: String,
    /// Names that the file hands on, and the module that each is from.
    handed_on: BTreeMap<String, Module>,
}

impl Source {
    fn read(file: PathBuf) -> Self {
        Self {
            code: code(&fs::read_to_string(&file).unwrap()),
            file,
            handed_on: BTreeMap::new(),
        }
    }

    /// Modules whose files lie elsewhere, `#[path = "…"] mod name;`.
    fn modules_elsewhere(&self) -> impl Iterator<Item = (String, PathBuf)> {
        let folder = self.file.parent().unwrap();
        self.code
            .split("#[path = \"")
            .skip(1)
            .filter_map(|rest| {
                let (path, rest) = rest.split_once('"')?;
                let (_, rest) = rest.split_once("mod ")?;
                let (name, _) = rest.split_once(';')?;
                Some((name.to_owned(), folder.join(path)))
            })
    }
}

impl Crate {
    /// Reads the files under the folder of a crate's `lib.rs` or `main.rs`.
    pub fn read(folder: &Path) -> Self {
        let mut modules = BTreeMap::new();
        for file in files(folder) {
            let Some(module) = module_of(file.strip_prefix(folder).unwrap()) else {
                continue;
            };
            let source = Source::read(file);
            for (name, elsewhere) in source.modules_elsewhere() {
                let path = [&module[..], &[name]].concat();
                modules.insert(path, Source::read(elsewhere));
            }
            modules.insert(module, source);
        }
        let mut whole = Self { modules };
        whole.learn_what_is_handed_on();
        whole
    }

    fn learn_what_is_handed_on(&mut self) {
        let found: Vec<_> = self
            .modules
            .iter()
            .map(|(module, source)| {
                let (handed_on, _) = uses(&source.code);
                let paths = handed_on.iter().filter_map(|path| {
                    let from = self.module_named(module, path)?;
                    Some((path.last()?.clone(), from))
                });
                (module.clone(), paths.collect())
            })
            .collect();
        for (module, handed_on) in found {
            self.modules.get_mut(&module).unwrap().handed_on = handed_on;
        }
    }

    /// The module that a path of `module`'s code leads into, as far as modules go.
    fn module_named(&self, module: &Module, path: &[String]) -> Option<Module> {
        let mut at = module.clone();
        let mut rest = path;
        match path.first()?.as_str() {
            "crate" => at.clear(),
            "self" => {}
            "super" => drop(at.pop()?),
            name => {
                at.push(name.to_owned());
                self.modules.contains_key(&at).then_some(())?;
            }
        }
        rest = &rest[1..];
        while let Some((name, after)) = rest.split_first() {
            match name.as_str() {
                "super" => drop(at.pop()?),
                name => {
                    let deeper = [&at[..], &[name.to_owned()]].concat();
                    if !self.modules.contains_key(&deeper) {
                        break;
                    }
                    at = deeper;
                }
            }
            rest = after;
        }
        // A name that is only handed on is imported from where it is.
        let handed_on = rest
            .first()
            .and_then(|name| self.modules[&at].handed_on.get(name));
        Some(handed_on.cloned().unwrap_or(at))
    }

    fn imports(&self, module: &Module) -> BTreeSet<Module> {
        let code = &self.modules[module].code;
        let (_, mut paths) = uses(code);
        paths.extend(paths_in_code(code));
        let named = paths
            .iter()
            .filter_map(|path| self.module_named(module, path));
        named.filter(|other| other != module).collect()
    }

    /// Files that import each other, each circle in order of its names.
    pub fn circles(&self) -> Vec<Vec<PathBuf>> {
        let imports: BTreeMap<&Module, BTreeSet<Module>> = self
            .modules
            .keys()
            .map(|module| (module, self.imports(module)))
            .collect();
        let reached: BTreeMap<&Module, BTreeSet<Module>> = imports
            .keys()
            .map(|module| (*module, reached(module, &imports)))
            .collect();
        let circle = |module: &Module| -> Vec<PathBuf> {
            let both = reached[module]
                .iter()
                .filter(|other| reached[other].contains(module));
            both.map(|other| self.modules[other].file.clone())
                .collect()
        };
        let circles: BTreeSet<_> = self.modules.keys().map(circle).collect();
        circles
            .into_iter()
            .filter(|files| files.len() > 1)
            .collect()
    }
}

fn reached(from: &Module, imports: &BTreeMap<&Module, BTreeSet<Module>>) -> BTreeSet<Module> {
    let mut reached = BTreeSet::new();
    let mut open = vec![from];
    while let Some(module) = open.pop() {
        for next in &imports[module] {
            if reached.insert(next.clone()) {
                open.push(next);
            }
        }
    }
    reached
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let mut found = Vec::new();
    for path in entries {
        if path.is_dir() {
            found.extend(files(&path));
        } else if path
            .extension()
            .is_some_and(|extension| extension == "rs")
        {
            found.push(path);
        }
    }
    found
}

/// The module of a file; `None` for files that only tests compile.
fn module_of(file: &Path) -> Option<Module> {
    let mut parts: Module = file
        .with_extension("")
        .iter()
        .map(|part| part.to_string_lossy().into_owned())
        .collect();
    let last = parts.last()?.clone();
    if super::is_test(&format!("{last}.rs")) {
        return None;
    }
    if ["mod", "lib", "main"].contains(&last.as_str()) {
        parts.pop();
    }
    Some(parts)
}

/// Code without comments and test modules.
fn code(text: &str) -> String {
    let text = text
        .split("#[cfg(test)]\nmod tests")
        .next()
        .unwrap();
    let lines = text
        .lines()
        .map(|line| line.split("//").next().unwrap());
    lines
        .map(|line| format!("{}\n", without_visibility(line)))
        .collect()
}

/// A line whose `pub(in …)` names no room: who may see something imports nothing.
fn without_visibility(line: &str) -> String {
    match line.split_once("pub(in ") {
        Some((before, after)) => {
            let after = after
                .split_once(')')
                .map_or("", |(_, after)| after);
            format!("{before}pub{after}")
        }
        None => line.to_owned(),
    }
}

/// Paths that `use` brings: those that are handed on, and those that are imported. Each statement
/// begins a line, as rustfmt writes it.
fn uses(code: &str) -> (Vec<Module>, Vec<Module>) {
    let mut handed_on = Vec::new();
    let mut imported = Vec::new();
    let mut rest = code;
    while let Some((line, after)) = rest.split_once('\n') {
        rest = after;
        let line = line.trim_start();
        let Some(at) = line.find("use ") else {
            continue;
        };
        let before = line[..at].trim_end();
        let is_public = before == "pub" || (before.starts_with("pub(") && before.ends_with(')'));
        if !(is_public || before.is_empty()) {
            continue;
        }
        let (first, _) = line[at + 4..]
            .split_once(';')
            .unwrap_or((&line[at + 4..], ""));
        let tree = match line.contains(';') {
            true => first.to_owned(),
            false => {
                let (more, after) = rest.split_once(';').unwrap_or((rest, ""));
                rest = after;
                format!("{first}{more}")
            }
        };
        let paths = expanded(&tree);
        match is_public {
            true => handed_on.extend(paths),
            false => imported.extend(paths),
        }
    }
    (handed_on, imported)
}

/// Every path of a `use` tree.
fn expanded(tree: &str) -> Vec<Module> {
    let tree = tree.trim();
    let Some(open) = tree.find('{') else {
        let name = tree.split(" as ").next().unwrap();
        return vec![
            name.split("::")
                .map(|part| part.trim().to_owned())
                .collect(),
        ];
    };
    let before: Module = tree[..open]
        .split("::")
        .map(|part| part.trim().to_owned())
        .filter(|part| !part.is_empty())
        .collect();
    let inner = &tree[open + 1..tree.rfind('}').unwrap_or(tree.len())];
    branches(inner)
        .into_iter()
        .flat_map(expanded)
        .map(|path| [&before[..], &path[..]].concat())
        .map(|path| {
            path.into_iter()
                .filter(|part| part != "self" || before.is_empty())
                .collect()
        })
        .collect()
}

/// The parts of a list that commas part, those in braces whole.
fn branches(list: &str) -> Vec<&str> {
    let mut depth = 0;
    let mut parts = Vec::new();
    let mut start = 0;
    for (at, letter) in list.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&list[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&list[start..]);
    parts.retain(|part| !part.trim().is_empty());
    parts
}

/// Paths in expressions and types, which need no `use`.
fn paths_in_code(code: &str) -> Vec<Module> {
    let is_word = |letter: char| letter.is_alphanumeric() || letter == '_';
    let mut paths = Vec::new();
    for line in code
        .lines()
        .filter(|line| !line.trim_start().contains("use "))
    {
        for part in line.split(|letter: char| !(is_word(letter) || letter == ':')) {
            let path: Module = part.split("::").map(str::to_owned).collect();
            if path.len() > 1
                && path
                    .iter()
                    .all(|name| name.chars().all(is_word))
            {
                paths.push(path);
            }
        }
    }
    paths
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A crate of two files that import each other, in each way that there is.
    #[test]
    fn circles_are_found_and_what_is_handed_on_makes_none() {
        let circles = |files: &[(&str, &str)]| {
            let folder = tempfile::tempdir().unwrap();
            for (name, text) in files {
                let file = folder.path().join(name);
                fs::create_dir_all(file.parent().unwrap()).unwrap();
                fs::write(file, text).unwrap();
            }
            Crate::read(folder.path())
                .circles()
                .iter()
                .map(Vec::len)
                .collect::<Vec<_>>()
        };
        let root = ("lib.rs", "mod a;\nmod b;\npub use a::A;\n");
        for there in [
            "use super::b::B;\n",
            "use crate::{b::{self, B}};\n",
            "type X = super::b::B;\n",
        ] {
            let back = ("b.rs", "use crate::A;\n");
            assert_eq!(circles(&[root, ("a.rs", there), back]), [2], "{there}");
            assert_eq!(
                circles(&[root, ("a.rs", there), ("b.rs", "")]),
                [0; 0],
                "{there}"
            );
        }
        let parent = ("a/mod.rs", "mod c;\npub use c::C;\npub struct A;\n");
        let child = ("a/c.rs", "use super::A;\n");
        assert_eq!(circles(&[("lib.rs", "mod a;\n"), parent, child]), [0; 0]);
        let parent = ("a/mod.rs", "mod c;\npub struct A(c::C);\n");
        assert_eq!(circles(&[("lib.rs", "mod a;\n"), parent, child]), [2]);
    }
}

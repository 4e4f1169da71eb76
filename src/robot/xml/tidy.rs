//! What the XML readers of robots let pass, written as XML has it: prefixes that nobody declares, a
//! blank before the declaration, `--` in comments, a bare `&`. Lines keep their numbers.

use std::collections::BTreeSet;

/// The text as XML, and what is odd about it, a line each.
pub(super) fn tidy(text: &str) -> (String, Vec<String>) {
    let mut scan = Scan {
        rest: text.strip_prefix('\u{feff}').unwrap_or(text),
        ..Scan::default()
    };
    scan.out.reserve(text.len());
    while !scan.rest.is_empty() {
        scan.step();
    }
    scan.declare()
}

#[derive(Default)]
struct Scan<'a> {
    rest: &'a str,
    out: String,
    /// Where the root's name ends in `out`.
    root: Option<usize>,
    /// Prefixes that the root declares, and those that are used anywhere.
    declared: BTreeSet<&'a str>,
    used: BTreeSet<&'a str>,
    /// Whether a document type has declarations: what `&name;` means is then said there.
    has_entities: bool,
}

impl<'a> Scan<'a> {
    fn step(&mut self) {
        let rest = self.rest;
        if rest.starts_with("<!--") {
            let comment = self.take(after(rest, "-->"));
            self.blank(comment);
        } else if rest.starts_with("<![CDATA[") {
            let data = self.take(after(rest, "]]>"));
            self.out.push_str(data);
        } else if rest.starts_with("<?") {
            // The text is decoded: what its declaration says of its encoding has served.
            let instruction = self.take(after(rest, "?>"));
            self.blank(instruction);
        } else if rest.starts_with("<!DOCTYPE") {
            self.document_type();
        } else if rest.starts_with('<') {
            self.tag();
        } else {
            let text = self.take(rest.find('<').unwrap_or(rest.len()));
            self.escaped(text);
        }
    }

    fn take(&mut self, length: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(length);
        self.rest = rest;
        taken
    }

    /// Blanks of as many lines and columns.
    fn blank(&mut self, text: &str) {
        self.out.extend(
            text.chars()
                .map(|c| if c == '\n' { '\n' } else { ' ' }),
        );
    }

    /// A document type that declares something stays, any other says nothing that is read here.
    fn document_type(&mut self) {
        let close = self
            .rest
            .find('>')
            .map_or(self.rest.len(), |at| at + 1);
        self.has_entities = self.rest[..close].contains('[');
        if self.has_entities {
            let end = self
                .rest
                .find("]>")
                .map_or(self.rest.len(), |at| at + 2);
            let kept = self.take(end);
            self.out.push_str(kept);
        } else {
            let dropped = self.take(close);
            self.blank(dropped);
        }
    }

    /// A tag up to its `>`, its values escaped and its prefixes noted.
    fn tag(&mut self) {
        let is_root = self.root.is_none() && !self.rest.starts_with("</");
        let name = self.take(
            self.rest[1..]
                .find([' ', '\t', '\r', '\n', '/', '>'])
                .map_or(self.rest.len(), |at| at + 1),
        );
        self.out.push_str(name);
        if is_root {
            self.root = Some(self.out.len());
        }
        self.note(&name[1..], is_root);
        while !self.rest.is_empty() {
            let outside = self.take(
                self.rest
                    .find(['"', '\'', '>'])
                    .unwrap_or(self.rest.len()),
            );
            self.out.push_str(outside);
            outside
                .split(|c: char| c.is_whitespace() || c == '=' || c == '/')
                .for_each(|word| self.note(word, is_root));
            match self.rest.chars().next() {
                Some(quote @ ('"' | '\'')) => {
                    let value = self.take(
                        self.rest[1..]
                            .find(quote)
                            .map_or(self.rest.len(), |at| at + 2),
                    );
                    self.escaped(value);
                }
                Some(_) => {
                    self.take(1);
                    self.out.push('>');
                    return;
                }
                None => return,
            }
        }
    }

    fn note(&mut self, word: &'a str, is_root: bool) {
        match word.split_once(':') {
            Some(("xmlns", prefix)) if is_root => {
                self.declared.insert(prefix);
            }
            None | Some(("" | "xml" | "xmlns", _)) => {}
            Some((prefix, _)) => {
                self.used.insert(prefix);
            }
        }
    }

    /// A text or a quoted value, in which `&` and `<` that begin nothing stand for themselves.
    fn escaped(&mut self, text: &str) {
        for (at, c) in text.char_indices() {
            match c {
                '&' if !self.has_entities && !is_reference(&text[at + 1..]) => {
                    self.out.push_str("&amp;")
                }
                '<' => self.out.push_str("&lt;"),
                c => self.out.push(c),
            }
        }
    }

    /// Declares the prefixes that the root does not.
    fn declare(mut self) -> (String, Vec<String>) {
        let missing: Vec<&str> = self
            .used
            .difference(&self.declared)
            .copied()
            .collect();
        let declaration = |prefix: &&str| {
            let name = if *prefix == "xacro" {
                "http://www.ros.org/wiki/xacro"
            } else {
                prefix
            };
            format!(" xmlns:{prefix}=\"{name}\"")
        };
        if let Some(root) = self.root {
            self.out.insert_str(
                root,
                &missing
                    .iter()
                    .map(declaration)
                    .collect::<String>(),
            );
        }
        let warning = |prefix: &str| {
            format!("the XML prefix {prefix:?} is not declared; what has it is not read")
        };
        (self.out, missing.into_iter().map(warning).collect())
    }
}

/// Length of a text up to the end of `mark`, or of all of it.
fn after(text: &str, mark: &str) -> usize {
    text.find(mark)
        .map_or(text.len(), |at| at + mark.len())
}

/// Whether what follows a `&` makes it a reference that every XML reader knows.
fn is_reference(text: &str) -> bool {
    let Some((name, _)) = text.split_once(';') else {
        return false;
    };
    let is_number = |digits: &str, is_digit: fn(char) -> bool| {
        !digits.is_empty() && digits.chars().all(is_digit)
    };
    match name.strip_prefix('#') {
        Some(number) => match number.strip_prefix('x') {
            Some(digits) => is_number(digits, |c| c.is_ascii_hexdigit()),
            None => is_number(number, |c| c.is_ascii_digit()),
        },
        None => ["amp", "lt", "gt", "quot", "apos"].contains(&name),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_xml_readers_of_robots_let_pass_becomes_xml_with_the_same_lines() {
        let odd = "\u{feff}\n <?xml version='1.0' encoding='latin1'?>\n<!DOCTYPE robot>\n<!-- a -- b\n -->\n\
            <robot name='a & b' xmlns:known='k'>\n<p:e/><e q:a='1 < 2 &amp; &#65;'/><known:e/><![CDATA[<r:e>]]></robot>";
        let (text, warnings) = tidy(odd);
        assert!(roxmltree::Document::parse(odd).is_err());
        let document = roxmltree::Document::parse(&text).expect(&text);
        assert_eq!(document.root_element().attribute("name"), Some("a & b"));
        let element = document
            .descendants()
            .find(|node| node.tag_name().name() == "e" && node.tag_name().namespace().is_none());
        let element = element.unwrap();
        assert_eq!(element.attribute(("q", "a")), Some("1 < 2 & A"));
        assert_eq!(document.text_pos_at(element.range().start).row, 7);
        assert!(
            warnings.len() == 2 && warnings[0].contains("\"p\"") && warnings[1].contains("\"q\""),
            "{warnings:?}"
        );
    }

    #[test]
    fn a_good_text_stays_as_it_is() {
        let good = "<robot xmlns:a=\"b\">\n  <a:link name=\"x &gt; y\"/> text &#x41; <b c='\"'/></robot>\n";
        assert_eq!(tidy(good), (good.to_owned(), Vec::new()));
        for cut in (0..good.len()).filter(|at| good.is_char_boundary(*at)) {
            tidy(&good[..cut]);
        }
    }
}

//! The language of comments, and how many give a reason, of each package and language.

use std::collections::BTreeMap;
use std::path::Path;

use super::{collect, is_test, root, split};

/// Everyday words in place of standard terms.
const DIALECT: [&str; 12] = [
    "nobody",
    "somebody",
    "whoever",
    "everybody",
    "anew",
    "goes on",
    "stands",
    "lies",
    "what is",
    "what it",
    "who",
    "begins",
];
/// Most of them in 10,000 words of comment, by the ending of the files: other projects have 4 to 7.
const LANGUAGES: [(&str, f64); 6] = [
    ("rs", 12.0),
    ("toml", 12.0),
    ("py", 12.0),
    ("css", 12.0),
    ("mjs", 12.0),
    // Parts of the page are to be rewritten.
    ("ts", 40.0),
];
/// Least number of comments that are not documentation in 100 lines of Rust: they give reasons.
const REASONS: f64 = 2.0;
/// Packages with fewer lines of code are too small for a ratio.
const LINES: usize = 500;

/// Words, and lines of code.
#[derive(Default)]
struct Counts {
    words: usize,
    found: Vec<String>,
    code: usize,
    reasons: usize,
}

/// A package by its folder; all files of another language are one.
pub(super) fn package(ending: &str, path: &str) -> String {
    let parts: Vec<&str> = path.split('/').collect();
    match (ending, parts.as_slice()) {
        ("rs", ["crates", group, name, ..]) => format!("crates/{group}/{name}"),
        ("rs", [first, ..]) => (*first).to_owned(),
        _ => format!("*.{ending}"),
    }
}

/// The comments of a text, line by line.
fn comments(ending: &str, text: &str) -> String {
    match ending {
        "rs" => split(text).1,
        "toml" => after_sharp(text),
        "py" => format!(
            "{}\n{}",
            between(text, "\"\"\"", "\"\"\""),
            after_sharp(text)
        ),
        "css" => between(text, "/*", "*/"),
        _ => format!("{}\n{}", between(text, "/*", "*/"), split(text).1),
    }
}

fn after_sharp(text: &str) -> String {
    let comment = |line: &str| line.split_once('#').map_or("", |(_, it)| it).to_owned();
    text.lines().map(|line| comment(line) + "\n").collect()
}

fn between(text: &str, open: &str, close: &str) -> String {
    let inner = |rest: &str| rest.split(close).next().unwrap_or_default().to_owned();
    let every = if open == close { 2 } else { 1 };
    let all = text.split(open).skip(1).step_by(every);
    all.map(|rest| inner(rest) + "\n").collect()
}

impl Counts {
    fn add(&mut self, ending: &str, path: &str, text: &str) {
        for line in comments(ending, text).lines() {
            let all: Vec<String> = line
                .split(|c: char| !c.is_alphabetic() && c != '\'')
                .filter(|word| !word.is_empty())
                .map(str::to_lowercase)
                .collect();
            self.words += all.len();
            let spaced = format!(" {} ", all.join(" "));
            for word in DIALECT {
                for _ in spaced.matches(&format!(" {word} ")) {
                    self.found.push(format!("{path}: {word}: {}", line.trim()));
                }
            }
        }
        if ending == "rs" && !is_test(path) {
            let (code, reasons) = code_lines(text);
            self.code += code;
            self.reasons += reasons;
        }
    }
}

/// Lines of code of a Rust file without its inline tests, and its comments that are not
/// documentation.
pub(super) fn code_lines(text: &str) -> (usize, usize) {
    let (mut code, mut reasons) = (0, 0);
    let source = text.split("#[cfg(test)]\nmod tests {").next();
    for line in source.unwrap_or_default().lines().map(str::trim) {
        let is_doc = line.starts_with("///") || line.starts_with("//!");
        if line.is_empty() || is_doc {
            continue;
        }
        let is_comment = line.starts_with("//");
        code += usize::from(!is_comment);
        reasons += usize::from(is_comment || line.contains(" // "));
    }
    (code, reasons)
}

/// Counts of each package and language.
fn counts() -> BTreeMap<(&'static str, String), Counts> {
    let mut all: BTreeMap<(&str, String), Counts> = BTreeMap::new();
    for (ending, _) in LANGUAGES {
        let mut files = BTreeMap::new();
        collect(Path::new(&root()), ending, &mut files);
        for (path, text) in &files {
            // This list of words, and generated or fetched files, are no comments of ours.
            if path.ends_with("it/source/comments.rs") {
                continue;
            }
            let key = (ending, package(ending, path));
            all.entry(key).or_default().add(ending, path, text);
        }
    }
    all
}

#[test]
fn comments_use_standard_terms() {
    let (limits, mut wrong) = (BTreeMap::from(LANGUAGES), Vec::new());
    for ((ending, package), counts) in counts() {
        let is_small = ending == "rs" && counts.code < LINES;
        let each = counts.found.len() as f64 / counts.words.max(1) as f64 * 10_000.0;
        let limit = limits[ending];
        if !is_small && each > limit {
            let found = counts.found.join("\n");
            wrong.push(format!(
                "{package}: {each:.1}, allowed are {limit}:\n{found}"
            ));
        }
    }
    assert!(
        wrong.is_empty(),
        "everyday words in 10,000 words of comment; use standard terms:\n{}",
        wrong.join("\n")
    );
}

#[test]
fn comments_give_reasons() {
    let mut few = Vec::new();
    for ((_, package), counts) in counts().iter().filter(|(_, of)| of.code >= LINES) {
        let each = counts.reasons as f64 / counts.code as f64 * 100.0;
        if each < REASONS {
            few.push(format!("{package}: {each:.1}"));
        }
    }
    assert!(
        few.is_empty(),
        "comments in 100 lines of code, at least {REASONS} are asked for; say why:\n{}",
        few.join("\n")
    );
}

//! Size, language and order of the source files, as CONTRIBUTING promises them.

mod budgets;
mod circles;
mod comments;
mod dependencies;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Lines of a file that is not a test.
const FILE_LINES: usize = 400;
/// Lines of a function; `clippy.toml` has the same number.
const FUNCTION_LINES: usize = 60;
/// Options of the command line, each counted where it is defined: those that several verbs flatten
/// count once. A later change adds an option only where nothing else does its work.
const OPTIONS: usize = 118;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Files below `dir` with this ending, by their path from the root.
fn collect(dir: &Path, ending: &str, files: &mut BTreeMap<String, String>) {
    for entry in std::fs::read_dir(dir).expect("a directory").flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        let name = name.to_string_lossy();
        if path.is_dir() {
            let is_ours = !name.starts_with('.') && name != "target" && name != "node_modules";
            if is_ours {
                collect(&path, ending, files);
            }
        } else if path.extension().is_some_and(|end| end == ending) {
            let from_root = path.strip_prefix(root()).expect("a path below the root");
            let text = std::fs::read_to_string(&path).expect("a text");
            files.insert(from_root.display().to_string(), text);
        }
    }
}

fn files() -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    collect(&root(), "rs", &mut files);
    assert!(files.len() > 500, "{}", files.len());
    files
}

/// Tests, and examples, may be longer.
fn is_test(path: &str) -> bool {
    let mut parts = path.split('/').rev();
    let file = parts.next().unwrap_or_default();
    let is_test = |name: &str| name == "tests" || name == "examples";
    is_test(file.trim_end_matches(".rs")) || file.ends_with("_tests.rs") || parts.any(is_test)
}

/// The text with comments blanked, or with everything else blanked; lines stay where they are.
fn split(text: &str) -> (String, String) {
    let (mut code, mut comments) = (String::new(), String::new());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let end = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else {
            literal(rest).unwrap_or(first.len_utf8())
        };
        let (token, after) = rest.split_at(end);
        let blank = |text: &str| text.chars().filter(|c| *c == '\n').collect::<String>();
        if rest.starts_with("//") {
            comments.push_str(token);
        } else if token.len() > first.len_utf8() {
            code.push('"');
            code.push_str(&blank(token));
            comments.push_str(&blank(token));
        } else {
            code.push_str(token);
            comments.push_str(if token == "\n" { "\n" } else { " " });
        }
        rest = after;
    }
    (code, comments)
}

/// Length of the string or character at the beginning of `text`.
fn literal(text: &str) -> Option<usize> {
    let raw = text.strip_prefix('b').unwrap_or(text);
    let hashes = raw
        .strip_prefix('r')
        .map(|t| t.len() - t.trim_start_matches('#').len());
    if let Some(hashes) = hashes
        && raw[1 + hashes..].starts_with('"')
    {
        let begin = text.len() - raw.len() + 2 + hashes;
        let end = format!("\"{}", "#".repeat(hashes));
        return Some(begin + text[begin..].find(&end)? + end.len());
    }
    let quote = text.chars().next().filter(|c| *c == '"' || *c == '\'')?;
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            // A lifetime has no second quote within a character or an escape of it.
            _ if quote == '\'' && c != '\'' && at > 1 && !text.starts_with("'\\") => return None,
            _ if c == quote => return Some(at + 1),
            _ => {}
        }
    }
    None
}

/// First line and length of each function in `code`.
fn functions(code: &str) -> Vec<(usize, usize)> {
    let (mut open, mut found, mut depth, mut begun) = (Vec::new(), Vec::new(), 0, None);
    for (number, line) in code.lines().enumerate() {
        let words = line.split(|c: char| !c.is_alphanumeric() && c != '_');
        if words.clone().any(|word| word == "fn") && line.contains("fn ") && begun.is_none() {
            begun = Some(number);
        }
        for c in line.chars() {
            match c {
                '{' => {
                    open.push(begun.take());
                    depth += 1;
                }
                '}' => {
                    depth -= 1;
                    if let Some(Some(first)) = open.pop() {
                        found.push((first + 1, number - first + 1));
                    }
                }
                ';' if begun.is_some() => begun = None,
                _ => {}
            }
        }
    }
    assert_eq!(depth, 0);
    found
}

#[test]
fn files_and_functions_are_short() {
    let mut long = Vec::new();
    for (path, text) in files().iter().filter(|(path, _)| !is_test(path)) {
        let lines = text.lines().count();
        if lines > FILE_LINES {
            long.push(format!("{path}: {lines} lines"));
        }
        let (code, _) = split(text);
        for (line, lines) in functions(&code) {
            if lines > FUNCTION_LINES && !code[..].contains("#[cfg(test)]\nmod tests {") {
                long.push(format!("{path}:{line}: a function of {lines} lines"));
            }
        }
    }
    assert!(
        long.is_empty(),
        "split by responsibility what is longer than {FILE_LINES} lines, or functions than \
         {FUNCTION_LINES}:\n{}",
        long.join("\n")
    );
}

/// Arguments of the attributes `#[arg(..)]`, which rustfmt may wrap.
fn arguments(text: &str) -> Vec<&str> {
    text.split("#[arg(")
        .skip(1)
        .filter_map(|rest| {
            let mut depth = 1;
            let end = rest.find(|c: char| {
                depth += i32::from(c == '(') - i32::from(c == ')');
                depth == 0
            });
            rest.get(..end?)
        })
        .collect()
}

/// Whether the arguments of an attribute make an option with a long name.
fn is_option(arguments: &str) -> bool {
    let (code, _) = split(arguments);
    code.split(|c: char| !c.is_alphanumeric() && c != '_')
        .any(|word| word == "long")
}

#[test]
fn the_command_line_gains_no_options() {
    let files = files();
    let ours = files
        .iter()
        .filter(|(path, _)| path.starts_with("launch/src/args/"));
    let all = ours.flat_map(|(_, text)| arguments(text));
    let found = all.filter(|arguments| is_option(arguments)).count();
    assert_eq!(
        found, OPTIONS,
        "an option that is removed lowers OPTIONS; a new one has its reason in changes/"
    );
    let text =
        "#[arg(\n    long,\n    value_parser = p(1, f(2))\n)]\na: u8,\n#[arg(help = \"long\")]";
    let wrapped: Vec<bool> = arguments(text).into_iter().map(is_option).collect();
    assert_eq!(wrapped, [true, false]);
}

//! Size, language and order of the source files, as CONTRIBUTING promises them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Lines of a file that is not a test.
const FILE_LINES: usize = 400;
/// Lines of a function; `clippy.toml` has the same number.
const FUNCTION_LINES: usize = 60;
/// Words of DIALECT in 10,000 words of comments: other projects have 4 to 7.
const DIALECT_LIMIT: f64 = 12.0;
/// Everyday words in place of standard terms.
const DIALECT: [&str; 11] = [
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
    "begins",
];
/// Options of the command line, each counted where it is defined: those that several verbs flatten
/// count once. A later change adds an option only where nothing else does its work.
const OPTIONS: usize = 123;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Rust files below `dir`, by their path from the root.
fn collect(dir: &Path, files: &mut BTreeMap<String, String>) {
    for entry in std::fs::read_dir(dir).expect("a directory").flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        let name = name.to_string_lossy();
        if path.is_dir() {
            let is_ours = !name.starts_with('.') && name != "target" && name != "node_modules";
            if is_ours {
                collect(&path, files);
            }
        } else if path.extension().is_some_and(|end| end == "rs") {
            let from_root = path.strip_prefix(root()).expect("a path below the root");
            let text = std::fs::read_to_string(&path).expect("a text");
            files.insert(from_root.display().to_string(), text);
        }
    }
}

fn files() -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    collect(&root(), &mut files);
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

#[test]
fn comments_use_standard_terms() {
    let (mut words, mut found) = (0, Vec::new());
    for (path, text) in &files() {
        if path.ends_with("it/source.rs") {
            continue;
        }
        for (number, line) in split(text).1.lines().enumerate() {
            let all: Vec<String> = line
                .split(|c: char| !c.is_alphabetic() && c != '\'')
                .filter(|word| !word.is_empty())
                .map(str::to_lowercase)
                .collect();
            words += all.len();
            let line = format!(" {} ", all.join(" "));
            for word in DIALECT {
                for _ in line.matches(&format!(" {word} ")) {
                    found.push(format!("{path}:{}: {word}", number + 1));
                }
            }
        }
    }
    let each = found.len() as f64 / words as f64 * 10_000.0;
    assert!(
        each <= DIALECT_LIMIT,
        "{each:.1} words of dialect in 10,000, allowed are {DIALECT_LIMIT}; use standard terms:\n{}",
        found.join("\n")
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
        .filter(|(path, _)| path.starts_with("launch/src/cli"));
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

/// Modules of each package by their path, and the modules that each `use`s by `crate::`.
fn imports(files: &BTreeMap<String, String>) -> BTreeMap<String, Graph> {
    let mut packages: BTreeMap<String, BTreeMap<String, &String>> = BTreeMap::new();
    for (path, text) in files {
        let Some((package, module)) = path.split_once("/src/").filter(|_| !is_test(path)) else {
            continue;
        };
        let module = module
            .trim_end_matches(".rs")
            .trim_end_matches("/mod")
            .replace('/', "::");
        packages
            .entry(package.to_owned())
            .or_default()
            .insert(module, text);
    }
    let graph = |modules: &BTreeMap<String, &String>| -> Graph {
        let of = |(module, text): (&String, &&String)| {
            let code = split(text).0;
            let code = code
                .split("#[cfg(test)]\nmod tests {")
                .next()
                .unwrap_or_default();
            let used = code
                .split("use crate::")
                .skip(1)
                .flat_map(|rest| paths(rest.split(';').next().unwrap_or_default()));
            let to = used.filter_map(|path| nearest(modules, &path));
            (module.clone(), to.filter(|to| to != module).collect())
        };
        modules.iter().map(of).collect()
    };
    packages
        .iter()
        .map(|(name, modules)| (name.clone(), graph(modules)))
        .collect()
}

type Graph = BTreeMap<String, BTreeSet<String>>;

/// `a::{b, c::{d}}` as `a::b` and `a::c::d`.
fn paths(text: &str) -> Vec<String> {
    let text: String = text.split_whitespace().collect();
    let Some((prefix, inner)) = text.split_once('{') else {
        return vec![text];
    };
    let inner = inner.strip_suffix('}').unwrap_or(inner);
    let (mut depth, mut items, mut item) = (0_i32, Vec::new(), String::new());
    for c in inner.chars().chain([',']) {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if c == ',' && depth == 0 {
            items.push(std::mem::take(&mut item));
        } else {
            item.push(c);
        }
    }
    items
        .iter()
        .flat_map(|item| paths(item))
        .map(|path| format!("{prefix}{path}"))
        .collect()
}

/// The module that a path is in: its longest beginning that is one.
fn nearest(modules: &BTreeMap<String, &String>, path: &str) -> Option<String> {
    let mut path = path;
    loop {
        if modules.contains_key(path) {
            return Some(path.to_owned());
        }
        path = path.rsplit_once("::")?.0;
    }
}

/// Whether a module is reached from itself.
fn circles(graph: &Graph) -> Vec<String> {
    let is_reached = |from: &String| {
        let (mut seen, mut left) = (BTreeSet::new(), vec![from]);
        while let Some(module) = left.pop() {
            for to in graph.get(module).into_iter().flatten() {
                if to == from {
                    return true;
                }
                if seen.insert(to) {
                    left.push(to);
                }
            }
        }
        false
    };
    graph
        .keys()
        .filter(|module| is_reached(module))
        .cloned()
        .collect()
}

#[test]
fn no_two_files_import_each_other() {
    for (package, graph) in imports(&files()) {
        let circles = circles(&graph);
        assert!(
            circles.is_empty(),
            "{package}: {circles:?} import each other"
        );
    }
}

#[test]
fn circles_are_found_through_nested_imports() {
    let file = |path: &str, text: &str| (format!("p/src/{path}.rs"), text.to_owned());
    let all = BTreeMap::from([
        file("a", "use crate::{b::{C, d::E}, x};\n"),
        file("b/mod", "// use crate::a;\n"),
        file("b/d", "fn f() {}\nuse crate::x::{self, Y};"),
        file("x", "use crate::a::Z; // a lifetime 'a and a char '{'"),
    ]);
    let graph = imports(&all).remove("p").expect("the package");
    assert_eq!(circles(&graph), ["a", "b::d", "x"]);
}

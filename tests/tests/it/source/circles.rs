//! No two files of a package import each other.

use std::collections::{BTreeMap, BTreeSet};

use super::{files, is_test, split};

type Graph = BTreeMap<String, BTreeSet<String>>;

/// Modules of each package by their path, and the modules that each names by `crate::`, `super::`,
/// `self::` or the name of a child.
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
            let code = code.split("#[cfg(test)]\nmod tests {").next();
            let named = named(code.unwrap_or_default()).into_iter();
            let to = named.filter_map(|path| resolved(modules, module, &path));
            (module.clone(), to.filter(|to| to != module).collect())
        };
        modules.iter().map(of).collect()
    };
    packages
        .iter()
        .map(|(name, modules)| (name.clone(), graph(modules)))
        .collect()
}

/// The paths that `code` names: those of its imports, and those that begin with `crate` or `super`
/// anywhere.
fn named(code: &str) -> Vec<String> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut all = Vec::new();
    for rest in code.split("use ").skip(1) {
        all.extend(paths(rest.split(';').next().unwrap_or_default()));
    }
    for first in ["crate::", "super::"] {
        for (at, _) in code.match_indices(first) {
            let before = code[..at].chars().next_back();
            if before.is_some_and(|c| is_name(c) || c == ':') {
                continue;
            }
            let end = code[at..].find(|c| !is_name(c) && c != ':');
            let path = &code[at..end.map_or(code.len(), |end| at + end)];
            all.push(path.trim_end_matches(':').to_owned());
        }
    }
    all
}

/// The module that a path of `module` is in: its longest beginning that is one. The root of a
/// package counts as none.
fn resolved(modules: &BTreeMap<String, &String>, module: &str, path: &str) -> Option<String> {
    let mut base: Vec<&str> = module.split("::").collect();
    if modules.get(module).is_some() && (module == "lib" || module == "main") {
        base.clear();
    }
    let mut names: Vec<&str> = path.split("::").collect();
    match names.first()? {
        &"crate" => base.clear(),
        &"self" => {}
        &"super" => {
            while names.first() == Some(&"super") {
                base.pop();
                names.remove(0);
            }
            names.insert(0, "self");
        }
        child => {
            let child = [base.as_slice(), &[*child]].concat().join("::");
            modules.get(&child)?;
            names.insert(0, "self");
        }
    }
    let mut full = [base.as_slice(), &names[1..]].concat();
    while !full.is_empty() {
        let path = full.join("::");
        if modules.contains_key(&path) {
            return Some(path);
        }
        full.pop();
    }
    None
}

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

/// The modules from which each is reached, and that it reaches.
fn with_each(graph: &Graph, from: &str) -> BTreeSet<String> {
    let reached = |from: &str| {
        let (mut seen, mut left) = (BTreeSet::new(), vec![from.to_owned()]);
        while let Some(module) = left.pop() {
            for to in graph.get(&module).into_iter().flatten() {
                if seen.insert(to.clone()) {
                    left.push(to.clone());
                }
            }
        }
        seen
    };
    let all = reached(from).into_iter();
    all.filter(|to| reached(to).contains(from)).collect()
}

/// Modules that are reached from themselves. A parent and its own children may name each other:
/// they are one thing in several files.
fn circles(graph: &Graph) -> Vec<String> {
    let is_parent = |a: &str, b: &str| b.rsplit_once("::").is_some_and(|(parent, _)| parent == a);
    let is_circle = |module: &&String| {
        let with = with_each(graph, module);
        let is_alone = |a: &String| !with.iter().any(|b| is_parent(a, b) || is_parent(b, a));
        with.len() > 1 && with.iter().any(is_alone)
    };
    graph.keys().filter(is_circle).cloned().collect()
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
        file("c/mod", "use d::F;\nfn f(e: super::a::E) {}"),
        file("c/d", "use super::e::G;"),
        file("c/e", "fn f(d: &super::d::F) {}"),
        file("g/mod", "use h::I;"),
        file("g/h", "use super::J; use crate::{a, b};"),
    ]);
    let graph = imports(&all).remove("p").expect("the package");
    assert_eq!(circles(&graph), ["a", "b::d", "c::d", "c::e", "x"]);
}

//! Dependencies cost build time: each is used by the package that names it.

use std::collections::BTreeMap;

use super::{collect, files, root};

/// The programs of `fuzz` include files of `tests`; `templates` is not a package of its own.
const OTHERS: [&str; 2] = ["fuzz/", "launch/src/new/templates/"];

#[test]
fn each_dependency_is_used() {
    let sources = files();
    let mut manifests = BTreeMap::new();
    collect(&root(), "toml", &mut manifests);
    manifests.retain(|path, _| {
        path.ends_with("/Cargo.toml") && OTHERS.iter().all(|other| !path.starts_with(other))
    });
    assert!(manifests.len() > 30, "{}", manifests.len());
    let mut unused = Vec::new();
    for (path, text) in &manifests {
        let folder = format!("{}/", path.trim_end_matches("/Cargo.toml"));
        let own = sources
            .iter()
            .filter(|(source, _)| source.starts_with(&folder));
        let own: Vec<&String> = own.map(|(_, text)| text).collect();
        for name in names(text) {
            let word = name.replace('-', "_");
            if !own.iter().any(|text| has_word(text, &word)) {
                unused.push(format!("{path}: {name}"));
            }
        }
    }
    assert!(unused.is_empty(), "{unused:#?}");
}

/// Names of all dependencies, as the code has them.
fn names(manifest: &str) -> Vec<String> {
    let table: toml::Table = toml::from_str(manifest).expect("a manifest");
    let kinds = ["dependencies", "dev-dependencies", "build-dependencies"];
    let of = |kind: &str| table.get(kind).and_then(toml::Value::as_table).cloned();
    kinds
        .into_iter()
        .filter_map(of)
        .flat_map(|all| all.into_iter().map(|(name, _)| name))
        .collect()
}

fn has_word(text: &str, word: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word).any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let after = text[at + word.len()..].chars().next();
        !before.is_some_and(is_part) && !after.is_some_and(is_part)
    })
}

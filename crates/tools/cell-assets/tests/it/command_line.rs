//! The messages for a user without meshes, or with a wrong file.

use std::path::Path;
use std::process::{Command, Output};

fn run(cache: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cell-assets"))
        .args(arguments)
        .arg("--cache")
        .arg(cache)
        .output()
        .expect("the program runs")
}

fn refused(output: &Output, words: &[&str]) {
    assert_eq!(output.status.code(), Some(3));
    let said = String::from_utf8_lossy(&output.stderr);
    for word in words {
        assert!(said.contains(word), "no `{word}` in: {said}");
    }
}

#[test]
fn an_empty_cache_says_how_to_fill_it() {
    let cache = tempfile::tempdir().expect("a folder");
    for command in ["list", "path"] {
        refused(&run(cache.path(), &[command]), &["robocell assets fetch"]);
    }
}

#[test]
fn a_file_that_is_not_the_pinned_one_leaves_no_mesh() {
    let cache = tempfile::tempdir().expect("a folder");
    let wrong = cache.path().join("wrong.whl");
    std::fs::write(&wrong, "something else").expect("a file");
    let from = wrong.display().to_string();
    let output = run(cache.path(), &["fetch", "--from", &from]);
    refused(&output, &[&from, "sha256", "allowed is only"]);
    assert!(!cache.path().join("meshes").exists());
}

//! Lists the files of `robots/` and `cells/`, which feature `embed` builds into
//! the program.
#![allow(
    clippy::unnecessary_debug_formatting,
    reason = "the quotes and escapes of a string literal are wanted"
)]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// Files that people write for a cell; other files of the folders are left out.
const EXTENSIONS: [&str; 5] = ["toml", "json", "urdf", "xrdf", "yaml"];

fn main() -> io::Result<()> {
    let variable = |name: &str| env::var_os(name).map(PathBuf::from).unwrap_or_default();
    let own = variable("CARGO_MANIFEST_DIR");
    // In a package both folders are part of it; here they are links, which
    // cargo does not watch.
    let checkout = own.join("../../..");
    let root = if checkout.join("cells").is_dir() {
        checkout
    } else {
        own
    };
    let target = variable("OUT_DIR").join("embedded.rs");
    println!("cargo::rerun-if-changed=build.rs");
    if env::var_os("CARGO_FEATURE_EMBED").is_none() {
        return fs::write(target, "None");
    }
    let mut paths = Vec::new();
    for folder in ["cells", "robots"] {
        println!("cargo::rerun-if-changed={}", root.join(folder).display());
        list(&root, Path::new(folder), &mut paths)?;
    }
    paths.sort();
    let mut text = String::from("Some(&[\n");
    for path in &paths {
        let full = root.join(path);
        let full = format!("{full:?}");
        // Writing to a string does not fail.
        let _written = writeln!(text, "    ({path:?}, include_str!({full})),").is_ok();
    }
    text.push_str("])");
    fs::write(target, text)
}

/// Adds the files below `folder`, as paths from `root` with forward slashes.
fn list(root: &Path, folder: &Path, paths: &mut Vec<String>) -> io::Result<()> {
    for entry in fs::read_dir(root.join(folder))? {
        let entry = entry?;
        let path = folder.join(entry.file_name());
        let known = path
            .extension()
            .is_some_and(|e| EXTENSIONS.iter().any(|known| e == *known));
        if entry.file_type()?.is_dir() {
            list(root, &path, paths)?;
        } else if known {
            paths.push(path.to_string_lossy().replace('\\', "/"));
        }
    }
    Ok(())
}

//! Every package of the build has a licence that `deny.toml` allows, also on a
//! machine without cargo-deny.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use serde_json::Value;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

fn allowed() -> BTreeSet<String> {
    let text = std::fs::read_to_string(format!("{ROOT}/deny.toml")).expect("deny.toml");
    let table: toml::Table = text.parse().expect("TOML");
    let list = table["licenses"]["allow"].as_array().expect("a list");
    list.iter()
        .map(|word| word.as_str().expect("a word").to_owned())
        .collect()
}

/// Whether one alternative of an SPDX expression consists of allowed licences
/// only. Parentheses group alternatives within a conjunction.
fn fits(expression: &str, allowed: &BTreeSet<String>) -> bool {
    let conjunction = expression.split(" AND ");
    conjunction.into_iter().all(|part| {
        let part = part.trim().trim_start_matches('(').trim_end_matches(')');
        part.split(" OR ")
            .flat_map(|word| word.split('/'))
            .any(|word| allowed.contains(word.trim()))
    })
}

/// The platform of this build: packages of others may not be on this machine.
fn host() -> String {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc).arg("-vV").output().expect("rustc");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.expect("rustc names its host").to_owned()
}

#[test]
fn every_licence_is_allowed() {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let manifest = format!("{ROOT}/Cargo.toml");
    let output = Command::new(cargo)
        .args(["metadata", "--offline", "--locked", "--format-version", "1"])
        .args(["--manifest-path", &manifest, "--filter-platform", &host()])
        .output()
        .expect("cargo");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("metadata");
    let allowed = allowed();
    let packages = metadata["packages"].as_array().expect("packages");
    assert!(packages.len() > 50, "all packages are listed");
    let refused: Vec<String> = packages
        .iter()
        .filter(|p| !fits(p["license"].as_str().unwrap_or(""), &allowed))
        .map(|p| format!("{} {}: {}", p["name"], p["version"], p["license"]))
        .collect();
    assert!(refused.is_empty(), "{refused:#?}");
}

#[test]
fn expressions_are_read_as_spdx_means_them() {
    let allowed = BTreeSet::from(["MIT".to_owned(), "Zlib".to_owned()]);
    for (expression, expected) in [
        ("MIT OR GPL-3.0", true),
        ("MIT/Apache-2.0", true),
        ("(MIT OR Apache-2.0) AND Zlib", true),
        ("MIT AND GPL-3.0", false),
        ("GPL-3.0", false),
        ("", false),
    ] {
        assert_eq!(fits(expression, &allowed), expected, "{expression}");
    }
}

/// Name and version of the packages in a lock file of cargo that have a checksum, and it.
fn locked() -> BTreeMap<(String, String), String> {
    let text = std::fs::read_to_string(format!("{ROOT}/Cargo.lock")).expect("a lock file");
    let table: toml::Table = text.parse().expect("TOML");
    let packages = table["package"].as_array().expect("packages").iter();
    let word = |package: &toml::Value, key: &str| package.get(key)?.as_str().map(str::to_owned);
    let of = |package| {
        let key = (word(package, "name")?, word(package, "version")?);
        Some((key, word(package, "checksum")?))
    };
    packages.filter_map(of).collect()
}

/// What the page is made of, by its lock file.
fn locked_of_page() -> BTreeMap<String, String> {
    let path = format!("{ROOT}/monitor-proc/ui/package-lock.json");
    let text = std::fs::read_to_string(path).expect("a lock file");
    let lock: Value = serde_json::from_str(&text).expect("JSON");
    let packages = lock["packages"].as_object().expect("packages").iter();
    let bundled = packages.filter(|(path, package)| !path.is_empty() && package["dev"] != true);
    let of = |(path, package): (&String, &Value)| {
        let (_, name) = path.rsplit_once("node_modules/").expect("a package");
        (
            name.to_owned(),
            package["version"].as_str().unwrap().to_owned(),
        )
    };
    bundled.map(of).collect()
}

#[test]
fn what_is_given_away_names_every_package_with_the_versions_of_the_lock_files() {
    let dir = tempfile::tempdir().unwrap();
    let made = Command::new(format!("{ROOT}/.ci/notices"))
        .arg(dir.path())
        .arg("--no-page")
        .output();
    let made = made.expect("python3, as the tests of recordings need it");
    let said = String::from_utf8_lossy(&made.stderr);
    assert!(made.status.success(), "{said}");
    let text = std::fs::read_to_string(dir.path().join("sbom.cdx.json")).unwrap();
    let sbom: Value = serde_json::from_str(&text).expect("JSON");
    let notices = std::fs::read_to_string(dir.path().join("NOTICES.txt")).unwrap();
    let (locked, mut page) = (locked(), locked_of_page());
    let components = sbom["components"].as_array().expect("components");
    let word = |component: &Value, key: &str| component[key].as_str().unwrap().to_owned();
    for component in components {
        let (name, version) = (word(component, "name"), word(component, "version"));
        if word(component, "purl").starts_with("pkg:npm/") {
            assert_eq!(page.remove(&name), Some(version), "{name}");
            continue;
        }
        let title = format!("\n{name} {version} (");
        assert!(notices.contains(&title), "no notice of {title}");
        let sum = component["hashes"][0]["content"].as_str();
        assert_eq!(locked.get(&(name, version)).map(String::as_str), sum);
    }
    assert!(page.is_empty(), "{page:?}");
    for name in ["iceoryx2", "rapier3d-f64", "nalgebra", "mcap", "lz4-sys"] {
        assert!(components.iter().any(|one| one["name"] == name), "{name}");
    }
}

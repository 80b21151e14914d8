//! Versions of the programs that the rows are compared with.

use std::process::Command;

/// The lock file that this program was built with.
pub(crate) const LOCK: &str = include_str!("../../../../Cargo.lock");

/// A note with the versions of these packages in the text of a lock file.
pub(crate) fn note(lock: &str, packages: &[&str]) -> String {
    let named = packages.iter().map(|name| {
        let version = locked(lock, name).unwrap_or("of an unknown version");
        format!("{name} {version}")
    });
    format!("compared with {}", named.collect::<Vec<_>>().join(", "))
}

fn locked<'a>(lock: &'a str, package: &str) -> Option<&'a str> {
    let (_, rest) = lock.split_once(&format!("name = \"{package}\"\nversion = \""))?;
    Some(rest.split_once('"')?.0)
}

/// Name and version in the output of `program --help`: the first line, e.g. `cyclictest V
/// 2.80`.
pub(crate) fn of_program(program: &str) -> Option<String> {
    let output = Command::new(program).arg("--help").output().ok()?;
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    let mut lines = said.lines().map(str::trim);
    lines
        .find(|line| line.starts_with(program))
        .map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_note_has_the_versions_of_the_lock_file() {
        let said = note(LOCK, &["iceoryx2", "serde"]);
        for package in ["iceoryx2 ", "serde "] {
            let (_, version) = said.split_once(package).unwrap();
            assert!(
                version.starts_with(|first: char| first.is_ascii_digit()),
                "{said}"
            );
        }
        assert_eq!(locked("name = \"ab\"\nversion = \"1.2.3\"\n", "b"), None);
        assert!(note(LOCK, &["no-such-package"]).contains("unknown"));
    }
}

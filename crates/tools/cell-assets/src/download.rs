//! Pip gets the package: it knows the user's proxies, mirrors and certificates.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::AssetError;
use crate::package::{REQUIREMENT, WHEEL};

/// Lines of pip's complaint that are passed on.
const LINES_SHOWN: usize = 6;

/// Downloads the package into `dir`; its path.
pub(crate) fn download(dir: &Path) -> Result<PathBuf, AssetError> {
    // Binary packages only: pip builds a source package to read its metadata, so its code would
    // run before the checksum is compared.
    let output = Command::new("python3")
        .args(["-m", "pip", "download", "--no-deps", "--no-input"])
        .args(["--only-binary", ":all:", "--disable-pip-version-check"])
        .arg(REQUIREMENT)
        .arg("-d")
        .arg(dir)
        .output()
        .map_err(AssetError::NoPython)?;
    let wheel = dir.join(WHEEL);
    // pip succeeds as well where a mirror has another build of the version, under another name.
    if output.status.success() && wheel.is_file() {
        return Ok(wheel);
    }
    Err(complaint(&String::from_utf8_lossy(&output.stderr)))
}

fn complaint(stderr: &str) -> AssetError {
    if stderr.contains("No module named pip") {
        return AssetError::NoPip;
    }
    let lines: Vec<&str> = stderr.lines().filter(|l| !l.trim().is_empty()).collect();
    let shown = &lines[lines.len().saturating_sub(LINES_SHOWN)..];
    AssetError::Pip {
        said: if shown.is_empty() {
            format!("it wrote no {WHEEL}")
        } else {
            shown.join("\n")
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_pips_complaint_is_passed_on() {
        let lines: Vec<String> = (0..20).map(|n| format!("line {n}")).collect();
        let long = lines.join("\n\n");
        let said = complaint(&long).to_string();
        assert!(
            said.contains("line 19") && !said.contains("line 13\n"),
            "{said}"
        );
    }

    #[test]
    fn missing_pip_has_its_own_words() {
        let error = complaint("/usr/bin/python3: No module named pip\n");
        assert!(matches!(error, AssetError::NoPip));
    }
}

//! The cells and robots that come with the programs.
//!
//! A leaf: only programs depend on it, so a changed number in a cell file
//! rebuilds no library.
#![forbid(unsafe_code)]

use std::io;
use std::path::{Path, PathBuf};

use cell_model::Data;

/// Path and text of every file of `robots/` and `cells/`, as the build script
/// found them; `None` where the checkout is read instead.
const EMBEDDED: Option<&[(&str, &str)]> = include!(concat!(env!("OUT_DIR"), "/embedded.rs"));

/// The files that are built into this program, or the checkout it was built from.
pub fn data() -> Data {
    EMBEDDED.map_or_else(Data::checkout, Data::files)
}

/// A directory with the same files, for other processes: the checkout itself,
/// or `dir`, into which the built-in files are written.
///
/// # Errors
/// Where `dir` cannot be written.
pub fn install(dir: &Path) -> io::Result<PathBuf> {
    let Some(files) = EMBEDDED else {
        return Ok(Data::checkout_dir());
    };
    for (name, text) in files {
        let path = dir.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)?;
        }
        std::fs::write(path, text)?;
    }
    Ok(dir.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_demos_are_here_and_can_be_given_to_other_processes() {
        let named = |data: &Data| {
            let demos = data.demos();
            demos
                .iter()
                .any(|(name, text)| name == "franka-stack" && !text.is_empty())
        };
        assert!(named(&data()));
        let dir = std::env::temp_dir().join(format!("robocell-files-{}", std::process::id()));
        let installed = Data::dir(install(&dir).unwrap());
        assert!(named(&installed));
        assert!(installed.read("robots/panda/robot.toml").is_ok());
        std::fs::remove_dir_all(&dir).ok();
    }
}

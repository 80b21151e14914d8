//! Paths and names of one run.

use std::path::PathBuf;

use iceoryx2::prelude::{Config, FileName, Path as BusPath, SemanticString};

use crate::error::BusError;

/// Longest root plus prefix. The transport appends a directory, an id of 39
/// digits and a suffix to make the name of a socket, which ends at 108 bytes.
// Checked when a run starts: beyond it the cell starts, and its first doorbell fails.
const MAX_LENGTH: usize = 61;
/// Shortest prefix: segments of all runs of the machine share a directory, and the wipe must
/// not take those of another.
// An empty or one-letter prefix would match segments of other programs.
const MIN_PREFIX: usize = 4;

/// The root directory and the prefix of one run; it has no files elsewhere.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunSite {
    /// Directory of the run's service files and sockets; its own, on tmpfs.
    pub root: PathBuf,
    /// Start of the names of its segments in shared memory; its own, 4
    /// characters or more of `a-z A-Z 0-9 _ -`, ending in `_`, so that no
    /// prefix is the start of another.
    pub prefix: String,
}

impl RunSite {
    /// Checks both names.
    pub fn check(&self) -> Result<(), BusError> {
        // The transport's paths are ASCII; another name fails later, in the middle of a start.
        let root = self.root.display().to_string();
        if !self.root.is_absolute() || self.root.to_str().is_none() {
            return Err(site(
                "root",
                root,
                "an absolute path in UTF-8 is needed".to_owned(),
            ));
        }
        if !root.chars().all(|c| c.is_ascii() && !c.is_ascii_control()) {
            return Err(site(
                "root",
                root,
                "letters, digits and signs of ASCII are possible; set ROBOCELL_RUN_DIR \
                 to such a path"
                    .to_owned(),
            ));
        }
        // A slash or a dot would lead out of the shared-memory directory.
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let prefix = self.prefix.as_str();
        if prefix.len() < MIN_PREFIX || !prefix.ends_with('_') || !prefix.chars().all(plain) {
            let allowed = format!("{MIN_PREFIX} or more of a-z, A-Z, 0-9, _ and -, ending in _");
            return Err(site("prefix", prefix.to_owned(), allowed));
        }
        let length = root.len() + prefix.len();
        if length > MAX_LENGTH {
            let allowed = format!(
                "root and prefix `{prefix}` are {length} characters together, {MAX_LENGTH} are \
                 possible; set ROBOCELL_RUN_DIR to a shorter path"
            );
            return Err(site("root", root, allowed));
        }
        Ok(())
    }

    /// The transport's settings for this run, regardless of its configuration files.
    // A default configuration is changed in place: `iceoryx2.toml` in the working directory or
    // the home directory must not move a run.
    pub fn config(&self) -> Result<Config, BusError> {
        // Checked first, so that the error names the wrong part and the remedy.
        self.check()?;
        let mut config = Config::default();
        let root = self.root.display().to_string();
        let path = BusPath::new(root.as_bytes())
            .map_err(|error| site("root", root.clone(), format!("{error:?}")))?;
        config.global.set_root_path(&path);
        config.global.prefix = FileName::new(self.prefix.as_bytes())
            .map_err(|error| site("prefix", self.prefix.clone(), format!("{error:?}")))?;
        Ok(config)
    }
}

fn site(what: &'static str, value: String, allowed: String) -> BusError {
    BusError::Site {
        what,
        value,
        allowed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(root: &str, prefix: &str) -> Result<(), BusError> {
        RunSite {
            root: root.into(),
            prefix: prefix.to_owned(),
        }
        .check()
    }

    #[test]
    fn names_that_would_break_later_are_refused_now() {
        assert!(at("/dev/shm/r/cell/b0", "rc0_").is_ok());
        assert!(at("relative", "rc0_").is_err());
        for prefix in ["", "_", "rc0", "r/c_", "../_", "rc 0_"] {
            assert!(at("/dev/shm/r", prefix).is_err(), "{prefix}");
        }
        for root in ["/dev/shm/r\u{f6}bot", "/dev/shm/a\nb"] {
            let said = at(root, "rc0_").unwrap_err().to_string();
            assert!(
                said.contains("ASCII") && said.contains("ROBOCELL_RUN_DIR"),
                "{said}"
            );
        }
        let long = at(&format!("/dev/shm/{}", "x".repeat(60)), "rc0_")
            .unwrap_err()
            .to_string();
        assert!(
            long.contains("ROBOCELL_RUN_DIR") && long.contains("61"),
            "{long}"
        );
    }
}

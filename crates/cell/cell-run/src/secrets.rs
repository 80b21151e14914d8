//! The secrets that open the page of a run.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use serde::{Deserialize, Serialize};

/// Bytes of each secret: 128 bits cannot be guessed.
const BYTES: usize = 16;

/// The secrets of the page: written by the launcher, mode 0600, kept over restarts of the
/// monitor. Each is 32 hexadecimal digits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PageSecrets {
    /// Exchanged for the right to command. A link with it works once: the monitor
    /// replaces it after the exchange.
    pub operator_token: String,
    /// Exchanged for the right to look; a link with it is for several viewers.
    pub viewer_token: String,
    /// Cookie of an operator.
    pub operator_cookie: String,
    /// Cookie of a viewer.
    pub viewer_cookie: String,
}

impl PageSecrets {
    /// New random secrets.
    ///
    /// # Errors
    /// Returns an error if the system has no random numbers.
    pub fn random() -> io::Result<Self> {
        Ok(Self {
            operator_token: random()?,
            viewer_token: random()?,
            operator_cookie: random()?,
            viewer_cookie: random()?,
        })
    }

    /// The same secrets with a new `operator_token`.
    ///
    /// # Errors
    /// Returns an error if the system has no random numbers.
    pub fn with_new_operator_token(&self) -> io::Result<Self> {
        Ok(Self {
            operator_token: random()?,
            ..self.clone()
        })
    }

    /// Name of the cookie of a page at `port`. All ports of a host share their cookies, so the
    /// name distinguishes the cells.
    pub fn cookie_name(port: u16) -> String {
        format!("robocell_{port}")
    }

    /// Writes the secrets to `path`, mode 0600.
    ///
    /// # Errors
    /// Returns errors of the file system.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        // Other users of the machine must not operate the cell.
        cell_model::draft::replace_unsynced(path, &serde_json::to_vec(self)?, 0o600)
    }

    /// Reads the secrets at `path`.
    ///
    /// # Errors
    /// Returns an error if the file is missing or not of this version.
    pub fn load(path: &Path) -> io::Result<Self> {
        Ok(serde_json::from_slice(&fs::read(path)?)?)
    }
}

fn random() -> io::Result<String> {
    let mut bytes = [0_u8; BYTES];
    // A generator of ours would need a seed that is as secret.
    File::open("/dev/urandom")?.read_exact(&mut bytes)?;
    Ok(format!("{:032x}", u128::from_ne_bytes(bytes)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::MetadataExt;

    #[test]
    fn secrets_are_for_their_owner_and_never_the_same() {
        let path = std::env::temp_dir().join(format!("robocell-secrets-{}", std::process::id()));
        let made = PageSecrets::random().unwrap();
        made.save(&path).unwrap();
        assert_eq!(PageSecrets::load(&path).unwrap(), made);
        assert_eq!(fs::metadata(&path).unwrap().mode() & 0o777, 0o600);
        fs::remove_file(&path).unwrap();
        assert_ne!(made.operator_token, made.viewer_token);
        assert_eq!(made.operator_cookie.len(), 2 * BYTES);
        assert!(PageSecrets::load(&path).is_err());
        let next = made.with_new_operator_token().unwrap();
        assert_ne!(next.operator_token, made.operator_token);
        assert_eq!(next.operator_cookie, made.operator_cookie);
    }
}

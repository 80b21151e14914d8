//! What rows depend on beside their seed.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

use cell_model::user_file;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

/// Names of a build and of all inputs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Name of the build: version, and hash of the program.
    pub build: String,
    /// Hash of the inputs.
    pub inputs: String,
}

/// Name of the build of this process.
///
/// # Errors
/// Where its program cannot be read.
pub fn own_build() -> io::Result<String> {
    // Not by the path of the program: another build may be there by now.
    let hash = hash_of(&mut File::open("/proc/self/exe")?)?;
    Ok(format!("{}+{}", env!("CARGO_PKG_VERSION"), short(hash)))
}

fn hash_of(file: &mut File) -> io::Result<Sha256> {
    let mut hash = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(hash),
            count => hash.update(&buffer[..count]),
        }
    }
}

/// Collects inputs: files and options by name.
// Sorted by name: the hash does not depend on the order in which files were read.
#[derive(Clone, Debug, Default)]
pub struct Inputs(BTreeMap<String, String>);

impl Inputs {
    /// Adds what has `name`; the last of a name counts.
    pub fn add(&mut self, name: &str, content: &[u8]) {
        self.0
            .insert(name.to_owned(), short(Sha256::new_with_prefix(content)));
    }

    /// Adds the file at `path` as `name`.
    ///
    /// # Errors
    /// Where it cannot be read.
    pub fn add_file(&mut self, name: &str, path: &Path) -> io::Result<()> {
        let hash = hash_of(&mut user_file::open_file(path)?)?;
        self.0.insert(name.to_owned(), short(hash));
        Ok(())
    }

    /// Their hash.
    pub fn hash(&self) -> String {
        let mut hash = Sha256::new();
        for (name, content) in &self.0 {
            // With the length, two different lists of inputs cannot be the same bytes.
            hash.update(name.len().to_le_bytes());
            hash.update(name);
            hash.update(content);
        }
        short(hash)
    }
}

/// 64 bits are enough to tell inputs apart.
fn short(hash: Sha256) -> String {
    let mut text = String::new();
    for byte in hash.finalize().iter().take(8) {
        let _infallible = write!(text, "{byte:02x}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_input_changes_the_hash_and_their_order_does_not() {
        let of = |all: &[(&str, &str)]| {
            let mut inputs = Inputs::default();
            for (name, content) in all {
                inputs.add(name, content.as_bytes());
            }
            inputs.hash()
        };
        let base = of(&[("cell", "a"), ("robot", "b")]);
        assert_eq!(base, of(&[("robot", "b"), ("cell", "a")]));
        for other in [
            of(&[("cell", "a")]),
            of(&[("cell", "b"), ("robot", "a")]),
            of(&[("cell", "a"), ("robot", "c")]),
            of(&[("cell", "a"), ("robo", "b")]),
        ] {
            assert_ne!(base, other);
        }
        assert_eq!(own_build().unwrap(), own_build().unwrap());
    }
}

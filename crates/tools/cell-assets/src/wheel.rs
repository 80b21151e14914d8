//! The downloaded file is the one that was looked at when this was written.

use std::fmt::Write as _;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::AssetError;

/// Opens a regular file: a device or a pipe may have no end.
pub(crate) fn open(path: &Path) -> Result<File, AssetError> {
    let is_file = std::fs::metadata(path).map(|meta| meta.is_file());
    let opened = is_file.and_then(|is_file| {
        if is_file {
            return File::open(path);
        }
        Err(std::io::Error::other("name a regular file"))
    });
    opened.map_err(AssetError::file("opening", path))
}

/// sha256 of a file in lower-case hexadecimal.
///
/// # Errors
///
/// When the file cannot be read.
pub fn sha256(path: &Path) -> Result<String, AssetError> {
    let mut file = open(path)?;
    let mut hasher = Sha256::new();
    // In blocks: the package has 131 MB.
    let mut block = vec![0; 1 << 16];
    loop {
        let count = file
            .read(&mut block)
            .map_err(AssetError::file("reading", path))?;
        if count == 0 {
            break;
        }
        hasher.update(&block[..count]);
    }
    let mut text = String::with_capacity(64);
    for byte in hasher.finalize() {
        // Writing to a string cannot fail.
        write!(text, "{byte:02x}").unwrap_or_default();
    }
    Ok(text)
}

/// Refuses a file with another sum than `expected`.
///
/// # Errors
///
/// When the sum differs, or the file cannot be read.
pub fn verify(path: &Path, expected: &str) -> Result<(), AssetError> {
    let found = sha256(path)?;
    if found == expected {
        return Ok(());
    }
    Err(AssetError::Checksum {
        path: path.to_owned(),
        found,
        expected: expected.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_sum_is_refused_and_both_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.whl");
        std::fs::write(&path, b"abc").unwrap();
        // FIPS 180-2, appendix B.1.
        let sum = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        verify(&path, sum).unwrap();
        let said = verify(&path, crate::package::SHA256)
            .unwrap_err()
            .to_string();
        assert!(
            said.contains(sum) && said.contains(crate::package::SHA256),
            "{said}"
        );
    }

    #[test]
    fn a_device_is_refused_before_it_is_read() {
        let said = sha256(Path::new("/dev/zero")).unwrap_err().to_string();
        assert!(
            said.contains("/dev/zero") && said.contains("regular file"),
            "{said}"
        );
    }
}

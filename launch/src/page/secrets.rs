//! What opens the page: fresh for every run, kept in a file of its owner.

use std::fs::{self, OpenOptions};
use std::io::{Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use cell_model::runs::spec::PageSecrets;

use crate::failure::{Context, Failure};

/// Bytes of each secret.
const BYTES: usize = 16;

/// New ones.
pub(crate) fn make() -> Result<PageSecrets, Failure> {
    Ok(PageSecrets {
        operator_token: random()?,
        viewer_token: random()?,
        operator_cookie: random()?,
        viewer_cookie: random()?,
    })
}

/// Writes them to `path`, mode 0600.
pub(crate) fn save(secrets: &PageSecrets, path: &Path) -> Result<(), Failure> {
    let what = format!("write {}", path.display());
    let text = serde_json::to_string(secrets).cannot(&what)?;
    let mut file = OpenOptions::new()
        .write(true)
        .create(true)
        .truncate(true)
        .mode(0o600)
        .open(path)
        .cannot(&what)?;
    file.write_all(text.as_bytes()).cannot(&what)
}

/// Those at `path`.
pub(crate) fn load(path: &Path) -> Option<PageSecrets> {
    serde_json::from_str(&fs::read_to_string(path).ok()?).ok()
}

fn random() -> Result<String, Failure> {
    let mut bytes = [0_u8; BYTES];
    let mut source = fs::File::open("/dev/urandom").cannot("open /dev/urandom")?;
    source.read_exact(&mut bytes).cannot("read /dev/urandom")?;
    Ok(format!("{:032x}", u128::from_ne_bytes(bytes)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::MetadataExt;

    #[test]
    fn secrets_are_for_their_owner_and_never_the_same() {
        let path = std::env::temp_dir().join(format!("robocell-secrets-{}", std::process::id()));
        let made = make().unwrap();
        save(&made, &path).unwrap();
        assert_eq!(load(&path), Some(made.clone()));
        assert_eq!(fs::metadata(&path).unwrap().mode() & 0o777, 0o600);
        let again = make().unwrap();
        fs::remove_file(&path).unwrap();
        assert_ne!(made.operator_token, again.operator_token);
        assert_ne!(made.operator_token, made.viewer_token);
        assert_eq!(made.operator_cookie.len(), 2 * BYTES);
        assert_eq!(load(&path), None);
    }
}

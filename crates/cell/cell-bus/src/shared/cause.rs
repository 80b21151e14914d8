//! Why a port could not be made.

use std::fs::{self, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use crate::error::BusError;
use crate::site::RunSite;

/// Where shared memory is.
const SHM: &str = "/dev/shm";

pub(super) fn no_place(service: &str, ports: &'static str, limit: usize) -> BusError {
    BusError::NoPlace {
        service: service.to_owned(),
        ports,
        limit,
    }
}

/// The transport has one reason for all errors of the system, so the system is asked again: a
/// port is files in the directory of the run and in shared memory.
pub(super) fn port_error(service: &str, reason: impl core::fmt::Debug, site: &RunSite) -> BusError {
    let own = std::process::id();
    let files = [
        site.root.join(format!("probe-{own}")),
        Path::new(SHM).join(format!("{}probe-{own}", site.prefix)),
    ];
    let refused = files
        .iter()
        .find_map(|file| Some((file, write(file).err()?)));
    let cause = refused.map(|(file, error)| format!(": {}: {error}", file.display()));
    BusError::Port {
        service: service.to_owned(),
        reason: format!("{reason:?}{}", cause.unwrap_or_default()),
    }
}

/// Makes a file with content, and removes it.
fn write(file: &PathBuf) -> io::Result<()> {
    let made = OpenOptions::new().write(true).create_new(true).open(file);
    let written = made.and_then(|mut made| made.write_all(b"x"));
    // It may not have been made.
    fs::remove_file(file).ok();
    written
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_that_cannot_be_written_is_named_with_the_error_of_the_system() {
        let site = RunSite {
            // No user can make files there.
            root: "/proc/self/fdinfo".into(),
            prefix: "rc0_".to_owned(),
        };
        let text = port_error("task/trace", "UnableToCreatePortTag", &site).to_string();
        assert!(text.contains("task/trace"), "{text}");
        assert!(text.contains("/proc/self/fdinfo"), "{text}");
        assert!(text.contains("os error"), "{text}");
        assert!(!text.contains("look on"), "{text}");
    }
}

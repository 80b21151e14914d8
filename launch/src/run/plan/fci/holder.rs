//! The program that listens at an address.

use std::fs;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::Path;

/// Name and process number of the program that listens at `at`. `None` where it is not told: for
/// programs of other users, and for addresses of IPv6.
pub(super) fn of(at: SocketAddr) -> Option<(String, u32)> {
    let link = format!("socket:[{}]", socket(at)?);
    let processes = fs::read_dir("/proc").ok()?.flatten();
    processes.into_iter().find_map(|process| {
        let pid: u32 = process.file_name().to_str()?.parse().ok()?;
        has(&process.path(), &link).then_some(())?;
        let name = fs::read_to_string(process.path().join("comm")).ok()?;
        Some((name.trim_end().to_owned(), pid))
    })
}

/// Number of the socket that listens at `at`, or at its port on all addresses (proc(5),
/// `/proc/net/tcp`).
fn socket(at: SocketAddr) -> Option<u64> {
    // `TCP_LISTEN` of the kernel.
    const LISTENS: &str = "0A";
    let SocketAddr::V4(at) = at else {
        return None;
    };
    let local = |address: &Ipv4Addr| {
        // The kernel prints the bytes of the address, in network order, as one number of this
        // machine.
        let number = u32::from_ne_bytes(address.octets());
        format!("{number:08X}:{:04X}", at.port())
    };
    let wanted = [local(at.ip()), local(&Ipv4Addr::UNSPECIFIED)];
    let table = fs::read_to_string("/proc/net/tcp").ok()?;
    table.lines().skip(1).find_map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let is_it = words.get(3) == Some(&LISTENS) && wanted.iter().any(|w| w == words[1]);
        is_it.then(|| words.get(9)?.parse().ok())?
    })
}

/// Whether a process has the file behind this link open.
fn has(process: &Path, link: &str) -> bool {
    let Ok(open) = fs::read_dir(process.join("fd")) else {
        return false;
    };
    open.flatten()
        .any(|file| fs::read_link(file.path()).is_ok_and(|to| to == Path::new(link)))
}

//! Memory that is available before it is needed.

use std::io;

use crate::limits::{Resource, limit};

/// A limit below this would be hit by a later allocation, which would then
/// fail, and end the process.
const ENOUGH_TO_LOCK: u64 = 1 << 30;
/// Number of the capability that ignores the limit.
const CAP_IPC_LOCK: u32 = 14;

/// Locks all pages of this process, present and future, into memory. Refused
/// without the right to lock 1 GiB or more (`RLIMIT_MEMLOCK`, `CAP_IPC_LOCK`):
/// memory beyond the limit could not be allocated any more.
pub fn lock_all() -> io::Result<()> {
    // Checked first: with `MCL_FUTURE` the call succeeds, and a later allocation fails.
    if limit(Resource::LockedMemory)? < ENOUGH_TO_LOCK && !has_capability(CAP_IPC_LOCK) {
        let text = "the limit of locked memory is below 1 GiB";
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, text));
    }
    // SAFETY: mlockall takes flags and touches no memory of ours.
    if unsafe { libc::mlockall(libc::MCL_CURRENT | libc::MCL_FUTURE) } == 0 {
        Ok(())
    } else {
        Err(io::Error::last_os_error())
    }
}

/// Whether the process holds capability number `bit`.
fn has_capability(bit: u32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("CapEff:"));
    let held = line.and_then(|hex| u64::from_str_radix(hex.trim(), 16).ok());
    held.is_some_and(|held| held >> bit & 1 == 1)
}

/// Bytes of stack [`prefault_stack`] touches.
// An eighth of the stack of a thread (2 MiB), so that it fits on every thread.
pub const STACK_PREFAULT: usize = 256 * 1024;

/// Touches the stack below the caller once, so that no cycle meets a page fault
/// there.
#[inline(never)]
#[allow(
    clippy::large_stack_arrays,
    reason = "a large array on the stack is the purpose"
)]
pub fn prefault_stack() {
    let mut block = [0_u8; STACK_PREFAULT];
    for page in block.chunks_mut(4096) {
        if let Some(byte) = page.first_mut() {
            *byte = 1;
        }
    }
    core::hint::black_box(&mut block);
}

/// Keeps freed heap memory in the process, so that later allocations cause no page fault.
pub fn keep_heap() {
    #[cfg(target_env = "gnu")]
    // SAFETY: mallopt takes two integers; -1 switches trimming off, 0 forbids
    // separate mappings for large blocks.
    unsafe {
        libc::mallopt(libc::M_TRIM_THRESHOLD, -1);
        libc::mallopt(libc::M_MMAP_MAX, 0);
    }
}

/// Reserves every page of the writable mappings of files whose path starts with `prefix` for
/// this process: later, a write to a page that a full tmpfs cannot supply would end it by
/// SIGBUS. Returns the bytes that there was no room for, or that an older kernel (before 5.14)
/// cannot reserve.
pub fn populate(prefix: &str) -> io::Result<u64> {
    let mut missing = 0;
    for line in std::fs::read_to_string("/proc/self/maps")?.lines() {
        // As in `7f00-7f10 rw-s 00000000 00:19 42   /dev/shm/name`.
        let mut words = line.split_ascii_whitespace();
        let (Some(range), Some(rights)) = (words.next(), words.next()) else {
            continue;
        };
        let is_ours = words.nth(3).is_some_and(|path| path.starts_with(prefix));
        let ends = range.split_once('-').and_then(|(from, to)| {
            let parse = |hex| usize::from_str_radix(hex, 16).ok();
            Some((parse(from)?, parse(to)?))
        });
        let (true, true, Some((from, to))) = (is_ours, rights.starts_with("rw"), ends) else {
            continue;
        };
        let address = core::ptr::without_provenance_mut::<libc::c_void>(from);
        // SAFETY: this populates pages and changes none; a range that was unmapped
        // meanwhile is an error.
        if unsafe { libc::madvise(address, to - from, libc::MADV_POPULATE_WRITE) } != 0 {
            // The others are still tried: each page that is there is one SIGBUS less.
            missing += (to - from) as u64;
        }
    }
    Ok(missing)
}

/// Free bytes of the file system of `path`, for this user.
pub fn free_bytes(path: &std::path::Path) -> io::Result<u64> {
    use std::os::unix::ffi::OsStrExt;
    let name = std::ffi::CString::new(path.as_os_str().as_bytes())?;
    // SAFETY: statvfs is plain data, all zeros is a value of it.
    let mut info: libc::statvfs = unsafe { core::mem::zeroed() };
    // SAFETY: the name ends with a zero byte and the pointer is to a live value.
    if unsafe { libc::statvfs(name.as_ptr(), &raw mut info) } != 0 {
        return Err(io::Error::last_os_error());
    }
    // `bavail`, not `bfree`: the rest is reserved for root.
    Ok(info.f_bavail.saturating_mul(info.f_frsize))
}

/// Whether `path` is on a file system that is kept in memory.
pub fn is_tmpfs(path: &std::path::Path) -> io::Result<bool> {
    use std::os::unix::ffi::OsStrExt;
    let name = std::ffi::CString::new(path.as_os_str().as_bytes())?;
    // SAFETY: statfs is plain data, all zeros is a value of it.
    let mut info: libc::statfs = unsafe { core::mem::zeroed() };
    // SAFETY: the name ends with a zero byte and the pointer is to a live value.
    if unsafe { libc::statfs(name.as_ptr(), &raw mut info) } != 0 {
        return Err(io::Error::last_os_error());
    }
    Ok(info.f_type == libc::TMPFS_MAGIC)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn shared_memory_is_a_tmpfs_with_room_and_proc_is_not() {
        assert!(is_tmpfs(Path::new("/dev/shm")).unwrap());
        assert!(free_bytes(Path::new("/dev/shm")).unwrap() > 0);
        assert!(!is_tmpfs(Path::new("/proc")).unwrap());
        assert!(free_bytes(Path::new("/no/such/place")).is_err());
    }

    #[test]
    fn pages_of_a_mapping_are_there_before_they_are_written() {
        let path = format!("/dev/shm/robocell-populate-{}", std::process::id());
        let words = crate::shared::SharedWords::open(Path::new(&path), 1 << 16).unwrap();
        assert_eq!(populate("/dev/shm/robocell-populate-none").unwrap(), 0);
        assert_eq!(populate(&path).unwrap(), 0);
        let maps = std::fs::read_to_string("/proc/self/smaps").unwrap();
        let mut of_ours = maps.lines().skip_while(|line| !line.ends_with(&path));
        let resident = of_ours.find(|line| line.starts_with("Rss:")).unwrap();
        assert!(resident.contains("512 kB"), "{resident}");
        drop(words);
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn the_stack_can_be_touched() {
        prefault_stack();
    }
}

//! Memory that is there before it is needed.

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

/// Gives freed heap memory never back to the kernel, so that later allocations
/// meet no page fault.
pub fn keep_heap() {
    #[cfg(target_env = "gnu")]
    // SAFETY: mallopt takes two integers; -1 switches trimming off, 0 forbids
    // separate mappings for large blocks.
    unsafe {
        libc::mallopt(libc::M_TRIM_THRESHOLD, -1);
        libc::mallopt(libc::M_MMAP_MAX, 0);
    }
}

/// Free bytes of the file system `path` lies on, for this user.
pub fn free_bytes(path: &std::path::Path) -> io::Result<u64> {
    use std::os::unix::ffi::OsStrExt;
    let name = std::ffi::CString::new(path.as_os_str().as_bytes())?;
    // SAFETY: statvfs is plain data, all zeros is a value of it.
    let mut info: libc::statvfs = unsafe { core::mem::zeroed() };
    // SAFETY: the name ends with a zero byte and the pointer is to a live value.
    if unsafe { libc::statvfs(name.as_ptr(), &raw mut info) } != 0 {
        return Err(io::Error::last_os_error());
    }
    Ok(info.f_bavail.saturating_mul(info.f_frsize))
}

/// Whether `path` lies on a file system that is kept in memory.
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
    fn the_stack_can_be_touched() {
        prefault_stack();
    }
}

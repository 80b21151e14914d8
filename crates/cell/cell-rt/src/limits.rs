//! Resource limits of the process, which its children inherit.

use std::io;

/// A resource the kernel limits per process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
// Raising is best effort: a program must start on a machine with low limits as well.
pub enum Resource {
    /// Number of open files.
    OpenFiles,
    /// Bytes of the main thread's stack.
    Stack,
    /// Bytes that may be locked into memory.
    LockedMemory,
}

impl Resource {
    fn number(self) -> libc::__rlimit_resource_t {
        match self {
            Self::OpenFiles => libc::RLIMIT_NOFILE,
            Self::Stack => libc::RLIMIT_STACK,
            Self::LockedMemory => libc::RLIMIT_MEMLOCK,
        }
    }
}

fn get(resource: Resource) -> io::Result<libc::rlimit> {
    let mut limit = libc::rlimit {
        rlim_cur: 0,
        rlim_max: 0,
    };
    // SAFETY: the pointer is to a live limit.
    if unsafe { libc::getrlimit(resource.number(), &raw mut limit) } == 0 {
        Ok(limit)
    } else {
        Err(io::Error::last_os_error())
    }
}

fn set(resource: Resource, limit: libc::rlimit) -> bool {
    // SAFETY: the pointer is to a live limit.
    unsafe { libc::setrlimit(resource.number(), &raw const limit) == 0 }
}

/// The limit in force.
///
/// # Errors
/// Of the kernel.
pub fn limit(resource: Resource) -> io::Result<u64> {
    get(resource).map(|limit| limit.rlim_cur)
}

/// Raises the limit to `wanted`, or as far as this user may. Returns the limit in
/// force, which is never lower than before.
///
/// # Errors
/// Of the kernel when the limit cannot be read.
pub fn raise(resource: Resource, wanted: u64) -> io::Result<u64> {
    let now = get(resource)?;
    if now.rlim_cur >= wanted {
        return Ok(now.rlim_cur);
    }
    let with = |soft: u64, hard: u64| libc::rlimit {
        rlim_cur: soft,
        rlim_max: hard,
    };
    // The hard limit needs a privilege.
    let raised = set(resource, with(wanted, now.rlim_max.max(wanted)))
        || set(resource, with(wanted.min(now.rlim_max), now.rlim_max));
    if raised {
        limit(resource)
    } else {
        Ok(now.rlim_cur)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_raised_and_never_lowered() {
        let before = limit(Resource::OpenFiles).unwrap();
        assert_eq!(raise(Resource::OpenFiles, 1).unwrap(), before);
        assert!(raise(Resource::OpenFiles, before + 1).unwrap() >= before);
        assert!(limit(Resource::Stack).unwrap() > 0);
    }
}

//! What this machine must grant before a run starts. Without it processes would
//! end later, with an error that does not name the cause.

use std::fmt::Display;
use std::path::Path;

use cell_rt::limits::{Resource, limit, raise};
use cell_rt::memory::free_bytes;

use crate::failure::{Context, Failure};
use crate::rundir::ENV_RUN_DIR;

/// Open files of one process: the monitor of two arms has 210, a page 17 more,
/// connections of other clients up to 80.
const OPEN_FILES: u64 = 512;
/// Stack of the main thread (bytes): 512 KiB is enough in a release build.
const STACK: u64 = 1 << 20;
/// The usual stack, asked for where the limit is lower.
const USUAL_STACK: u64 = 8 << 20;
/// Run directory of a run without the ring of the flight recorder (bytes): 3.5 MiB
/// were measured (files of the bus, checkpoints, history, black boxes, built-in cells).
const RUN_DIR: u64 = 5 << 20;

/// Raises the limits this user may raise; refuses a run on a machine that grants
/// too little.
pub(crate) fn check(run_dir: &Path) -> Result<(), Failure> {
    let shown = run_dir.display();
    Granted {
        open_files: raise(Resource::OpenFiles, OPEN_FILES)
            .cannot("read the limit of open files")?,
        stack: limit(Resource::Stack).cannot("read the limit of the stack")?,
        free: free_bytes(run_dir).cannot(format!("read the free space of {shown}"))?,
    }
    .check(&shown)
    .map_err(Failure::configuration)
}

/// What the machine grants.
struct Granted {
    open_files: u64,
    /// Bytes.
    stack: u64,
    /// Bytes in the run directory.
    free: u64,
}

impl Granted {
    fn check(&self, run_dir: &dyn Display) -> Result<(), String> {
        let Self {
            open_files,
            stack,
            free,
        } = *self;
        if open_files < OPEN_FILES {
            return Err(format!(
                "each process may open {open_files} files, a cell needs {OPEN_FILES}: raise the \
                 limit (`ulimit -n {OPEN_FILES}`; for all sessions `nofile` in \
                 /etc/security/limits.conf)"
            ));
        }
        if stack < STACK {
            let (has, needs) = (stack >> 10, STACK >> 10);
            return Err(format!(
                "the stack is limited to {has} KiB, a cell needs {needs} KiB: raise the limit \
                 (`ulimit -s {needs}`)"
            ));
        }
        if free < RUN_DIR {
            let (has, needs) = (free >> 10, RUN_DIR >> 10);
            return Err(format!(
                "{run_dir} has {has} KiB free, a run needs {needs} KiB: free some, or set \
                 {ENV_RUN_DIR} to a directory with room"
            ));
        }
        Ok(())
    }
}

/// Gives this process and its children the usual stack, where the user may: a low
/// limit is met by a stack overflow, long before it could be reported.
pub fn raise_stack() {
    // What cannot be raised is refused by `check`.
    raise(Resource::Stack, USUAL_STACK).ok();
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENOUGH: Granted = Granted {
        open_files: OPEN_FILES,
        stack: STACK,
        free: RUN_DIR,
    };

    #[test]
    fn what_is_missing_is_named_with_what_to_do() {
        let refused = |granted: Granted, part: &str| {
            let message = granted.check(&"/run").unwrap_err();
            assert!(message.contains(part), "{message}");
        };
        assert_eq!(ENOUGH.check(&"/run"), Ok(()));
        let open_files = 48;
        refused(
            Granted {
                open_files,
                ..ENOUGH
            },
            "48 files, a cell needs 512: raise",
        );
        let stack = 256 << 10;
        refused(
            Granted { stack, ..ENOUGH },
            "256 KiB, a cell needs 1024 KiB",
        );
        let free = 64 << 10;
        refused(
            Granted { free, ..ENOUGH },
            "/run has 64 KiB free, a run needs 5120 KiB",
        );
    }
}

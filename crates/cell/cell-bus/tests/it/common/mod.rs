//! A private run for one test: its own root and prefix, wiped at the end.

#![allow(dead_code, unreachable_pub, reason = "each test file uses its part")]

use std::sync::atomic::{AtomicU32, Ordering};

use cell_bus::{Bus, Keeper, RunSite};
use ipc_types::header::{Header, Message};
use ipc_types::{Decision, Wire};

static NEXT: AtomicU32 = AtomicU32::new(0);

/// Identity of the runs of the tests.
pub const RUN: u64 = 77;

/// A run and its keeper. The site is wiped when it is dropped.
pub struct TestRun {
    pub site: RunSite,
    pub keeper: Option<Keeper>,
    _dir: tempfile::TempDir,
}

impl TestRun {
    pub fn new() -> Self {
        let dir = tempfile::Builder::new()
            .prefix("cb")
            .tempdir_in("/dev/shm")
            .unwrap();
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let site = RunSite {
            root: dir.path().join("b"),
            prefix: format!("cbt{:x}x{number:x}_", std::process::id()),
        };
        let keeper = Some(Keeper::create(&site, RUN, 1).unwrap());
        Self {
            site,
            keeper,
            _dir: dir,
        }
    }

    /// Joins as start number `generation` of a process.
    pub fn join(&self, generation: u32) -> Bus {
        Bus::join(&self.site, RUN, generation, "test").unwrap()
    }
}

impl Drop for TestRun {
    fn drop(&mut self) {
        self.keeper = None;
        cell_bus::wipe(&self.site).unwrap();
    }
}

/// A valid decision that answers `tick` and carries `drops`.
pub fn decision(tick: u64, drops: u32) -> Decision {
    let mut decision = Decision::zeroed();
    decision.drops = drops;
    *decision.header_mut() = Header::caused_by::<Decision>(tick);
    decision
}

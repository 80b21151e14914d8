//! Files shared by the two processes of the bench.

use std::fs::DirBuilder;
use std::os::unix::fs::DirBuilderExt;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use cell_bus::RunSite;
use cell_rt::shared::SharedWords;
use cell_rt::{monotonic_ns, sleep_until};

use super::{BenchError, io};

/// Time limit for any answer of the other process.
pub(crate) const PATIENCE_NS: u64 = 2_000_000_000;
/// Identity of the bench's run.
pub(crate) const RUN: u64 = 1;

/// A directory on tmpfs with the bus's root, the raw values, the socket and the control words.
/// The process that created it deletes it.
#[derive(Debug)]
pub(crate) struct BenchRun {
    pub(crate) dir: PathBuf,
    pub(crate) site: RunSite,
    owned: bool,
}

impl BenchRun {
    /// Creates a new one, named by the own process id.
    pub(crate) fn create() -> Result<Self, BenchError> {
        let id = std::process::id();
        let dir = PathBuf::from(format!("/dev/shm/robocell-bench-{id:x}"));
        let prefix = format!("rcb{id:x}_");
        // Before any file: the segments are for this user only.
        cell_rt::process::private_umask();
        DirBuilder::new()
            .mode(0o700)
            .create(&dir)
            .map_err(io("make its directory"))?;
        Ok(Self {
            site: RunSite {
                root: dir.join("b"),
                prefix,
            },
            dir,
            owned: true,
        })
    }

    /// The one created by another process.
    pub(crate) fn join(dir: PathBuf, prefix: String) -> Self {
        Self {
            site: RunSite {
                root: dir.join("b"),
                prefix,
            },
            dir,
            owned: false,
        }
    }

    pub(crate) fn socket(&self) -> PathBuf {
        self.dir.join("socket")
    }
}

impl Drop for BenchRun {
    fn drop(&mut self) {
        if self.owned {
            // Files that cannot be deleted now do not change the results; their name tells the
            // next person that they are of a bench.
            cell_bus::wipe(&self.site).ok();
            std::fs::remove_dir_all(&self.dir).ok();
        }
    }
}

/// Words through which one process orders the next block from the other.
#[derive(Debug)]
pub(crate) struct Control(SharedWords);

/// One block of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    /// Index of the link.
    pub(crate) link: u64,
    /// Number of messages.
    pub(crate) count: u64,
}

impl Control {
    pub(crate) fn open(place: &BenchRun) -> Result<Self, BenchError> {
        SharedWords::open(&place.dir.join("control"), 4)
            .map(Self)
            .map_err(io("share its control words"))
    }

    fn word(&self, index: usize) -> &AtomicU64 {
        &self.0.words()[index]
    }

    /// Orders block number `number` (from 1 up) and waits until the other process has taken it.
    pub(crate) fn order(&self, number: u64, block: Block) -> Result<(), BenchError> {
        // The number last, with release order: a reader that sees it sees link and count.
        self.word(1).store(block.link, Ordering::Relaxed);
        self.word(2).store(block.count, Ordering::Relaxed);
        self.word(0).store(number, Ordering::Release);
        let end_ns = monotonic_ns() + PATIENCE_NS;
        while self.word(3).load(Ordering::Acquire) != number {
            if monotonic_ns() > end_ns {
                return Err(BenchError::Silent);
            }
            // Sleeping, as spinning here would compete with the other process on a single core.
            sleep_until(monotonic_ns() + 20_000);
        }
        Ok(())
    }

    /// Waits for block number `number`; `None` when `alive` returns false.
    pub(crate) fn await_order(&self, number: u64, alive: impl Fn() -> bool) -> Option<Block> {
        while self.word(0).load(Ordering::Acquire) != number {
            if !alive() {
                return None;
            }
            sleep_until(monotonic_ns() + 50_000);
        }
        let [link, count] = [1, 2].map(|index| self.word(index).load(Ordering::Relaxed));
        self.word(3).store(number, Ordering::Release);
        Some(Block { link, count })
    }
}

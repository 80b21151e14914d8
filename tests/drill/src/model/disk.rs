//! The file of the states of physics, and the thread that writes it.

use std::cell::RefCell;
use std::io;
use std::path::Path;
use std::rc::Rc;

use cell_bus::MemorySite;
use cell_rt::{Clock as _, MemoryDir, RecordFile};
use physics_proc::resume::Store;

use crate::plan::MS;

/// Name of the file of the newest state.
const FILE: &str = "physics.state";
/// Steps of a write: the new file, its head, its content, two renames.
pub(super) const STEPS: u64 = 5;

/// What the disk does, and the states on it.
#[derive(Clone, Debug)]
pub(super) struct Disk {
    dir: MemoryDir,
    file: RecordFile,
    inner: Rc<RefCell<Inner>>,
}

#[derive(Debug, Default)]
struct Inner {
    /// Tick of the newest state, and of the one before.
    tick: u64,
    older_tick: u64,
    pending: Option<Pending>,
    /// The writer is killed after so many steps of the next write.
    cut: Option<u64>,
    write_ns: u64,
}

#[derive(Debug)]
struct Pending {
    tick: u64,
    state: Vec<u8>,
    done_ns: u64,
}

impl Default for Disk {
    fn default() -> Self {
        let dir = MemoryDir::default();
        Self {
            file: RecordFile::in_memory(&dir, Path::new(FILE)),
            dir,
            inner: Rc::default(),
        }
    }
}

impl Disk {
    /// Whether writes fail from now on.
    pub(super) fn set_full(&self, full: bool) {
        self.dir.set_full(full);
    }

    /// Time of a write from now on.
    pub(super) fn set_write_ms(&self, ms: u64) {
        self.inner.borrow_mut().write_ns = ms * MS;
    }

    /// Kills the writer after so many steps of the next write.
    pub(super) fn cut_next(&self, steps: u64) {
        self.inner.borrow_mut().cut = Some(steps);
    }

    /// The steps after which the write that began is cut, if one has to be.
    pub(super) fn take_cut(&self) -> Option<u64> {
        let mut inner = self.inner.borrow_mut();
        inner.pending.as_ref()?;
        inner.cut.take()
    }

    /// Whether a write is running at `now_ns`.
    pub(super) fn is_writing(&self, now_ns: u64) -> bool {
        let inner = self.inner.borrow();
        inner.pending.as_ref().is_some_and(|of| now_ns < of.done_ns)
    }

    /// The writer is killed: of a write that is not finished at `now_ns` so many `steps` are done.
    pub(super) fn kill(&self, now_ns: u64, steps: u64) {
        self.finish(now_ns);
        let pending = self.inner.borrow_mut().pending.take();
        if let Some(pending) = pending {
            self.dir.effects().allow(steps);
            self.write(&pending).ok();
            self.dir.effects().allow(u64::MAX);
        }
    }

    /// Flips the bit of the newest state that `draw` chooses; its bytes, if there is one.
    pub(super) fn flip(&self, draw: u64) -> Option<Vec<u8>> {
        self.dir.flip(Path::new(FILE), draw)
    }

    /// Whether the file of the newest state has these bytes.
    pub(super) fn still_has(&self, bytes: &[u8]) -> bool {
        self.dir.read(Path::new(FILE)).as_deref() == Some(bytes)
    }

    /// Tick of the newest state; 0 where the one before has the same, so that it says nothing.
    pub(super) fn tick(&self) -> u64 {
        let inner = self.inner.borrow();
        if inner.tick == inner.older_tick {
            0
        } else {
            inner.tick
        }
    }

    /// The store of a start of physics.
    pub(super) fn store(&self, site: &MemorySite) -> DiskStore {
        DiskStore {
            disk: self.clone(),
            site: site.clone(),
        }
    }

    fn write(&self, pending: &Pending) -> Result<(), String> {
        let before = self.dir.effects().left();
        let written = self.file.write(&pending.state);
        let steps = before - self.dir.effects().left();
        let mut inner = self.inner.borrow_mut();
        // Without the last step a reader completes the write.
        if written.is_ok() && steps >= STEPS - 1 {
            inner.older_tick = inner.tick;
            inner.tick = pending.tick;
        }
        written.map_err(|error| error.to_string())
    }

    /// The result of the write that is running, once it is done.
    fn finish(&self, now_ns: u64) -> Option<(u64, Result<(), String>)> {
        let mut inner = self.inner.borrow_mut();
        let done = inner.pending.take_if(|pending| pending.done_ns <= now_ns)?;
        drop(inner);
        Some((done.tick, self.write(&done)))
    }
}

/// See [`Disk::store`].
#[derive(Debug)]
pub(super) struct DiskStore {
    disk: Disk,
    site: MemorySite,
}

impl Store for DiskStore {
    fn read(&self) -> io::Result<Option<Vec<u8>>> {
        self.disk.file.read()
    }

    fn read_older(&self) -> io::Result<Option<Vec<u8>>> {
        self.disk.file.read_older()
    }

    fn replace_by_older(&self) -> io::Result<()> {
        let mut inner = self.disk.inner.borrow_mut();
        inner.tick = inner.older_tick;
        self.disk.file.replace_by_older()
    }

    fn name(&self) -> String {
        FILE.to_owned()
    }

    fn is_idle(&self) -> bool {
        self.disk.inner.borrow().pending.is_none()
    }

    fn write(&mut self, tick: u64, fill: impl FnOnce(&mut Vec<u8>)) {
        let mut state = Vec::new();
        fill(&mut state);
        let mut inner = self.disk.inner.borrow_mut();
        // To hand a state over is an effect: a physics that is killed before it has not.
        if self.site.effects().happens() {
            let done_ns = self.site.now_ns() + inner.write_ns;
            inner.pending = Some(Pending {
                tick,
                state,
                done_ns,
            });
        }
    }

    fn result(&mut self) -> Option<(u64, Result<(), String>)> {
        let now_ns = self.site.now_ns();
        self.disk.finish(now_ns)
    }

    fn wait(&mut self) {
        // Lockstep has no clock that would show how long it waited.
        let mut inner = self.disk.inner.borrow_mut();
        if let Some(pending) = &mut inner.pending {
            pending.done_ns = 0;
        }
    }
}

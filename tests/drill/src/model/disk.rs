//! The file of the states of physics, and the thread that writes it.

use std::cell::RefCell;
use std::io;
use std::rc::Rc;

use cell_bus::MemorySite;
use cell_rt::Clock as _;
use physics_proc::resume::Store;

use crate::plan::MS;

/// What the disk does, and the states on it.
#[derive(Clone, Debug, Default)]
pub(super) struct Disk(Rc<RefCell<Inner>>);

#[derive(Debug, Default)]
struct Inner {
    /// Newest first.
    states: Vec<Rc<Vec<u8>>>,
    pending: Option<Pending>,
    full: bool,
    write_ns: u64,
}

#[derive(Debug)]
struct Pending {
    tick: u64,
    state: Vec<u8>,
    done_ns: u64,
}

impl Disk {
    /// Whether writes fail from now on.
    pub(super) fn set_full(&self, full: bool) {
        self.0.borrow_mut().full = full;
    }

    /// Time of a write from now on.
    pub(super) fn set_write_ms(&self, ms: u64) {
        self.0.borrow_mut().write_ns = ms * MS;
    }

    /// The writer is killed: what it had not finished at `now_ns` is gone.
    pub(super) fn cut(&self, now_ns: u64) {
        let mut inner = self.0.borrow_mut();
        inner.finish(now_ns);
        inner.pending = None;
    }

    /// The store of a start of physics.
    pub(super) fn store(&self, site: &MemorySite) -> DiskStore {
        DiskStore {
            disk: self.clone(),
            site: site.clone(),
        }
    }
}

impl Inner {
    /// The result of the write that is running, once it is done.
    fn finish(&mut self, now_ns: u64) -> Option<(u64, Result<(), String>)> {
        let done = self.pending.take_if(|pending| pending.done_ns <= now_ns)?;
        if self.full {
            return Some((done.tick, Err("No space left on device".to_owned())));
        }
        self.states.insert(0, Rc::new(done.state));
        self.states.truncate(2);
        Some((done.tick, Ok(())))
    }
}

/// See [`Disk::store`].
#[derive(Debug)]
pub(super) struct DiskStore {
    disk: Disk,
    site: MemorySite,
}

impl DiskStore {
    fn at(&self, place: usize) -> Option<Vec<u8>> {
        let inner = self.disk.0.borrow();
        inner.states.get(place).map(|state| state.as_ref().clone())
    }
}

impl Store for DiskStore {
    fn read(&self) -> io::Result<Option<Vec<u8>>> {
        Ok(self.at(0))
    }

    fn read_older(&self) -> io::Result<Option<Vec<u8>>> {
        Ok(self.at(1))
    }

    fn name(&self) -> String {
        "physics.state".to_owned()
    }

    fn is_idle(&self) -> bool {
        self.disk.0.borrow().pending.is_none()
    }

    fn write(&mut self, tick: u64, fill: impl FnOnce(&mut Vec<u8>)) {
        let mut state = Vec::new();
        fill(&mut state);
        let mut inner = self.disk.0.borrow_mut();
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
        self.disk.0.borrow_mut().finish(now_ns)
    }

    fn wait(&mut self) {
        // Lockstep has no clock that would show how long it waited.
        let mut inner = self.disk.0.borrow_mut();
        if let Some(pending) = &mut inner.pending {
            pending.done_ns = 0;
        }
    }
}

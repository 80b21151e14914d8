//! A turn that is interrupted between two of its effects, as by the scheduler.

use core::fmt;
use std::cell::{Cell, RefCell};
use std::rc::Rc;

/// An effect that has not happened yet.
pub struct Kept(Box<dyn FnOnce()>);

impl Kept {
    /// Lets it happen.
    pub fn happen(self) {
        (self.0)();
    }
}

impl fmt::Debug for Kept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Kept")
    }
}

/// Where the present turn is interrupted.
#[derive(Debug)]
pub(super) struct Cut {
    /// Effects before the interruption; `None` for a turn that is not interrupted.
    left: Cell<Option<u64>>,
    gap_ns: Cell<u64>,
    kept: RefCell<Vec<Kept>>,
    now_ns: Rc<Cell<u64>>,
}

impl Cut {
    pub(super) fn new(now_ns: &Rc<Cell<u64>>) -> Self {
        Self {
            left: Cell::new(None),
            gap_ns: Cell::new(0),
            kept: RefCell::default(),
            now_ns: now_ns.clone(),
        }
    }

    pub(super) fn begin(&self, effects: u64, gap_ns: u64) {
        self.left.set(Some(effects));
        self.gap_ns.set(gap_ns);
    }

    pub(super) fn end(&self) -> Vec<Kept> {
        self.left.set(None);
        self.kept.take()
    }

    /// Lets `effect` happen now, or keeps it.
    pub(super) fn pass(&self, effect: impl FnOnce() + 'static) {
        match self.left.get() {
            None => effect(),
            Some(0) => {
                let mut kept = self.kept.borrow_mut();
                // What the turn does from here on is later, also by its clock.
                if kept.is_empty() {
                    self.now_ns.update(|now_ns| now_ns + self.gap_ns.get());
                }
                kept.push(Kept(Box::new(effect)));
            }
            Some(left) => {
                self.left.set(Some(left - 1));
                effect();
            }
        }
    }
}

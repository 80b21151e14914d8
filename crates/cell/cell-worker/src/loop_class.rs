//! Scheduling class of a loop whose cell changes between real time and lockstep.

use cell_rt::priority;

use crate::Start;

/// A loop has `SCHED_FIFO`, where that was granted, in real time only: in lockstep it
/// would take a core from all others.
#[derive(Debug)]
pub struct LoopClass {
    priority: i32,
    fifo: bool,
    lockstep: bool,
}

// Starts as real time, which is the class that the thread was given at its start.
impl LoopClass {
    /// Of the calling thread, which has `SCHED_FIFO` at `priority` if `fifo`.
    pub fn new(start: &Start, priority: i32, fifo: bool) -> Self {
        Self {
            priority,
            // The thread of a model runs all processes.
            fifo: fifo && !start.is_modelled(),
            lockstep: false,
        }
    }

    /// Changes the class if simulated time passes in another way than before.
    pub fn follow(&mut self, lockstep: bool) {
        // No system call in the cycle unless the mode has changed.
        if std::mem::replace(&mut self.lockstep, lockstep) == lockstep || !self.fifo {
            return;
        }
        let changed = if lockstep {
            priority::set_other()
        } else {
            priority::set_fifo(self.priority)
        };
        // The old class only costs others their core, so the loop continues.
        if let Err(error) = changed {
            crate::warn(format_args!(
                "the scheduling class was not changed: {error}"
            ));
        }
    }
}

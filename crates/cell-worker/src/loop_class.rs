//! Scheduling class of a loop whose cell changes between real time and lockstep.

use cell_rt::priority;

/// A loop has `SCHED_FIFO`, where that was granted, in real time only: in lockstep it
/// would take a core from all others.
#[derive(Debug)]
pub struct LoopClass {
    priority: i32,
    fifo: bool,
    lockstep: bool,
}

impl LoopClass {
    /// Of the calling thread, which has `SCHED_FIFO` at `priority` if `fifo`.
    pub fn new(priority: i32, fifo: bool) -> Self {
        Self {
            priority,
            fifo,
            lockstep: false,
        }
    }

    /// Changes the class where simulated time passes in another way than before.
    pub fn follow(&mut self, lockstep: bool) {
        if std::mem::replace(&mut self.lockstep, lockstep) == lockstep || !self.fifo {
            return;
        }
        let changed = if lockstep {
            priority::set_other()
        } else {
            priority::set_fifo(self.priority)
        };
        if let Err(error) = changed {
            crate::warn(format_args!(
                "the scheduling class was not changed: {error}"
            ));
        }
    }
}

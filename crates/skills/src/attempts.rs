//! What went wrong with an object, and when it has gone wrong too often.

use behavior::Status;
use robocell_task::{PolicyTime, TraceEvent};

use crate::world::World;

/// An object out of reach is waited for this long; the operator may bring it
/// back (s).
const REACH_PATIENCE_S: f64 = 10.0;

impl World<'_> {
    /// Counts a drop, and logs it.
    pub fn note_drop(&mut self, object: usize) {
        self.job.counters.drops += 1;
        let setup = self.setup;
        let name = setup.object_name(object);
        self.out.event(
            TraceEvent::Drop,
            format_args!("[drop] {name} left the gripper"),
        );
    }

    /// Counts that an object moved before it was gripped, and logs it.
    pub fn note_resync(&mut self, object: usize) {
        self.job.counters.resyncs += 1;
        let setup = self.setup;
        let name = setup.object_name(object);
        self.out
            .event(TraceEvent::Resync, format_args!("[resync] {name} moved"));
    }

    /// Counts a failed pick-up of an object. After `most` in a row the job fails
    /// with `reason`.
    pub fn count_failed_pick(&mut self, object: usize, most: u32, reason: &str) {
        let Some(attempts) = self.job.attempts_mut(object) else {
            return;
        };
        attempts.pick += 1;
        if attempts.pick >= most {
            let setup = self.setup;
            let name = setup.object_name(object);
            self.fail(reason, format_args!("{name} cannot be gripped"));
        }
    }

    /// Counts that an object did not stay where it was set down. After `most` in a
    /// row the job fails with `reason`.
    pub fn count_failed_place(&mut self, object: usize, most: u32, reason: &str) {
        let Some(attempts) = self.job.attempts_mut(object) else {
            return;
        };
        attempts.place += 1;
        if attempts.place >= most {
            let setup = self.setup;
            let name = setup.object_name(object);
            self.fail(reason, format_args!("{name} does not stay in its place"));
        }
    }

    /// Waits for an object that is out of reach; it fails, and the job with
    /// `reason`, when it stays there. `Job::unreachable_since` has to be emptied
    /// when the object is within reach again.
    pub fn wait_for_reach(&mut self, object: usize, reason: &str) -> Status {
        let now = self.now();
        let setup = self.setup;
        let name = setup.object_name(object);
        let Some(since) = self.job.unreachable_since else {
            self.out.log(format_args!("[wait] {name} is out of reach"));
            self.job.unreachable_since = Some(now);
            return Status::Running;
        };
        if now.since(since) < PolicyTime::from_seconds(REACH_PATIENCE_S) {
            return Status::Running;
        }
        self.fail(reason, format_args!("{name} stayed out of reach"));
        Status::Failure
    }
}

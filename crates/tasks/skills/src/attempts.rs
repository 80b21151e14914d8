//! Failures with objects, and the end of a job after too many of them.

use behavior::Status;
use robocell_task::{PolicyTime, TraceEvent};

use crate::world::World;

/// Time for which an object out of reach is waited for (s); the operator may bring it back.
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

    /// Counts a failed pick-up of an object. After `most` in a row the job fails with `reason`.
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

    /// Counts a set-down whose object did not stay in place. After `most` in a row the job
    /// fails with `reason`.
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

    /// Waits for an object that is out of reach. Returns failure, and fails the job with
    /// `reason`, if it stays there. `Job::unreachable_since` has to be cleared when the object
    /// is within reach again.
    pub fn wait_for_reach(&mut self, object: usize, reason: &str) -> Status {
        let now = self.now();
        let setup = self.setup;
        let name = setup.object_name(object);
        // The start of the wait is in the job, not in the skill: another skill continues the
        // same wait.
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

//! What a skill remembers while it is under way.

use robocell_task::PolicyTime;
use robocell_task::job::Placement;
use serde::{Deserialize, Serialize};

/// One motion or grip under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Key of its goal; 0 before it began.
    pub key: u64,
    /// When it began.
    pub began: PolicyTime,
    /// Since when its end condition holds.
    pub settled: Option<PolicyTime>,
    /// TCP position when it began (m).
    pub from: [f64; 3],
}

impl Step {
    /// Whether it has begun.
    pub fn has_begun(&self) -> bool {
        self.key != 0
    }

    /// Whether `holds` has been true without a break for `settle`, now included.
    pub fn settles(&mut self, holds: bool, settle: PolicyTime, now: PolicyTime) -> bool {
        self.settled = match (holds, self.settled) {
            (false, _) => None,
            (true, since) => since.or(Some(now)),
        };
        self.settled.is_some_and(|since| now.since(since) >= settle)
    }
}

/// The memory of one skill: plain data, part of the checkpoint. The default is
/// the memory of a skill that did not begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// The motion or grip under way.
    pub step: Step,
    /// Which part of a skill with several parts is under way.
    pub stage: u8,
    /// Where the object was at first, or is going to; the skill says which.
    pub anchor: Option<Placement>,
    /// Slot of a place, chosen at the start.
    pub slot: Option<u16>,
    /// Decisions in a row in which the object was not in the gripper.
    pub missed: u32,
}

impl Progress {
    /// Begins the next part.
    pub fn next(&mut self) {
        self.go_to(self.stage.saturating_add(1));
    }

    /// Begins the part of that number.
    pub fn go_to(&mut self, stage: u8) {
        self.stage = stage;
        self.step = Step::default();
        self.missed = 0;
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_decision_off_the_target_restarts_the_settle_timer() {
        let settle = PolicyTime::from_ticks(250);
        let mut step = Step::default();
        let mut settles = |tick: u64| {
            let there = tick >= 500 && tick != 700;
            step.settles(there, settle, PolicyTime::from_ticks(tick))
        };
        let settled = (0..2000).step_by(10).find(|tick| settles(*tick));
        assert_eq!(settled, Some(960));
    }
}

//! The memory of a skill while it is in progress.

use ipc_types::Pose;
use nalgebra::Vector3;
use robocell_task::PolicyTime;
use robocell_task::job::Placement;
use serde::{Deserialize, Serialize};

use crate::geometry;
use crate::pose::KeptPose;

/// A tool that moves and turns by less than this within [`REST`] is at rest (m, rad).
// A cup that locks to an object while the arm is 0.9 mm before its goal, at 9 mm/s, is pushed into
// the object with more than its limit of 50 N within 18 ms.
const STILL_M: f64 = 0.0003;
const STILL_RAD: f64 = 0.003;
/// See [`STILL_M`].
pub(crate) const REST: PolicyTime = PolicyTime::from_ticks(150);

/// A motion or grip in progress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Key of its goal; 0 before it starts.
    pub key: u64,
    /// Time of its start.
    pub began: PolicyTime,
    /// Time since which its end condition holds.
    pub settled: Option<PolicyTime>,
    /// TCP position at its start (m).
    pub from: [f64; 3],
    /// TCP near which the tool has been since it came to rest.
    pub still: Option<KeptPose>,
    /// Suction that was switched on in it.
    pub switched: Option<Switched>,
}

/// Suction that was switched on, with what the cup had counted before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Switched {
    /// When.
    pub at: PolicyTime,
    /// Grips that broke.
    pub breaks: u32,
    /// Attempts that attached nothing.
    pub refusals: u32,
}

impl Step {
    /// Whether it has started.
    pub fn has_begun(&self) -> bool {
        self.key != 0
    }

    /// Whether `holds` has been true without a break for `settle`, this decision included.
    pub fn settles(&mut self, holds: bool, settle: PolicyTime, now: PolicyTime) -> bool {
        self.settled = match (holds, self.settled) {
            (false, _) => None,
            (true, since) => since.or(Some(now)),
        };
        self.settled.is_some_and(|since| now.since(since) >= settle)
    }

    /// Whether the tool is where it was at the decision before, within 0.3 mm of the TCP at which it
    /// came to rest. With [`Step::settles`] for 150 ms it is slower than 2 mm/s.
    pub fn is_still(&mut self, tcp: &Pose) -> bool {
        let still = self.still.is_some_and(|still| {
            let off = Vector3::from(tcp.position) - Vector3::from(still.position);
            let turned = geometry::angle_between(tcp.orientation_wxyz, still.orientation_wxyz);
            off.norm() < STILL_M && turned < STILL_RAD
        });
        if !still {
            self.still = Some((*tcp).into());
        }
        still
    }
}

/// The memory of one skill: plain data, part of the checkpoint. The default is that of a skill
/// before its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// The motion or grip in progress.
    pub step: Step,
    /// The part of a skill with several parts that is in progress.
    pub stage: u8,
    /// First position of the object, or its destination; the skill defines which.
    pub anchor: Option<Placement>,
    /// TCP of a pick, in the frame of the object's placement; of a set-down, in the world frame.
    pub tool: Option<KeptPose>,
    /// Distance of the fingers when they open (m); 0 for as far as they open.
    pub open_width_m: f64,
    /// Since when it waits for a body that blocks it.
    pub waits: Option<PolicyTime>,
    /// Another object in the gripper, which is brought back first.
    pub put_back: Option<u16>,
    /// Decisions in a row in which the object was not in the gripper.
    pub missed: u32,
}

impl Progress {
    /// Starts the next part.
    pub fn next(&mut self) {
        self.go_to(self.stage.saturating_add(1));
    }

    /// Starts the part with this number.
    pub fn go_to(&mut self, stage: u8) {
        self.stage = stage;
        self.step = Step::default();
        self.missed = 0;
    }

    /// Resets the memory.
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

//! What changed about a suction grip since the last decision, and why.

use ipc_types::GripperState;
use ipc_types::equipment::{BreakCause, BreakLimit, SuctionRefusal};
use serde::{Deserialize, Serialize};

/// The gripper as it was at the last decision; part of a policy's record, so
/// that what happened while there was no decision is still a change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GripMemory {
    /// Something was attached.
    attached: bool,
    breaks: u32,
    refusals: u32,
    seen: bool,
}

/// What changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "independent events of one decision"
)]
pub struct GripChange {
    /// Something is attached now and was not.
    pub attached: bool,
    /// Something was attached and is not any more, or broke off in between.
    pub detached: bool,
    /// The grip broke at a limit.
    pub broken: bool,
    /// Suction was switched on and attached nothing.
    pub refused: bool,
}

impl GripMemory {
    /// Takes the gripper of a new decision. The first one sets the counters, and
    /// reports what is attached already.
    pub fn update(&mut self, gripper: &GripperState) -> GripChange {
        let attached = gripper.attached == 1;
        let counted = |now: u32, before: u32| self.seen && now > before;
        let broken = counted(gripper.breaks, self.breaks);
        let change = GripChange {
            // Broken off and attached again between two decisions is both.
            attached: attached && (!self.attached || broken),
            detached: (self.attached && !attached) || broken,
            broken,
            refused: counted(gripper.refusals, self.refusals),
        };
        *self = Self {
            attached,
            breaks: gripper.breaks,
            refusals: gripper.refusals,
            seen: true,
        };
        change
    }

    /// Whether something was attached at the last decision.
    pub fn attached(&self) -> bool {
        self.attached
    }
}

/// Which limit broke the grip last, for the log.
pub fn break_limit(gripper: &GripperState) -> &'static str {
    match BreakLimit::from_code(gripper.break_limit) {
        Some(BreakLimit::Force) => "force",
        Some(BreakLimit::Torque) => "torque",
        _ => "no",
    }
}

/// What exceeded it, for the log.
pub fn break_cause(gripper: &GripperState) -> &'static str {
    match BreakCause::from_code(gripper.break_cause) {
        Some(BreakCause::Weight) => "weight",
        Some(BreakCause::Impulse) => "impulse",
        _ => "nothing known",
    }
}

/// Why suction attached nothing last, for the log.
pub fn refusal(gripper: &GripperState) -> &'static str {
    match SuctionRefusal::from_code(gripper.refusal) {
        Some(SuctionRefusal::NothingThere) => "nothing there",
        Some(SuctionRefusal::NotMovable) => "the object cannot be moved",
        Some(SuctionRefusal::TooOblique) => "too oblique",
        _ => "nothing attached",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire as _;

    fn gripper(attached: u32, breaks: u32, refusals: u32) -> GripperState {
        GripperState {
            attached,
            breaks,
            refusals,
            ..GripperState::zeroed()
        }
    }

    fn events(change: GripChange) -> String {
        let named = [
            ('A', change.attached),
            ('D', change.detached),
            ('B', change.broken),
            ('R', change.refused),
        ];
        named.iter().filter(|n| n.1).map(|n| n.0).collect()
    }

    #[test]
    fn each_event_is_reported_once() {
        let mut memory = GripMemory::default();
        let mut see = |a, b, r| events(memory.update(&gripper(a, b, r)));
        assert_eq!(see(0, 4, 7), "", "old counts are no news");
        assert_eq!(see(0, 4, 8), "R");
        assert_eq!(see(1, 4, 8), "A");
        assert_eq!(see(1, 4, 8), "");
        assert_eq!(see(0, 5, 8), "DB");
        assert_eq!(see(0, 5, 8), "");
        assert_eq!(see(1, 5, 8), "A");
        assert_eq!(see(0, 5, 8), "D", "let go on request");
    }

    #[test]
    fn what_happened_between_two_decisions_is_not_lost() {
        let mut memory = GripMemory::default();
        let mut see = |a, b| events(memory.update(&gripper(a, b, 0)));
        assert_eq!(see(0, 0), "");
        assert_eq!(see(0, 1), "DB", "attached and broken off");
        assert_eq!(see(1, 1), "A");
        assert_eq!(see(1, 2), "ADB", "broken off and attached again");
        assert_eq!(see(1, 0), "", "a new generation of physics");
        assert_eq!(events(GripMemory::default().update(&gripper(1, 3, 3))), "A");
    }
}

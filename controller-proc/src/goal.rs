//! The latched goal: the newest goal of the task, kept when the task is silent.

use ipc_types::decision::{GoalKind, GripperGoal};
use ipc_types::{ArmGoal, Decision, Pose, Wire};

use crate::checkpoint::{CheckpointError, Codec, damaged};

/// The goal of an arm.
#[derive(Clone, Copy, Debug)]
pub struct GoalLatch {
    goal: ArmGoal,
    generation: u32,
    seq: u64,
    decision_tick: Option<u64>,
    gripper: GripperGoal,
}

impl Default for GoalLatch {
    fn default() -> Self {
        let mut goal = ArmGoal::zeroed();
        goal.target = Pose::IDENTITY;
        Self {
            goal,
            generation: 0,
            seq: 0,
            decision_tick: None,
            gripper: GripperGoal::Keep,
        }
    }
}

impl GoalLatch {
    /// Takes the goal of `arm` from a decision. A goal is absolute, so a repeated one, also
    /// from another generation of the task, changes nothing.
    pub fn take(&mut self, decision: &Decision, arm: usize) {
        let count = decision.arm_count as usize;
        let Some(goal) = decision.goals.get(arm).filter(|_| arm < count) else {
            return;
        };
        let open_width = self.goal.open_width;
        self.goal = *goal;
        self.generation = decision.header.generation;
        self.seq = decision.header.seq;
        self.decision_tick = Some(decision.header.tick);
        match GripperGoal::from_code(goal.gripper) {
            // Keep is not a command: the hand continues with its last one.
            None | Some(GripperGoal::Keep) => self.goal.open_width = open_width,
            Some(gripper) => self.gripper = gripper,
        }
    }

    /// Writes or reads all of it.
    pub(crate) fn checkpoint(&mut self, codec: &mut Codec<'_>) -> Result<(), CheckpointError> {
        let mut bytes = [0; size_of::<ArmGoal>()];
        bytes.copy_from_slice(self.goal.as_bytes());
        codec.bytes(&mut bytes)?;
        // The array has the length of the type.
        self.goal = ArmGoal::from_bytes(&bytes).unwrap_or(self.goal);
        codec.u32(&mut self.generation)?;
        codec.u64(&mut self.seq)?;
        codec.option("latch", &mut self.decision_tick, Codec::u64)?;
        let mut gripper = self.gripper.code();
        codec.u32(&mut gripper)?;
        self.gripper = GripperGoal::from_code(gripper)
            .ok_or(damaged("latched gripper goal", u64::from(gripper)))?;
        Ok(())
    }

    /// The goal.
    pub fn goal(&self) -> &ArmGoal {
        &self.goal
    }

    /// Its kind; [`GoalKind::Hold`] before the first decision.
    pub fn kind(&self) -> GoalKind {
        GoalKind::from_code(self.goal.kind).unwrap_or_default()
    }

    /// The last command of the gripper; Keep before the first.
    pub fn gripper(&self) -> GripperGoal {
        self.gripper
    }

    /// Generation of the task that sent the goal.
    pub fn generation(&self) -> u32 {
        self.generation
    }

    /// Sequence number of the newest decision.
    pub fn seq(&self) -> u64 {
        self.seq
    }

    /// Tick of the newest decision, `None` before the first.
    pub fn decision_tick(&self) -> Option<u64> {
        self.decision_tick
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decision(goal_id: u64, gripper: GripperGoal) -> Decision {
        let mut decision = Decision::zeroed();
        decision.arm_count = 1;
        decision.goals[0].goal_id = goal_id;
        decision.goals[0].gripper = gripper.code();
        decision
    }

    #[test]
    fn keep_keeps_the_gripper_goal() {
        let mut latch = GoalLatch::default();
        assert_eq!(latch.gripper(), GripperGoal::Keep);
        latch.take(&decision(1, GripperGoal::Close), 0);
        latch.take(&decision(2, GripperGoal::Keep), 0);
        assert_eq!(
            (latch.goal().goal_id, latch.gripper()),
            (2, GripperGoal::Close)
        );
        // A decision for fewer arms has no goal for this one.
        latch.take(&decision(3, GripperGoal::Open), 1);
        assert_eq!(
            (latch.goal().goal_id, latch.gripper()),
            (2, GripperGoal::Close)
        );
    }
}

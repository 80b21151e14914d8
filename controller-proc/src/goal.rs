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
    /// Decisions about earlier states are about another scene.
    first_tick: u64,
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
            first_tick: 0,
        }
    }
}

impl GoalLatch {
    /// No goal, in a scene whose first state is that of `first_tick`.
    pub fn since(first_tick: u64) -> Self {
        Self {
            first_tick,
            ..Self::default()
        }
    }

    /// Takes the goal of `arm` from a decision, unless that is about the scene before. A goal is
    /// absolute, so a repeated one, also from another generation of the task, changes nothing.
    pub fn take(&mut self, decision: &Decision, arm: usize) {
        let count = decision.arm_count as usize;
        let is_of_scene = decision.header.tick >= self.first_tick;
        let goal = decision.goals.get(arm);
        let Some(goal) = goal.filter(|_| arm < count && is_of_scene) else {
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
        codec.u64(&mut self.first_tick)?;
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
    fn a_decision_about_a_state_before_the_scene_gives_no_goal() {
        let mut latch = GoalLatch::since(4501);
        let mut old = decision(7, GripperGoal::Close);
        old.header.tick = 4500;
        latch.take(&old, 0);
        let (goal, tick) = (latch.goal().goal_id, latch.decision_tick());
        assert_eq!((goal, latch.gripper(), tick), (0, GripperGoal::Keep, None));
        old.header.tick = 4501;
        latch.take(&old, 0);
        assert_eq!(
            (latch.goal().goal_id, latch.decision_tick()),
            (7, Some(4501))
        );
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

//! A task without a job: goals for all arms in turn, and a memory of any size.
//!
//! Its decisions are cheap, and say how often it has decided: a checkpoint that is lost, old, or
//! of another physics shows in the goals and in the list of placed objects.

use cell_model::Cell;
use ipc_types::decision::GoalKind;
use ipc_types::{MAX_JOINTS, Pose, Text};
use robocell_task::{ArmIntent, Job, Kind, Observation, Output, Policy, Settings, boxed};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::plan::noise;

/// Its name on the command line.
pub(crate) const POLICY: &str = "stub";
/// Number of `robocell_controller`'s joint-space PD controller.
const JOINT_PD: u32 = 1;
/// Decisions between two goals: a third of a second, so that the arms are mostly moving.
const GOAL_DECISIONS: u64 = 33;

/// `[task]` with `kind = "drill"`.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct StubTask {
    /// Bytes of its memory besides the counts.
    memory: u32,
    /// Goals are poses.
    poses: bool,
    /// It fails with this decision; 0: never.
    #[serde(default)]
    fails_at: u64,
}

impl Settings for StubTask {}

/// The kind of task.
pub(crate) fn kind() -> Kind<impl Settings> {
    Kind::<StubTask>::new(crate::scene::NAME)
        .policy(POLICY, |task, cell| Ok(boxed(Stub::new(*task, cell))))
}

struct Stub {
    task: StubTask,
    /// Home and half of the free range of each joint, by arm (rad or m).
    arms: Vec<Vec<(f64, f64)>>,
    objects: u64,
}

#[derive(Default, Serialize, Deserialize)]
struct Memory {
    decisions: u64,
    /// Every byte is the number of its decision, modulo 256.
    ballast: Vec<u8>,
}

impl Stub {
    fn new(task: StubTask, cell: &Cell) -> Self {
        let arms = cell.arms.iter().map(|arm| {
            let joints = arm.robot.arm_specs().zip(&arm.home);
            let room = |(spec, home): (&cell_model::JointSpec, &f64)| {
                let room = (spec.upper - home).min(home - spec.lower).min(1.0);
                (*home, 0.8 * room.max(0.0))
            };
            joints.map(room).collect()
        });
        Self {
            task,
            arms: arms.collect(),
            objects: cell.objects.len() as u64,
        }
    }

    fn posture(&self, arm: usize, goal: u64) -> [f64; MAX_JOINTS] {
        let mut posture = [0.0; MAX_JOINTS];
        for (joint, (out, (home, half))) in posture.iter_mut().zip(&self.arms[arm]).enumerate() {
            let unit = noise(goal, arm as u64, joint as u64) % 2001;
            *out = home + half * (unit as f64 / 1000.0 - 1.0);
        }
        posture
    }
}

impl Policy for Stub {
    type Memory = Memory;

    fn decide(
        &self,
        memory: &mut Memory,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        memory.decisions += 1;
        job.counters.resyncs = u32::try_from(memory.decisions).unwrap_or(u32::MAX);
        let byte = memory.decisions.to_le_bytes()[0];
        memory.ballast.resize(self.task.memory as usize, byte);
        let goal = 1 + memory.decisions / GOAL_DECISIONS;
        out.phase = Text::new(["A", "B", "C", "D"][usize::try_from(goal % 4).unwrap_or(0)]);
        // One more object counts as placed with each goal.
        while (job.placed.len() as u64) < goal.min(self.objects) {
            job.placed
                .push(u32::try_from(job.placed.len()).unwrap_or(0));
        }
        if memory.decisions == self.task.fails_at {
            job.fail("drawn");
        }
        for arm in 0..self.arms.len() {
            let intent = if self.task.poses {
                ArmIntent::pose(goal, target(observation, out, arm, goal))
            } else {
                ArmIntent {
                    kind: GoalKind::Joints,
                    key: goal,
                    selector: JOINT_PD,
                    posture: Some(self.posture(arm, goal)),
                    ..ArmIntent::default()
                }
            };
            out.arm(arm, intent);
        }
    }
}

/// A place near the tool where goal number `goal` began.
fn target(observation: &Observation<'_>, out: &Output, arm: usize, goal: u64) -> Pose {
    if let Some(old) = out.previous(arm).filter(|old| old.key == goal) {
        return old.target;
    }
    let mut target = observation.tcp(arm).unwrap_or(Pose::IDENTITY);
    for (axis, out) in target.position.iter_mut().enumerate() {
        let unit = noise(goal, arm as u64, 100 + axis as u64) % 2001;
        *out += 0.15 * (unit as f64 / 1000.0 - 1.0);
    }
    target
}

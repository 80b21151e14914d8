//! Actions at the rate of a learned policy.
//!
//! A data set has one action for each of its frames, in numbers of 32 bits. These numbers give
//! an episode again, to the bit, only if exactly they were executed: goals are rounded before
//! they are sent, and held until the next frame.

use cell_run::spec::RunSpec;
use ipc_types::decision::{GoalKind, GripperGoal, Outcome};
use ipc_types::{ArmGoal, DECISION_TICKS, Decision, Header, Pose, Wire};

/// Decisions in a second.
const DECISIONS_HZ: u32 = 100;

/// A rate that is not one of a whole number of decisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a rate of {0} Hz; 1, 2, 4, 5, 10, 20, 25, 50 and 100 are allowed, since a task decides 100 times a second"
)]
pub struct RateError(u32);

/// Holds the goals of a task for the period of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hold {
    /// Ticks of an action.
    period: u64,
}

impl Hold {
    /// For actions at `rate_hz`.
    ///
    /// # Errors
    /// For a rate at which an action does not take a whole number of decisions.
    pub fn new(rate_hz: u32) -> Result<Self, RateError> {
        if rate_hz == 0 || !DECISIONS_HZ.is_multiple_of(rate_hz) {
            return Err(RateError(rate_hz));
        }
        let period = DECISION_TICKS * u64::from(DECISIONS_HZ / rate_hz);
        Ok(Self { period })
    }

    /// As the run file has it; `None` for every decision.
    pub(crate) fn of(spec: &RunSpec) -> Result<Option<Self>, RateError> {
        spec.action_hz.map(Self::new).transpose()
    }

    /// Whether an action begins at `tick`.
    pub fn begins(self, tick: u64) -> bool {
        tick.is_multiple_of(self.period)
    }

    /// Number of the action at `tick`, from 0.
    pub fn action(self, tick: u64) -> u64 {
        tick / self.period
    }

    /// Changes what the task decided at `tick` to the action in force; `before` is the decision
    /// before it.
    pub(crate) fn apply(self, tick: u64, before: &Decision, decision: &mut Decision) {
        if self.begins(tick) {
            decision.goals.iter_mut().for_each(round);
            return;
        }
        // The task still decides, on each observation; only the decision at the start of an action
        // is executed.
        let header = decision.header;
        *decision = *before;
        decision.header = header;
    }
}

/// Rounds all numbers of a goal to those of 32 bits.
fn round(goal: &mut ArmGoal) {
    let target = &mut goal.target;
    let numbers = target.position.iter_mut();
    let numbers = numbers.chain(&mut target.orientation_wxyz);
    let numbers = numbers.chain(&mut goal.posture).chain(&mut goal.approach);
    let single = [
        &mut goal.grip_force,
        &mut goal.open_width,
        &mut goal.approach_std_dev,
    ];
    for number in numbers.chain(single) {
        *number = f64::from(nearest(*number));
    }
}

#[allow(clippy::cast_possible_truncation, reason = "rounds")]
fn nearest(number: f64) -> f32 {
    number as f32
}

/// Numbers of the action of an arm: position of the TCP in the world frame (m), orientation
/// (w x y z), gripper.
pub const NUMBERS: usize = 8;

/// Gripper of an action: an arm of a data set opens, keeps its command, or closes.
const OPEN: f32 = 0.0;
const KEEP: f32 = 0.5;
const CLOSE: f32 = 1.0;

/// The goal of an arm as an action. An arm that holds has all zeros besides the gripper.
///
/// # Errors
/// Returns the name of a field that an action cannot say.
pub fn action_of(goal: &ArmGoal) -> Result<[f32; NUMBERS], &'static str> {
    let said = goal_of(&numbers_of(goal)?, goal.grip_force);
    let said = ArmGoal {
        goal_id: goal.goal_id,
        // Of a goal to hold it is not read.
        target: if goal.kind == GoalKind::Hold.code() {
            goal.target
        } else {
            said.target
        },
        ..said
    };
    // Everything else has to be what a goal has by default.
    match first_difference(&said, goal) {
        Some(field) => Err(field),
        None => numbers_of(goal),
    }
}

fn numbers_of(goal: &ArmGoal) -> Result<[f32; NUMBERS], &'static str> {
    let gripper = match GripperGoal::from_code(goal.gripper) {
        Some(GripperGoal::Open) => OPEN,
        Some(GripperGoal::Keep) => KEEP,
        Some(GripperGoal::Close) => CLOSE,
        None => return Err("gripper"),
    };
    let [x, y, z] = goal.target.position.map(nearest);
    let [w, i, j, k] = goal.target.orientation_wxyz.map(nearest);
    match GoalKind::from_code(goal.kind) {
        Some(GoalKind::Hold) => Ok([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, gripper]),
        Some(GoalKind::Pose) => Ok([x, y, z, w, i, j, k, gripper]),
        _ => Err("kind"),
    }
}

/// The goal that an action says, with the force of a closing gripper (N).
pub fn goal_of(action: &[f32; NUMBERS], grip_force: f64) -> ArmGoal {
    let [x, y, z, w, i, j, k, gripper] = action.map(f64::from);
    let holds = [w, i, j, k] == [0.0; 4];
    let (kind, target) = if holds {
        (GoalKind::Hold, Pose::IDENTITY)
    } else {
        let orientation_wxyz = [w, i, j, k];
        let position = [x, y, z];
        let target = Pose {
            position,
            orientation_wxyz,
        };
        (GoalKind::Pose, target)
    };
    let keep = f64::from(KEEP);
    let gripper = match gripper {
        number if number < keep => GripperGoal::Open,
        number if number > keep => GripperGoal::Close,
        _ => GripperGoal::Keep,
    };
    ArmGoal {
        goal_id: 1,
        kind: kind.code(),
        gripper: gripper.code(),
        target,
        grip_force,
        obstacle_mask: u64::MAX,
        object_mask: u64::MAX,
        ..ArmGoal::zeroed()
    }
}

/// The decision that the actions of all arms say, at a tick of decisions.
pub fn decision_of(tick: u64, actions: &[[f32; NUMBERS]], grip_force: f64) -> Decision {
    let mut decision = Decision::zeroed();
    decision.header = Header::caused_by::<Decision>(tick);
    decision.header.generation = 1;
    decision.arm_count = u32::try_from(actions.len()).unwrap_or(u32::MAX);
    decision.outcome = Outcome::Running.code();
    for (goal, action) in decision.goals.iter_mut().zip(actions) {
        *goal = goal_of(action, grip_force);
    }
    decision
}

/// Name of the first field in which two goals differ.
fn first_difference(one: &ArmGoal, other: &ArmGoal) -> Option<&'static str> {
    let equal = [
        ("kind", one.kind == other.kind),
        ("gripper", one.gripper == other.gripper),
        ("selector", one.selector == other.selector),
        (
            "posture",
            one.has_posture == other.has_posture && one.posture == other.posture,
        ),
        ("target", one.target == other.target),
        ("open_width", one.open_width == other.open_width),
        ("approach", one.approach == other.approach),
        (
            "approach_std_dev",
            one.approach_std_dev == other.approach_std_dev,
        ),
        ("obstacle_mask", one.obstacle_mask == other.obstacle_mask),
        ("object_mask", one.object_mask == other.object_mask),
    ];
    equal
        .iter()
        .find(|(_, equal)| !equal)
        .map(|(name, _)| *name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_action_is_a_whole_number_of_decisions() {
        let allowed = (0..=1000).filter(|rate| Hold::new(*rate).is_ok());
        let allowed: Vec<u32> = allowed.collect();
        assert_eq!(allowed, [1, 2, 4, 5, 10, 20, 25, 50, 100]);
        let text = Hold::new(30).unwrap_err().to_string();
        assert!(text.starts_with("a rate of 30 Hz; 1, 2, 4"), "{text}");
    }

    #[test]
    fn an_action_is_rounded_and_held() {
        let hold = Hold::new(20).unwrap();
        let decided = |tick: u64| {
            let mut decision = Decision::zeroed();
            decision.header.tick = tick;
            decision.goals[0].target.position[0] = 0.1 + tick as f64;
            decision
        };
        let mut in_force = decided(50);
        hold.apply(50, &Decision::zeroed(), &mut in_force);
        let acted = in_force.goals[0].target.position[0];
        assert_eq!(acted, f64::from(50.1_f32));
        let mut next = decided(60);
        hold.apply(60, &in_force, &mut next);
        assert_eq!(next.goals[0].target.position[0], acted);
        assert_eq!(next.header.tick, 60);
    }
}

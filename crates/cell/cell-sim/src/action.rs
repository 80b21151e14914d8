//! Actions at the rate of a learned policy.
//!
//! A data set has one action for each of its frames, in numbers of 32 bits. An episode comes
//! back from these numbers, to the bit, only where they are what was executed: goals are rounded
//! before they are sent, and held until the next frame.

use cell_model::runs::spec::RunSpec;
use ipc_types::{ArmGoal, DECISION_TICKS, Decision};

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
    /// For a rate of which an action is no whole number of decisions.
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

    /// Changes what the task decided at `tick` to the action in force; `before` is the decision
    /// before it.
    pub(crate) fn apply(self, tick: u64, before: &Decision, decision: &mut Decision) {
        if self.begins(tick) {
            decision.goals.iter_mut().for_each(round);
            return;
        }
        // The task decides meanwhile, on what it sees; it is not obeyed before its next action.
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

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

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

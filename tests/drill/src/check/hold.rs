//! An arm without fresh inputs stops.

use ipc_types::arm::StopAction;
use ipc_types::world::FLAG_PAUSED;

use super::{Check, Moment, Seen, Verdict, fail_if};
use crate::plan::Plan;

/// Ticks after which an arm holds without a command, and its drives stop.
const COMMAND_TICKS: u64 = 17;
const NO_COMMAND_TICKS: u64 = 2000;

pub(super) fn all(plan: &Plan) -> Vec<Box<dyn Check>> {
    // 30 ms with real-time scheduling, a tenth of a second without.
    let limit = if plan.fifo && !plan.lockstep { 28 } else { 100 };
    vec![
        Box::new(Decisions { limit }),
        Box::new(Commands),
        Box::new(Pause::default()),
    ]
}

/// An arm without fresh decisions holds, in the status that has their age.
struct Decisions {
    limit: u64,
}

impl Check for Decisions {
    fn number(&self) -> u32 {
        1
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::Status(arm, status) = moment.seen else {
            return Ok(());
        };
        let is_late = status.decision_age_ticks > self.limit;
        fail_if(
            is_late && status.stop_action < StopAction::Hold.code(),
            || {
                let age = status.decision_age_ticks;
                format!("arm {arm} moves on a decision that is {age} ticks old")
            },
        )
    }
}

/// An arm without fresh commands brakes, and after two seconds its drives have no power.
struct Commands;

impl Check for Commands {
    fn number(&self) -> u32 {
        2
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::State(state) = moment.seen else {
            return Ok(());
        };
        // An arm that had no command yet rests where it was set up.
        let arms = state.arms().iter().enumerate();
        for (arm, of) in arms.filter(|(_, of)| of.command_seq > 0) {
            let age = (state.header.tick.max(1) - 1).saturating_sub(of.command_tick);
            let least = match age {
                _ if age > NO_COMMAND_TICKS => StopAction::Stop1,
                _ if age > COMMAND_TICKS => StopAction::Hold,
                _ => StopAction::None,
            };
            fail_if(of.stop_action < least.code(), || {
                format!("arm {arm} moves on a command that is {age} ticks old")
            })?;
        }
        Ok(())
    }
}

/// While the cell is paused no tick passes.
#[derive(Default)]
struct Pause {
    /// Generation and tick of a state that was paused.
    paused: Option<(u32, u64)>,
}

impl Check for Pause {
    fn number(&self) -> u32 {
        8
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::State(state) = moment.seen else {
            return Ok(());
        };
        let (generation, tick) = (state.header.generation, state.header.tick);
        let is_paused = state.has(FLAG_PAUSED);
        let before = self
            .paused
            .replace((generation, tick))
            .filter(|_| is_paused);
        if !is_paused {
            self.paused = None;
        }
        let moved = before.is_some_and(|(g, t)| g == generation && t != tick);
        fail_if(moved, || format!("tick {tick} was made during a pause"))
    }
}

//! An object that is held stays held.

use std::collections::BTreeMap;

use ipc_types::decision::GripperGoal;
use ipc_types::{MAX_ARMS, WorldState};

use super::{Check, Moment, Seen, Verdict, fail_if};
use crate::plan::Plan;

/// A grip counts after this (ticks), and its loss as well: fingers slide over an edge.
const SURE_TICKS: u64 = 100;

pub(super) fn all(plan: &Plan) -> Vec<Box<dyn Check>> {
    let mut all: Vec<Box<dyn Check>> = vec![Box::new(Placed)];
    // A drawn object may be too heavy or too smooth for a hand.
    if plan.scene.is_none() {
        all.push(Box::new(Kept::default()));
    }
    all
}

/// An object that is held is held until the task asks for its release: no restart opens a
/// gripper.
#[derive(Default)]
struct Kept {
    /// Whether the newest decision opens the gripper of an arm, or its operator may.
    opens: [bool; MAX_ARMS],
    grips: BTreeMap<usize, Grip>,
    reset: u32,
}

/// A grip on an object.
#[derive(Clone, Copy)]
struct Grip {
    object: u32,
    since_tick: u64,
    last_tick: u64,
    breaks: u32,
}

impl Kept {
    fn state(&mut self, state: &WorldState) -> Verdict {
        let tick = state.header.tick;
        let is_reset =
            std::mem::replace(&mut self.reset, state.panel.scene_reset) != state.panel.scene_reset;
        for (arm, of) in state.arms().iter().enumerate() {
            let gripper = &of.gripper;
            let grip = self.grips.get(&arm).copied();
            let went_back = grip.is_some_and(|grip| tick < grip.last_tick);
            let excused = is_reset || went_back || self.opens[arm] || of.fault != 0;
            let excused = excused || state.panel.task_paused != 0;
            let excused = excused || grip.is_some_and(|grip| grip.breaks != gripper.breaks);
            if excused {
                self.grips.remove(&arm);
                continue;
            }
            let held = gripper.held_object;
            match grip {
                Some(grip) if grip.object == held => {
                    self.grips.insert(
                        arm,
                        Grip {
                            last_tick: tick,
                            ..grip
                        },
                    );
                }
                Some(grip) if grip.last_tick < grip.since_tick + SURE_TICKS => {
                    self.grips.remove(&arm);
                }
                Some(grip) => fail_if(tick > grip.last_tick + SURE_TICKS, || {
                    format!("arm {arm} lost object {} that it held", grip.object - 1)
                })?,
                None if held > 0 => {
                    let (since_tick, breaks) = (tick, gripper.breaks);
                    let grip = Grip {
                        object: held,
                        since_tick,
                        last_tick: tick,
                        breaks,
                    };
                    self.grips.insert(arm, grip);
                }
                None => {}
            }
        }
        Ok(())
    }
}

/// No object counts twice.
struct Placed;

impl Check for Placed {
    fn number(&self) -> u32 {
        18
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::Decision(decision) = moment.seen else {
            return Ok(());
        };
        let count = (decision.placed_count as usize).min(decision.placed.len());
        let placed = &decision.placed[..count];
        let mut objects = placed.iter().enumerate();
        let twice = objects.find(|(place, object)| placed[..*place].contains(object));
        fail_if(twice.is_some(), || {
            format!("an object is placed twice: {placed:?}")
        })
    }
}

impl Check for Kept {
    fn number(&self) -> u32 {
        7
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        match moment.seen {
            Seen::Decision(decision) => {
                for (opens, goal) in self.opens.iter_mut().zip(&decision.goals) {
                    // Until it closes again: the release takes time.
                    *opens = match goal.gripper {
                        code if code == GripperGoal::Open.code() => true,
                        code if code == GripperGoal::Close.code() => false,
                        _ => *opens,
                    };
                }
                Ok(())
            }
            Seen::State(state) => self.state(state),
            _ => Ok(()),
        }
    }
}

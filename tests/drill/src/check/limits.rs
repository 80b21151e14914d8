//! Joint setpoints keep the limits of the robot, also over restarts.

use std::collections::VecDeque;

use cell_model::robots::robot::JointSpec;
use ipc_types::WorldState;
use ipc_types::world::{ArmState, FLAG_LOCKSTEP};

use super::{Check, Moment, Seen, Verdict, fail_if};
use crate::model::Model;

/// Length of a tick (s).
const TICK_S: f64 = 1.0e-3;
/// What rounding may add.
const MARGIN: f64 = 1.0 + 1.0e-6;

pub(super) fn all(model: &Model) -> Vec<Box<dyn Check>> {
    // Those that commands and states name.
    let joints = model.cell.arms.iter().map(|arm| {
        let controlled = arm.robot.arm_joints.iter();
        controlled.map(|joint| arm.robot.joints[*joint]).collect()
    });
    vec![
        Box::new(Limits {
            joints: joints.collect(),
            before: None,
        }),
        Box::new(Resumed::default()),
    ]
}

/// From tick to tick no setpoint changes faster than a joint may.
struct Limits {
    joints: Vec<Vec<JointSpec>>,
    before: Option<Box<WorldState>>,
}

impl Check for Limits {
    fn number(&self) -> u32 {
        4
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::State(state) = moment.seen else {
            return Ok(());
        };
        let before = self.before.replace(Box::new(*state));
        // A reset of the scene moves the arm to its start.
        let follows = |before: &WorldState| {
            before.header.generation == state.header.generation
                && before.header.tick + 1 == state.header.tick
                && before.panel.scene_reset == state.panel.scene_reset
        };
        let Some(before) = before.filter(|before| follows(before)) else {
            return Ok(());
        };
        let arms = before.arms().iter().zip(state.arms()).enumerate();
        for ((arm, (old, new)), joints) in arms.zip(&self.joints) {
            for (joint, spec) in joints.iter().enumerate() {
                step(spec, old, new, joint, state.has(FLAG_LOCKSTEP))
                    .map_err(|why| format!("arm {arm}, joint {joint}: {why}"))?;
            }
            fail_if(new.limit_violations > 0, || {
                format!("arm {arm} counts {} violations", new.limit_violations)
            })?;
        }
        Ok(())
    }
}

fn step(
    spec: &JointSpec,
    old: &ArmState,
    new: &ArmState,
    joint: usize,
    is_in_time: bool,
) -> Verdict {
    let (q, v, a) = (
        new.setpoint_positions[joint],
        new.setpoint_velocities[joint],
        new.setpoint_accelerations[joint],
    );
    let moved = (q - old.setpoint_positions[joint]).abs();
    fail_if(moved > spec.velocity * TICK_S * MARGIN, || {
        format!("its setpoint moved by {moved} in a tick")
    })?;
    let faster = (v - old.setpoint_velocities[joint]).abs();
    fail_if(faster > spec.acceleration * TICK_S * MARGIN, || {
        format!("the velocity of its setpoint changed by {faster} in a tick")
    })?;
    let jerk = (a - old.setpoint_accelerations[joint]).abs();
    // After a late command physics returns to the path by the acceleration limit alone
    // (`catch_up.rs`); in lockstep no command is late.
    fail_if(is_in_time && jerk > spec.jerk * TICK_S * MARGIN, || {
        let before = old.setpoint_accelerations[joint];
        format!("the acceleration of its setpoint went from {before} to {a} in a tick")
    })?;
    fail_if(
        !(q >= spec.lower - 1.0e-9 && q <= spec.upper + 1.0e-9),
        || format!("its setpoint {q} is outside of its limits"),
    )
}

/// States that a successor of physics may resume from.
const KEPT: usize = 2100;

/// A physics that resumed has the setpoints of the state it resumed from, to the bit.
#[derive(Default)]
struct Resumed {
    generation: u32,
    /// Tick, number of the reset of the scene, and setpoints.
    states: VecDeque<(u64, u32, Vec<[u64; 3]>)>,
}

impl Check for Resumed {
    fn number(&self) -> u32 {
        5
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::State(state) = moment.seen else {
            return Ok(());
        };
        let (generation, tick) = (state.header.generation, state.header.tick);
        let now = setpoints(state);
        let is_first = std::mem::replace(&mut self.generation, generation) != generation;
        // A request to reset the scene may have been obeyed again.
        let reset = state.panel.scene_reset;
        let mut states = self.states.iter();
        let old = states.find(|(other, of, _)| (*other, *of) == (tick, reset));
        let differs = is_first && old.is_some_and(|(.., old)| *old != now);
        self.states.retain(|(other, ..)| *other < tick);
        self.states.push_back((tick, reset, now));
        if self.states.len() > KEPT {
            self.states.pop_front();
        }
        fail_if(differs, || {
            format!("physics {generation} resumed at tick {tick} with other setpoints")
        })
    }
}

fn setpoints(state: &WorldState) -> Vec<[u64; 3]> {
    let of = |arm: &ArmState| {
        let joints = 0..(arm.joint_count as usize).min(arm.joint_positions.len());
        let all = joints.map(|joint| {
            let of = |values: &[f64]| values[joint].to_bits();
            [
                of(&arm.setpoint_positions),
                of(&arm.setpoint_velocities),
                of(&arm.setpoint_accelerations),
            ]
        });
        all.collect::<Vec<_>>()
    };
    state.arms().iter().flat_map(of).collect()
}

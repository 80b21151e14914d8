//! Joint setpoints keep the limits of the robot, also over restarts.

use cell_model::robots::robot::JointSpec;
use ipc_types::world::{ArmState, FLAG_LOCKSTEP, ObjectState};
use ipc_types::{TICK_S, WorldState};

use super::history::History;
use super::{Check, Moment, Seen, Verdict, fail_if};
use crate::model::Model;

/// What rounding may add.
const MARGIN: f64 = 1.0 + 1.0e-6;
/// A setpoint as near as this to the commanded path returns to it in one tick (rad/s or m/s).
const RETURNS: f64 = 1.1e-5;

pub(super) fn all(model: &Model) -> Vec<Box<dyn Check>> {
    // Those that commands and states name.
    let joints = model.cell.arms.iter().map(|arm| {
        let controlled = arm.robot.arm_joints.iter();
        controlled.map(|joint| arm.robot.joints[*joint]).collect()
    });
    vec![
        Box::new(Limits {
            joints: joints.collect(),
            // No start of physics has this generation.
            before: (0, 0, 0),
            arms: Vec::new(),
        }),
        Box::new(Resumed::default()),
        Box::new(Finite),
    ]
}

/// From tick to tick no setpoint changes faster than a joint may.
struct Limits {
    joints: Vec<Vec<JointSpec>>,
    /// Generation, tick, number of the reset of the scene, and arms of the state before.
    before: (u32, u64, u32),
    arms: Vec<ArmState>,
}

impl Limits {
    fn follow(&self, state: &WorldState) -> Verdict {
        let arms = self.arms.iter().zip(state.arms()).enumerate();
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

impl Check for Limits {
    fn number(&self) -> u32 {
        4
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::State(state) = moment.seen else {
            return Ok(());
        };
        let (generation, tick) = (state.header.generation, state.header.tick);
        // A reset of the scene moves the arm to its start.
        let reset = state.panel.scene_reset;
        let before = std::mem::replace(&mut self.before, (generation, tick, reset));
        let verdict = if before == (generation, tick.wrapping_sub(1), reset) {
            self.follow(state)
        } else {
            Ok(())
        };
        self.arms.clear();
        self.arms.extend_from_slice(state.arms());
        verdict
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
    let fastest = spec.velocity * MARGIN + RETURNS;
    fail_if(moved > fastest * TICK_S, || {
        format!("its setpoint moved by {moved} in a tick")
    })?;
    let faster = (v - old.setpoint_velocities[joint]).abs();
    fail_if(
        faster > spec.acceleration * TICK_S * MARGIN + RETURNS,
        || format!("the velocity of its setpoint changed by {faster} in a tick"),
    )?;
    // Positions follow velocities: the mean of both, and what an acceleration within its limit
    // may add.
    let mean = 0.5 * (v + old.setpoint_velocities[joint]);
    let apart = (q - old.setpoint_positions[joint] - mean * TICK_S).abs();
    // At the end of its range a joint stays, however fast it came there after late commands.
    let is_at_end = q <= spec.lower || q >= spec.upper;
    fail_if(
        apart > spec.acceleration * TICK_S * TICK_S + RETURNS * TICK_S && !is_at_end,
        || format!("its setpoint moved by {moved} to {q} at {mean} per second"),
    )?;
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

/// Objects are somewhere.
struct Finite;

impl Check for Finite {
    fn number(&self) -> u32 {
        32
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::State(state) = moment.seen else {
            return Ok(());
        };
        let is_finite = |object: &ObjectState| {
            let (pose, twist) = (&object.pose, &object.twist);
            let of_pose = pose.position.iter().chain(&pose.orientation_wxyz);
            let mut all = of_pose.chain(&twist.linear).chain(&twist.angular);
            all.all(|value| value.is_finite())
        };
        let lost = state.objects().iter().position(|object| !is_finite(object));
        fail_if(lost.is_some(), || {
            format!("the pose of object {lost:?} has a number that is not finite")
        })
    }
}

/// A physics that resumed has the setpoints of the state it resumed from, to the bit.
#[derive(Default)]
struct Resumed {
    generation: u32,
    states: History,
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
        let is_new = std::mem::replace(&mut self.generation, generation) != generation;
        let differs = self.states.differs(is_new, state, setpoints(state));
        fail_if(differs, || {
            format!("physics {generation} resumed at tick {tick} with other setpoints")
        })
    }
}

/// Hash of the setpoints of all arms.
fn setpoints(state: &WorldState) -> u64 {
    let mut hash = 0_u64;
    for arm in state.arms() {
        let joints = 0..(arm.joint_count as usize).min(arm.joint_positions.len());
        for joint in joints {
            for value in [
                arm.setpoint_positions[joint],
                arm.setpoint_velocities[joint],
                arm.setpoint_accelerations[joint],
            ] {
                hash = crate::plan::noise(hash, value.to_bits(), 0);
            }
        }
    }
    hash
}

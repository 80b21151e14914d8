//! A suction gripper: a locked joint that is created where the cup meets a flat surface, read
//! like a force sensor, and broken at its limits.
//!
//! The limits hold for the mean of 17 ticks (16.7 ms): a part that falls into a held bin
//! causes forces of 68 to 100 N for one tick, at a static weight of 12 to 30 N, which no real
//! cup and no simulator at 60 Hz would notice.

use cell_model::SuctionGripper;
use ipc_types::equipment::{BreakCause, BreakLimit, SuctionRefusal};
use ipc_types::{GripperCommand, GripperState};
use nalgebra::Vector3;
use rapier3d_f64::prelude::*;
use serde::{Deserialize, Serialize};

use crate::arm::multibody::Arm;
use crate::engine::convert;
use crate::engine::settings::TICK_S;
use crate::engine::simulation::Engine;
use crate::gripper::cup;

/// Ticks of the mean that is compared with the limits.
const MEAN_TICKS: usize = 17;
/// Time constant of the slow mean that separates a weight from a blow (s).
// A blow as long as the other mean, 17 ms, moves this one by 7 % of its force.
const SLOW_S: f64 = 0.25;
/// A slow mean above this share of the limit is a weight.
const NEAR: f64 = 0.9;

/// Force (N) and torque about the cup (N·m) in the frame of the cup.
pub(crate) type Wrench = [f64; 6];

/// State of one suction gripper.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Suction {
    /// Whether the last accepted command requests suction.
    wanted: bool,
    on: bool,
    grip: Option<Grip>,
    peak_force: f64,
    peak_torque: f64,
    refusals: u32,
    refusal: u32,
    breaks: u32,
    break_limit: u32,
    break_cause: u32,
}

/// A grip on an object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Grip {
    object: usize,
    joint: ImpulseJointHandle,
    /// The last ticks, as a ring; before the grip there was no load.
    ring: [Wrench; MEAN_TICKS],
    next: usize,
    slow: Wrench,
}

impl Suction {
    /// Takes the gripper part of an accepted command.
    pub(super) fn command(&mut self, command: &GripperCommand) {
        self.wanted = command.suction != 0;
    }

    /// The object attached.
    pub(super) fn attached(&self) -> Option<usize> {
        self.grip.as_ref().map(|grip| grip.object)
    }

    /// The object attached, and the joint that holds it.
    pub(super) fn joint(&self) -> Option<(usize, ImpulseJointHandle)> {
        self.grip.as_ref().map(|grip| (grip.object, grip.joint))
    }

    /// Writes the report of the gripper.
    pub(super) fn write(&self, limits: &SuctionGripper, out: &mut GripperState) {
        let mean = self.grip.as_ref().map_or([0.0; 6], Grip::mean);
        let (force, torque) = norms(&mean);
        out.suction_force = finite(force);
        out.suction_torque = finite(torque);
        let load = (force / limits.force_limit).max(torque / limits.torque_limit);
        out.load = finite(load).min(1.0);
        out.peak_force = finite(self.peak_force);
        out.peak_torque = finite(self.peak_torque);
        out.suction = u32::from(self.on);
        if let Some(object) = self.attached() {
            out.attached = 1;
            out.held_object = u32::try_from(object + 1).unwrap_or(0);
        }
        (out.refusals, out.refusal) = (self.refusals, self.refusal);
        (out.breaks, out.break_limit) = (self.breaks, self.break_limit);
        out.break_cause = self.break_cause;
    }

    fn attach(&mut self, object: usize, joint: ImpulseJointHandle) {
        (self.peak_force, self.peak_torque) = (0.0, 0.0);
        self.grip = Some(Grip {
            object,
            joint,
            ring: [[0.0; 6]; MEAN_TICKS],
            next: 0,
            slow: [0.0; 6],
        });
    }

    fn refuse(&mut self, why: SuctionRefusal) {
        self.refusals = self.refusals.wrapping_add(1);
        self.refusal = why.code();
    }

    /// Adds the wrench of one tick; returns the limit that the mean exceeds.
    pub(super) fn add_load(&mut self, wrench: Wrench, limits: &SuctionGripper) -> Option<Exceeded> {
        let grip = self.grip.as_mut()?;
        let (force, torque) = norms(&wrench);
        self.peak_force = self.peak_force.max(force);
        self.peak_torque = self.peak_torque.max(torque);
        grip.add_load(wrench);
        let (force, torque) = norms(&grip.mean());
        let (slow_force, slow_torque) = norms(&grip.slow);
        if force > limits.force_limit {
            let slow = slow_force > NEAR * limits.force_limit;
            return Some(Exceeded::new(BreakLimit::Force, slow));
        }
        (torque > limits.torque_limit).then(|| {
            let slow = slow_torque > NEAR * limits.torque_limit;
            Exceeded::new(BreakLimit::Torque, slow)
        })
    }

    pub(super) fn note_break(&mut self, limit: BreakLimit, cause: BreakCause) {
        self.breaks = self.breaks.wrapping_add(1);
        self.break_limit = limit.code();
        self.break_cause = cause.code();
    }
}

impl Grip {
    fn add_load(&mut self, wrench: Wrench) {
        if let Some(oldest) = self.ring.get_mut(self.next) {
            *oldest = wrench;
        }
        self.next = (self.next + 1) % MEAN_TICKS;
        for (slow, now) in self.slow.iter_mut().zip(wrench) {
            *slow += (now - *slow) * (TICK_S / SLOW_S);
        }
    }

    fn mean(&self) -> Wrench {
        let mut mean = [0.0; 6];
        for sample in &self.ring {
            for (sum, value) in mean.iter_mut().zip(sample) {
                *sum += value / MEAN_TICKS as f64;
            }
        }
        mean
    }
}

/// A limit that was exceeded, and whether the load was near it for long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Exceeded {
    pub(super) limit: BreakLimit,
    pub(super) slow: bool,
}

impl Exceeded {
    fn new(limit: BreakLimit, slow: bool) -> Self {
        Self { limit, slow }
    }
}

/// Switches the suction of an arm by its last accepted command; called before the step. In a
/// broken engine nothing is gripped.
pub(super) fn switch(engine: &mut Engine, (index, arm): (usize, &Arm), suction: &mut Suction) {
    let Some(limits) = &arm.robot().suction else {
        return;
    };
    // Once per change: a cup that missed does not search in each tick. The refusal is
    // reported, and a new try has to switch the suction off and on.
    if suction.wanted != suction.on {
        suction.on = suction.wanted;
        if !suction.on {
            release(suction, engine);
        } else if !engine.is_broken() {
            let rapier = engine.rapier();
            match cup::find(rapier, index, &arm.tcp(rapier), limits) {
                Ok(object) => {
                    let body = engine.objects().get(object).copied();
                    let joint = body.and_then(|body| join(engine.rapier_mut(), arm, body));
                    if let Some(joint) = joint {
                        suction.attach(object, joint);
                    }
                }
                Err(why) => suction.refuse(why),
            }
        }
    }
    // An object that fell asleep on the cup would not follow the arm.
    let held = suction.attached();
    if let Some(body) = held.and_then(|object| engine.object_mut(object)) {
        body.wake_up(true);
    }
}

/// Locks an object to the link of the tool at their present poses. Contacts between the two
/// are disabled: they would fight the joint.
fn join(
    engine: &mut PhysicsWorld,
    arm: &Arm,
    object: RigidBodyHandle,
) -> Option<ImpulseJointHandle> {
    let (link, tool) = arm.tool()?;
    let tcp = arm.tcp(engine);
    let pose = convert::from_pose(engine.bodies.get(object)?.position());
    let mut joint = GenericJoint::new(JointAxesMask::LOCKED_FIXED_AXES);
    joint.local_frame1 = convert::to_pose(&tool);
    joint.local_frame2 = convert::to_pose(&(pose.inverse() * tcp));
    joint.contacts_enabled = false;
    Some(engine.impulse_joints.insert(link, object, joint, true))
}

pub(super) fn release(suction: &mut Suction, engine: &mut Engine) {
    if let Some(grip) = suction.grip.take() {
        let joints = &mut engine.rapier_mut().impulse_joints;
        joints.remove(grip.joint, true);
    }
}

/// Norms of force (N) and torque (N·m).
fn norms(wrench: &Wrench) -> (f64, f64) {
    let [fx, fy, fz, tx, ty, tz] = *wrench;
    (
        Vector3::new(fx, fy, fz).norm(),
        Vector3::new(tx, ty, tz).norm(),
    )
}

fn finite(value: f64) -> f64 {
    if value.is_finite() {
        // Larger numbers are errors of the engine; readers would refuse the state.
        value.min(1.0e5)
    } else {
        0.0
    }
}

//! The suction cups of all arms after a step: their loads, and grips that break.

use ipc_types::equipment::{BreakCause, BreakLimit};
use nalgebra::Vector3;
use rapier3d_f64::prelude::*;

use crate::arm::memory::ArmMemory;
use crate::arm::multibody::Arm;
use crate::engine::objects::Objects;
use crate::engine::settings::{SUBSTEPS, TICK_S};
use crate::gripper::hanging;
use crate::gripper::momentum::Velocities;
use crate::gripper::suction::{Wrench, release};

/// Sign of the joint's impulse along the axis when the object pulls.
const PULLS: f64 = 1.0;

/// The suction cups of all arms after a step.
pub(crate) struct Cups<'w> {
    pub(crate) engine: &'w mut PhysicsWorld,
    pub(crate) arms: &'w [Arm],
    pub(crate) memory: &'w mut [ArmMemory],
    pub(crate) objects: &'w Objects,
    /// Velocities of the objects before the step.
    pub(crate) before: &'w Velocities,
}

impl Cups<'_> {
    /// Reads the force sensors and breaks grips.
    pub(crate) fn read(&mut self) {
        for index in 0..self.arms.len() {
            let Some(wrench) = self.wrench(index) else {
                continue;
            };
            let Some(limits) = &self.arms[index].robot.suction else {
                continue;
            };
            let wrench = without_pressure(wrench, &limits.axis);
            let suction = &mut self.memory[index].suction;
            let Some(exceeded) = suction.feel(wrench, limits) else {
                continue;
            };
            // The cause is reported because the remedies differ: a weight needs a lighter load,
            // a blow a slower motion.
            let heavy = exceeded.slow || self.is_too_heavy(index, exceeded.limit);
            let cause = if heavy {
                BreakCause::Weight
            } else {
                BreakCause::Impulse
            };
            let suction = &mut self.memory[index].suction;
            release(suction, self.engine);
            suction.note_break(exceeded.limit, cause);
        }
    }

    /// Mean load on the cup in this tick, from the momentum of the objects on it. If these
    /// touch something else, from the joint, of which the engine keeps the last substep only:
    /// right at rest, a few percent low while the arm lifts.
    fn wrench(&mut self, index: usize) -> Option<Wrench> {
        let suction = &mut self.memory[index].suction;
        let (object, joint) = suction.joint()?;
        let body = self.objects.body(self.engine, object)?;
        let joint = self.engine.impulse_joints.get(joint);
        // A disabled object has left the cell; its joint would pull at a body without motion.
        let Some(joint) = joint.filter(|_| body.is_enabled()) else {
            release(suction, self.engine);
            return None;
        };
        let of_joint = of_joint(joint);
        let bodies = &self.objects.bodies;
        let hanging = hanging::with(self.engine, bodies, object);
        let cup = self.arms[index].tcp(self.engine);
        // Two cups on one load: momentum gives their sum, not the share of this one.
        let hanging = hanging.filter(|hanging| !self.others_hold(index, hanging));
        let of_momentum =
            hanging.and_then(|hanging| self.before.load(self.engine, bodies, &hanging, &cup));
        Some(of_momentum.unwrap_or(of_joint))
    }

    /// Whether the cup of another arm holds one of these objects.
    fn others_hold(&self, index: usize, objects: &[usize]) -> bool {
        let arms = self.memory.iter().enumerate();
        let mut others = arms.filter(|(arm, _)| *arm != index);
        others.any(|(_, arm)| arm.suction.attached().is_some_and(|o| objects.contains(&o)))
    }

    /// Whether the objects on the cup would break its grip at rest.
    fn is_too_heavy(&self, index: usize, limit: BreakLimit) -> bool {
        let arm = &self.arms[index];
        let attached = self.memory[index].suction.attached();
        let (Some(limits), Some(object)) = (&arm.robot.suction, attached) else {
            return false;
        };
        let cup = arm.tcp(self.engine).translation.vector;
        let load = hanging::load(self.engine, &self.objects.bodies, object, &cup);
        let Some((force, torque)) = load else {
            return false;
        };
        match limit {
            BreakLimit::Torque => torque > limits.torque_limit,
            _ => force > limits.force_limit,
        }
    }
}

/// Load by the joint's impulses; its angular rows are those of half an angle.
fn of_joint(joint: &ImpulseJoint) -> Wrench {
    let scale = SUBSTEPS as f64 / TICK_S;
    std::array::from_fn(|row| {
        let half = if row < 3 { 1.0 } else { 0.5 };
        joint.impulses[row] * scale * half
    })
}

/// A cup that is pressed does not let go: along its axis (out of the cup) only a pull counts.
fn without_pressure(wrench: Wrench, axis: &Vector3<f64>) -> Wrench {
    let [fx, fy, fz, tx, ty, tz] = wrench;
    let force = Vector3::new(fx, fy, fz);
    let pull = PULLS * force.dot(axis);
    let force = force - axis * (PULLS * pull.min(0.0));
    [force.x, force.y, force.z, tx, ty, tz]
}

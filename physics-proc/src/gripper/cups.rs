//! The suction cups of all arms after a step: their loads, and grips that break.

use ipc_types::equipment::{BreakCause, BreakLimit};
use nalgebra::Vector3;
use rapier3d_f64::prelude::*;

use crate::arm::arms::Arms;
use crate::arm::multibody::Arm;
use crate::engine::settings::{SUBSTEPS, TICK_S};
use crate::engine::simulation::Engine;
use crate::gripper::grippers::Grippers;
use crate::gripper::hanging;
use crate::gripper::suction::{Wrench, release};

/// Sign of the joint's impulse along the axis when the object pulls.
const PULLS: f64 = 1.0;

impl Grippers {
    /// Reads the force sensors and breaks grips.
    pub(super) fn measure_loads(&mut self, engine: &mut Engine, arms: &Arms) {
        for (index, arm) in arms.bodies().iter().enumerate() {
            let Some(limits) = &arm.robot().suction else {
                continue;
            };
            let Some(wrench) = self.wrench(engine, (index, arm)) else {
                continue;
            };
            let wrench = without_pressure(wrench, &limits.axis);
            let suction = &mut self.by_arm[index].suction;
            let Some(exceeded) = suction.add_load(wrench, limits) else {
                continue;
            };
            // The cause is reported because the remedies differ: a weight needs a lighter load,
            // a blow a slower motion.
            let heavy = exceeded.slow || self.is_too_heavy(engine, (index, arm), exceeded.limit);
            let cause = if heavy {
                BreakCause::Weight
            } else {
                BreakCause::Impulse
            };
            let suction = &mut self.by_arm[index].suction;
            release(suction, engine);
            suction.note_break(exceeded.limit, cause);
        }
    }

    /// Mean load on the cup in this tick, from the momentum of the objects on it. If these
    /// touch something else, from the joint, of which the engine keeps the last substep only:
    /// right at rest, a few percent low while the arm lifts.
    fn wrench(&mut self, engine: &mut Engine, (index, arm): (usize, &Arm)) -> Option<Wrench> {
        let suction = &mut self.by_arm[index].suction;
        let (object, joint) = suction.joint()?;
        let body = engine.object(object)?;
        let joint = engine.rapier().impulse_joints.get(joint);
        // A disabled object has left the cell; its joint would pull at a body without motion.
        let Some(joint) = joint.filter(|_| body.is_enabled()) else {
            release(suction, engine);
            return None;
        };
        let of_joint = of_joint(joint);
        let (rapier, bodies) = (engine.rapier(), engine.objects());
        let hanging = hanging::with(rapier, bodies, object);
        let cup = arm.tcp(rapier);
        // Two cups on one load: momentum gives their sum, not the share of this one.
        let hanging = hanging.filter(|hanging| !self.others_hold(index, hanging));
        let of_momentum =
            hanging.and_then(|hanging| self.before.load(rapier, bodies, &hanging, &cup));
        Some(of_momentum.unwrap_or(of_joint))
    }

    /// Whether the cup of another arm holds one of these objects.
    fn others_hold(&self, index: usize, objects: &[usize]) -> bool {
        let grippers = self.by_arm.iter().enumerate();
        let others = grippers.filter(|(arm, _)| *arm != index);
        let mut held = others.filter_map(|(_, gripper)| gripper.suction.attached());
        held.any(|object| objects.contains(&object))
    }

    /// Whether the objects on the cup would break its grip at rest.
    fn is_too_heavy(
        &self,
        engine: &Engine,
        (index, arm): (usize, &Arm),
        limit: BreakLimit,
    ) -> bool {
        let attached = self.by_arm[index].suction.attached();
        let (Some(limits), Some(object)) = (&arm.robot().suction, attached) else {
            return false;
        };
        let cup = arm.tcp(engine.rapier()).translation.vector;
        let load = hanging::load(engine.rapier(), engine.objects(), object, &cup);
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

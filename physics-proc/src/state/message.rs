//! Writes [`WorldState`].

use ipc_types::world::{
    OBJECT_ASLEEP, OBJECT_DRAGGED, OBJECT_ENABLED, OBJECT_OBSTACLE, OBJECT_TOUCHED,
};
use ipc_types::{ArmState, GripperState, Header, ObjectState, Twist, Wire, WorldState};
use nalgebra::Vector3;
use rapier3d_f64::prelude::PhysicsWorld;

use crate::arm::drive::ArmDrive;
use crate::arm::measured::{Measured, finite_tcp};
use crate::arm::multibody::Arm;
use crate::engine::contacts::Contacts;
use crate::engine::convert;
use crate::engine::objects::Objects;
use crate::equipment::devices::Equipment;
use crate::gripper::beam;
use crate::state::hash::StateHash;
use crate::state::memory::Memory;

/// Borrows all that a state message contains.
pub(crate) struct View<'w> {
    pub(crate) engine: &'w PhysicsWorld,
    pub(crate) objects: &'w Objects,
    pub(crate) equipment: &'w Equipment,
    pub(crate) arms: &'w [Arm],
    pub(crate) drives: &'w [ArmDrive],
    pub(crate) measured: &'w [Measured],
    pub(crate) contacts: &'w Contacts,
    pub(crate) memory: &'w Memory,
    pub(crate) inputs: &'w [ipc_types::Input],
}

impl View<'_> {
    /// Writes the present state; the publisher adds run, generation, seq and
    /// time, the process flags and script.
    pub(crate) fn write(&self, out: &mut WorldState) {
        let counts = [self.arms.len(), self.objects.bodies.len()]
            .map(|count| u32::try_from(count).unwrap_or(u32::MAX));
        // Entries beyond the counts stay as they are: zero. Only a first message has other
        // counts.
        if [out.arm_count, out.object_count] != counts {
            let script = (out.flags, out.script_line, out.script_left, out.overruns);
            // Written by the process before this call; zeroing the message must not lose them.
            *out = WorldState::zeroed();
            (out.flags, out.script_line, out.script_left, out.overruns) = script;
            [out.arm_count, out.object_count] = counts;
        }
        out.header = Header::caused_by::<WorldState>(self.memory.tick);
        for input in self.inputs {
            out.header.push_input(*input);
        }
        (out.resumed_tick, out.saving_tick, out.saved_tick) = (0, 0, 0);
        out.quarantined = self.memory.quarantined;
        out.state_hash = self.state_hash();
        out.panel = self.memory.panel.to_wire();
        out.equipment = {
            let memory = &self.memory.equipment;
            self.equipment.report(memory, self.engine, self.objects)
        };
        let arms = out.arms.iter_mut().enumerate();
        for (index, slot) in arms.take(self.arms.len()) {
            *slot = ArmState::zeroed();
            self.write_arm(index, slot);
        }
        let objects = out.objects.iter_mut().enumerate();
        for (index, slot) in objects.take(self.objects.bodies.len()) {
            *slot = ObjectState::zeroed();
            self.write_object(index, slot);
        }
    }

    /// Hash over bodies, joints and tick: equal for equal runs.
    // Bodies in the order of the engine: it is the same for equal runs, and no list has to be
    // kept.
    pub(crate) fn state_hash(&self) -> u64 {
        let mut hash = StateHash::new(self.memory.tick);
        for (_, body) in self.engine.bodies.iter() {
            let (pose, linear, angular) = (body.position(), body.linvel(), body.angvel());
            let (p, q) = (pose.translation, pose.rotation);
            hash.numbers(&[
                p.x, p.y, p.z, q.x, q.y, q.z, q.w, linear.x, linear.y, linear.z, angular.x,
                angular.y, angular.z,
            ]);
        }
        for measured in self.measured {
            hash.numbers(&measured.positions);
            hash.numbers(&measured.velocities);
        }
        hash.finish()
    }

    fn write_arm(&self, index: usize, out: &mut ArmState) {
        let (arm, measured, memory) = (
            &self.arms[index],
            &self.measured[index],
            &self.memory.arms[index],
        );
        out.stop_action = memory.stop_action;
        let setpoints = memory.watchdog.setpoint();
        for (slot, (&joint, setpoint)) in arm.robot.arm_joints.iter().zip(setpoints).enumerate() {
            let (position, velocity) = (measured.positions[joint], measured.velocities[joint]);
            out.joint_positions[slot] = position;
            out.joint_velocities[slot] = velocity;
            // Computed by the law of the drive: the engine solves it within the tick and does
            // not report it.
            out.joint_efforts[slot] = arm.effort(
                joint,
                &self.drives[index].targets[joint],
                position,
                velocity,
            );
            out.setpoint_positions[slot] = setpoint.position;
            out.setpoint_velocities[slot] = setpoint.velocity;
            out.setpoint_accelerations[slot] = setpoint.acceleration;
            out.joint_count += 1;
        }
        out.tcp = convert::to_wire(&finite_tcp(
            self.engine,
            &self.arms[index],
            &self.measured[index],
        ));
        out.gripper = self.gripper_state(index);
        if let Some(accepted) = memory.watchdog.accepted() {
            out.command_seq = accepted.seq;
            out.command_tick = accepted.tick;
            out.command_generation = accepted.generation;
        }
        out.fault = u32::from(memory.watchdog.fault);
        out.limit_violations = memory.watchdog.violations;
        out.obstacle_contacts = memory.touches.obstacles;
        out.self_contacts = memory.touches.own_parts;
    }

    fn gripper_state(&self, index: usize) -> GripperState {
        let mut out = GripperState::zeroed();
        if let Some(suction) = &self.arms[index].robot.suction {
            self.memory.arms[index].suction.write(suction, &mut out);
        }
        // A suction gripper has no width, and no fingers between which a beam could be.
        let Some(gripper) = &self.arms[index].robot.gripper else {
            return out;
        };
        let measured = &self.measured[index];
        for joint in gripper.finger_joints {
            out.width += measured.positions[joint];
            out.width_velocity += measured.velocities[joint];
        }
        let grip = self.contacts.grips[index];
        out.grip_force = grip.force;
        // Zero means no object, so the number of an object is its index plus one.
        let number = |object: usize| u32::try_from(object + 1).unwrap_or(0);
        out.held_object = grip.held.map_or(0, number);
        let beam = beam::interrupted_by(
            &self.arms[index],
            self.engine,
            &self.objects.bodies,
            out.width,
        );
        out.beam_object = beam.map_or(0, number);
        out
    }

    fn write_object(&self, index: usize, out: &mut ObjectState) {
        out.pose = ipc_types::Pose::IDENTITY;
        let Some(body) = self.objects.body(self.engine, index) else {
            return;
        };
        let flag = |set: bool, bit: u32| if set { bit } else { 0 };
        let pose = convert::finite_pose(body.position());
        // A body without a finite pose is shown as absent: readers refuse numbers that are not
        // finite.
        out.flags = flag(body.is_enabled() && pose.is_some(), OBJECT_ENABLED)
            | flag(self.contacts.touched[index], OBJECT_TOUCHED)
            | flag(
                self.memory.drags.iter().any(|drag| drag.object == index),
                OBJECT_DRAGGED,
            )
            | flag(body.is_sleeping(), OBJECT_ASLEEP)
            | flag(self.objects.specs[index].obstacle, OBJECT_OBSTACLE);
        let Some(pose) = pose else { return };
        out.pose = convert::to_wire(&pose);
        out.twist = Twist {
            linear: finite(convert::from_vector(body.linvel())),
            angular: finite(convert::from_vector(body.angvel())),
        };
    }
}

fn finite(v: Vector3<f64>) -> [f64; 3] {
    if v.iter().all(|x| x.is_finite()) {
        v.into()
    } else {
        [0.0; 3]
    }
}

//! Writes [`WorldState`], and the hash over the state.

use ipc_types::world::{
    OBJECT_ASLEEP, OBJECT_DRAGGED, OBJECT_ENABLED, OBJECT_OBSTACLE, OBJECT_TOUCHED,
};
use ipc_types::{ArmState, Header, ObjectState, Twist, Wire, WorldState};
use nalgebra::Vector3;

use super::World;
use crate::engine::convert;
use crate::state::hash::StateHash;
use crate::state::touching;

impl World {
    /// Writes the present state; the publisher adds run, generation, seq and
    /// time, the process flags and script.
    pub fn write_state(&self, out: &mut WorldState) {
        let (arms, objects) = (self.arms.bodies().len(), self.engine.objects().len());
        let counts = [arms, objects].map(|count| u32::try_from(count).unwrap_or(u32::MAX));
        // Entries beyond the counts stay as they are: zero. Only a first message has other
        // counts.
        if [out.arm_count, out.object_count] != counts {
            let script = (out.flags, out.script_line, out.script_left, out.overruns);
            // Written by the process before this call; zeroing the message must not lose them.
            *out = WorldState::zeroed();
            (out.flags, out.script_line, out.script_left, out.overruns) = script;
            [out.arm_count, out.object_count] = counts;
        }
        out.header = Header::caused_by::<WorldState>(self.tick);
        for input in &self.inputs {
            out.header.push_input(*input);
        }
        (out.resumed_tick, out.saving_tick, out.saved_tick) = (0, 0, 0);
        out.quarantined = self.engine.quarantined();
        out.state_hash = self.state_hash();
        out.panel = self.operator.report();
        out.equipment = self.equipment.report(&self.engine);
        for (index, arm) in out.arms.iter_mut().enumerate().take(arms) {
            *arm = ArmState::zeroed();
            self.arms.write(&self.engine, index, arm);
            arm.gripper = self.grippers.report(&self.engine, &self.arms, index);
        }
        for (index, object) in out.objects.iter_mut().enumerate().take(objects) {
            *object = ObjectState::zeroed();
            self.write_object(index, object);
        }
    }

    fn write_object(&self, index: usize, out: &mut ObjectState) {
        out.pose = ipc_types::Pose::IDENTITY;
        let Some(body) = self.engine.object(index) else {
            return;
        };
        let flag = |set: bool, bit: u32| if set { bit } else { 0 };
        let pose = convert::finite_pose(body.position());
        // A body without a finite pose is shown as absent: readers refuse numbers that are not
        // finite.
        out.flags = flag(body.is_enabled() && pose.is_some(), OBJECT_ENABLED)
            | flag(self.grippers.touches(index), OBJECT_TOUCHED)
            | flag(self.operator.is_dragged(index), OBJECT_DRAGGED)
            | flag(body.is_sleeping(), OBJECT_ASLEEP)
            | flag(self.engine.specs()[index].obstacle, OBJECT_OBSTACLE);
        let Some(pose) = pose else { return };
        out.pose = convert::to_wire(&pose);
        out.twist = Twist {
            linear: finite(convert::from_vector(body.linvel())),
            angular: finite(convert::from_vector(body.angvel())),
        };
    }

    /// Writes the contacts of the present state.
    pub fn write_contacts(&self, out: &mut ipc_types::Contacts) {
        touching::write(self.engine.rapier(), self.tick, out);
    }

    /// Hash over bodies, joints and tick: equal for equal runs.
    // Bodies in the order of the engine: it is the same for equal runs, and no list has to be
    // kept.
    pub fn state_hash(&self) -> u64 {
        let mut hash = StateHash::new(self.tick);
        for (_, body) in self.engine.rapier().bodies.iter() {
            let (pose, linear, angular) = (body.position(), body.linvel(), body.angvel());
            let (p, q) = (pose.translation, pose.rotation);
            hash.numbers(&[
                p.x, p.y, p.z, q.x, q.y, q.z, q.w, linear.x, linear.y, linear.z, angular.x,
                angular.y, angular.z,
            ]);
        }
        for measured in self.arms.measured() {
            hash.numbers(measured.positions());
            hash.numbers(measured.velocities());
        }
        hash.finish()
    }
}

fn finite(v: Vector3<f64>) -> [f64; 3] {
    if v.iter().all(|x| x.is_finite()) {
        v.into()
    } else {
        [0.0; 3]
    }
}

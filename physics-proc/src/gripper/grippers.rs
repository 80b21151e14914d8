//! The grippers of all arms as a component of the world: fingers, cups, and the contacts by
//! which objects are held.

use cell_model::{ArmSpec, Cell};
use ipc_types::{GripperCommand, GripperState, MAX_ARMS, Wire};
use serde::{Deserialize, Serialize};

use crate::arm::arms::Arms;
use crate::arm::measured::Measured;
use crate::arm::multibody::Arm;
use crate::engine::contacts::Contacts;
use crate::engine::simulation::Engine;
use crate::gripper::beam;
use crate::gripper::momentum::Velocities;
use crate::gripper::parallel::GripperDrive;
use crate::gripper::suction::{self, Suction};

/// The grippers of a cell.
pub(crate) struct Grippers {
    /// One for each arm; an arm without a gripper has one that does nothing.
    pub(super) by_arm: Vec<Gripper>,
    contacts: Contacts,
    /// Velocities of the objects before the last step, while a cup holds one.
    pub(super) before: Velocities,
}

/// State of the gripper of one arm: part of every snapshot.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Gripper {
    fingers: GripperDrive,
    pub(super) suction: Suction,
}

impl Gripper {
    /// At the start of a run.
    fn new(arm: &ArmSpec) -> Self {
        let fingers = arm.robot.gripper.as_ref().map(|gripper| {
            let joints = gripper.finger_joints.iter();
            let home = joints.filter_map(|&joint| arm.robot.joints.get(joint));
            let open = home.map(|spec| spec.home).fold(0.0, f64::max);
            GripperDrive::new(gripper, open)
        });
        Self {
            fingers: fingers.unwrap_or(GripperDrive::NONE),
            suction: Suction::default(),
        }
    }

    /// Drives both fingers.
    fn drive_fingers(&mut self, engine: &mut Engine, arm: &Arm, measured: &Measured) {
        let Some(gripper) = &arm.robot().gripper else {
            return;
        };
        let [left, right] = gripper.finger_joints;
        // The mean of both fingers: they are coupled, and a target for one alone would pull at
        // the coupling.
        let finger = 0.5 * (measured.positions()[left] + measured.positions()[right]);
        let stiffness = arm.robot().joints[left].stiffness;
        let target = self.fingers.step(gripper, stiffness, finger);
        for joint in gripper.finger_joints {
            arm.drive(engine.rapier_mut(), joint, &target);
        }
    }
}

impl Grippers {
    /// The grippers of a cell at the start.
    pub(crate) fn new(cell: &Cell) -> Self {
        Self {
            by_arm: cell.arms.iter().map(Gripper::new).collect(),
            contacts: Contacts::new(cell.arms.len(), cell.objects.len()),
            before: Velocities::default(),
        }
    }

    /// Follows the accepted commands, by arm; on silence a gripper keeps its last command, so
    /// that a held object is not dropped.
    pub(crate) fn before_step(
        &mut self,
        engine: &mut Engine,
        arms: &Arms,
        commands: &[Option<&GripperCommand>; MAX_ARMS],
    ) {
        let bodies = arms.bodies().iter().zip(arms.measured()).enumerate();
        let grippers = self.by_arm.iter_mut().zip(commands);
        for ((gripper, command), (index, (arm, measured))) in grippers.zip(bodies) {
            if let Some(command) = command {
                gripper.suction.command(command);
                if let Some(spec) = &arm.robot().gripper {
                    gripper.fingers.command(command, spec);
                }
            }
            gripper.drive_fingers(engine, arm, measured);
            suction::switch(engine, (index, arm), &mut gripper.suction);
        }
    }

    /// Notes the velocities of the objects for the load on the cups.
    pub(crate) fn note_velocities(&mut self, engine: &Engine) {
        let mut grippers = self.by_arm.iter();
        // Without an object on a cup the copy of all objects is not worth its time.
        if grippers.any(|gripper| gripper.suction.attached().is_some()) {
            self.before.note(engine.rapier(), engine.objects());
        }
    }

    /// Measures the load on the cups, which may break a grip, and the contacts.
    pub(crate) fn after_step(&mut self, engine: &mut Engine, arms: &Arms) {
        // Before the contacts: a grip that breaks in this tick must not count as a touched
        // object.
        self.measure_loads(engine, arms);
        self.measure(engine, arms);
    }

    /// Measures the contacts, and wakes objects that an arm touches: the engine would let a held
    /// object fall asleep in a hand at rest.
    pub(crate) fn measure(&mut self, engine: &mut Engine, arms: &Arms) {
        if engine.is_broken() {
            return;
        }
        self.contacts.read(engine.rapier(), arms.bodies());
        for gripper in &self.by_arm {
            self.contacts.attach(gripper.suction.attached());
        }
        engine.wake(|object, _| self.touches(object));
    }

    /// Whether an arm touches an object, or a cup holds it.
    pub(crate) fn touches(&self, object: usize) -> bool {
        self.contacts.touched.get(object) == Some(&true)
    }

    /// Whether a cup holds an object.
    pub(crate) fn is_attached(&self, object: usize) -> bool {
        let mut grippers = self.by_arm.iter();
        grippers.any(|gripper| gripper.suction.attached() == Some(object))
    }

    /// The object that the gripper of an arm holds.
    pub(crate) fn held(&self, arm: usize) -> Option<usize> {
        let attached = self.by_arm.get(arm)?.suction.attached();
        attached.or(self.contacts.grips.get(arm)?.held)
    }

    /// The report of the gripper of an arm.
    pub(crate) fn report(&self, engine: &Engine, arms: &Arms, arm: usize) -> GripperState {
        let mut out = GripperState::zeroed();
        let (body, measured) = (&arms.bodies()[arm], &arms.measured()[arm]);
        if let Some(suction) = &body.robot().suction {
            self.by_arm[arm].suction.write(suction, &mut out);
        }
        // A suction gripper has no width, and no fingers between which a beam could be.
        let Some(gripper) = &body.robot().gripper else {
            return out;
        };
        for joint in gripper.finger_joints {
            out.width += measured.positions()[joint];
            out.width_velocity += measured.velocities()[joint];
        }
        let grip = self.contacts.grips[arm];
        out.grip_force = grip.force;
        // Zero means no object, so the number of an object is its index plus one.
        let number = |object: usize| u32::try_from(object + 1).unwrap_or(0);
        out.held_object = grip.held.map_or(0, number);
        let beam = beam::interrupted_by(body, engine.rapier(), engine.objects(), out.width);
        out.beam_object = beam.map_or(0, number);
        out
    }

    /// By arm: its part of a snapshot.
    pub(crate) fn save(&self) -> &[Gripper] {
        &self.by_arm
    }

    /// Continues from a snapshot, or starts again with the scene.
    pub(crate) fn restore(&mut self, saved: Vec<Gripper>) {
        self.by_arm = saved;
    }
}

//! The arms as a component of the world: links in the engine, drives, measured joints, faults
//! and counts.

use cell_model::Cell;
use ipc_types::{ArmCommand, ArmState, GripperCommand, Input, MAX_ARMS, MAX_JOINTS};
use nalgebra::Isometry3;
use rapier3d_f64::prelude::PhysicsWorld;

use crate::arm::drive::{ArmDrive, DriveState};
use crate::arm::measured::{Measured, finite_tcp};
use crate::arm::multibody::Arm;
use crate::arm::touch_count::{TouchCount, TouchCounter};
use crate::arm::touches::{self, ArmContact};
use crate::arm::violations;
#[cfg(test)]
use crate::arm::watchdog::Watchdog;
use crate::engine::convert;
use crate::engine::simulation::Engine;

/// The arms of a cell. All lists are by arm.
pub(crate) struct Arms {
    pub(super) bodies: Vec<Arm>,
    pub(super) drives: Vec<ArmDrive>,
    pub(super) measured: Vec<Measured>,
    touches: Vec<TouchCount>,
    touch_counter: TouchCounter,
}

/// The part of one arm in a snapshot, without its gripper.
pub(crate) struct SavedArm {
    pub(crate) drive: DriveState,
    pub(crate) touches: TouchCount,
    pub(crate) stop_action: u32,
}

impl Arms {
    /// Inserts the arms into the engine, at home.
    pub(crate) fn insert(engine: &mut PhysicsWorld, cell: &Cell) -> Self {
        let specs = cell.arms.iter().enumerate();
        let bodies: Vec<Arm> = specs
            .map(|(index, spec)| Arm::insert(engine, index, spec))
            .collect();
        let drives = cell.arms.iter();
        Self {
            drives: drives
                .map(|arm| ArmDrive::new(arm, &cell.disturbance))
                .collect(),
            measured: bodies.iter().map(|arm| Measured::new(&arm.robot)).collect(),
            touches: vec![TouchCount::default(); bodies.len()],
            touch_counter: TouchCounter::new(cell),
            bodies,
        }
    }

    /// The arms in the engine.
    pub(crate) fn bodies(&self) -> &[Arm] {
        &self.bodies
    }

    /// The measured joints of each arm.
    pub(crate) fn measured(&self) -> &[Measured] {
        &self.measured
    }

    /// The measured positions of the controlled joints of an arm (rad or m); zeros beyond them.
    pub(crate) fn controlled_positions(&self, arm: usize) -> [f64; MAX_JOINTS] {
        let mut positions = [0.0; MAX_JOINTS];
        if let Some((arm, measured)) = self.bodies.get(arm).zip(self.measured.get(arm)) {
            for (slot, joint) in positions.iter_mut().zip(&arm.robot.arm_joints) {
                *slot = measured.positions()[*joint];
            }
        }
        positions
    }

    /// Pose of the tool centre point of an arm; `None` if the cell has no arm of that index.
    pub(crate) fn tcp(&self, engine: &Engine, arm: usize) -> Option<Isometry3<f64>> {
        let (arm, measured) = self.bodies.get(arm).zip(self.measured.get(arm))?;
        Some(finite_tcp(engine, arm, measured))
    }

    /// Drives the joints by the commands, or as the watchdogs decide without them. Returns what
    /// the accepted commands have for the grippers.
    pub(crate) fn before_step<'c>(
        &mut self,
        engine: &mut Engine,
        tick: u64,
        commands: &[Option<&'c ArmCommand>; MAX_ARMS],
    ) -> [Option<&'c GripperCommand>; MAX_ARMS] {
        let mut accepted = [None; MAX_ARMS];
        let arms = self.drives.iter_mut().zip(&self.bodies).zip(&self.measured);
        for (((drive, arm), measured), (command, out)) in
            arms.zip(commands.iter().zip(&mut accepted))
        {
            let is_accepted =
                drive.before_step(engine.rapier_mut(), (arm, measured), (tick, *command));
            *out = command
                .filter(|_| is_accepted)
                .map(|command| &command.gripper);
        }
        accepted
    }

    /// The commands in force, as inputs of the state after `tick`.
    pub(crate) fn inputs(&self, tick: u64) -> impl Iterator<Item = Input> + '_ {
        let drives = self.drives.iter().enumerate();
        drives.filter_map(move |(index, drive)| drive.input(index, tick))
    }

    /// Takes over the faults of the last step, and measures the joints.
    pub(crate) fn after_step(&mut self, engine: &Engine) {
        for (arm, drive) in self.bodies.iter().zip(&mut self.drives) {
            // A panic of the engine cannot be assigned to one arm.
            let mut disabled = engine.disabled().iter();
            let is_lost = engine.is_broken() || disabled.any(|body| arm.bodies.contains(body));
            drive.watchdog_mut().fault |= is_lost;
        }
        self.measure(engine);
    }

    /// Measures the joints.
    pub(crate) fn measure(&mut self, engine: &Engine) {
        let arms = self.bodies.iter().zip(&mut self.measured);
        for ((arm, measured), drive) in arms.zip(&mut self.drives) {
            if engine.is_ideal() {
                measured.follow(&arm.robot, drive.watchdog().setpoint());
                continue;
            }
            // A fault is never cleared here: only a reset, which replaces the engine, ends it.
            drive.watchdog_mut().fault |= !measured.read(arm, engine.rapier());
        }
    }

    /// Counts joints outside of their limits, and contacts. `held` gives the object that an arm
    /// holds.
    pub(crate) fn count(
        &mut self,
        engine: &Engine,
        tick: u64,
        held: impl Fn(usize) -> Option<usize>,
    ) {
        let arms = self.bodies.iter().zip(&self.measured).enumerate();
        let counts = self.drives.iter_mut().zip(&mut self.touches);
        for ((index, (arm, measured)), (drive, touches)) in arms.zip(counts) {
            let joints = arm.robot.arm_joints.iter().filter(|&&joint| {
                violations::outside(measured.positions[joint], &arm.robot.joints[joint])
            });
            let outside = joints.count() as u64;
            drive.watchdog_mut().count_outside(outside);
            // A faulty arm does not follow its controller, which its contacts are meant to
            // judge.
            if !drive.watchdog().fault {
                self.touch_counter.count(
                    engine.rapier(),
                    (index, arm),
                    measured,
                    (tick, held(index)),
                    touches,
                );
            }
        }
    }

    /// Writes the report of an arm, except for its gripper.
    pub(crate) fn write(&self, engine: &Engine, arm: usize, out: &mut ArmState) {
        let (body, measured) = (&self.bodies[arm], &self.measured[arm]);
        self.drives[arm].write(body, measured, out);
        out.tcp = convert::to_wire(&finite_tcp(engine, body, measured));
        out.obstacle_contacts = self.touches[arm].obstacles;
        out.self_contacts = self.touches[arm].own_parts;
    }

    /// Contacts of the links of an arm, except those of its base; empty if the cell has no arm
    /// of that index.
    pub(crate) fn contacts(&self, engine: &Engine, arm: usize) -> Vec<ArmContact> {
        let body = self.bodies.get(arm);
        body.map_or_else(Vec::new, |body| touches::of(engine.rapier(), arm, body))
    }

    /// Commands refused since the start.
    pub(crate) fn refused_commands(&self) -> u64 {
        let drives = self.drives.iter();
        drives.map(|drive| drive.watchdog().refused).sum()
    }

    /// By arm: its parts of a snapshot.
    pub(crate) fn save(&self) -> impl Iterator<Item = (&DriveState, &TouchCount, u32)> {
        let arms = self.drives.iter().zip(&self.touches);
        arms.map(|(drive, touches)| {
            let (state, stop_action) = drive.save();
            (state, touches, stop_action)
        })
    }

    /// Continues from a snapshot.
    pub(crate) fn restore(&mut self, saved: Vec<SavedArm>) {
        let arms = self.drives.iter_mut().zip(&mut self.touches);
        for ((drive, touches), saved) in arms.zip(saved) {
            drive.restore(saved.drive, saved.stop_action);
            *touches = saved.touches;
        }
    }

    /// Back to the start of the scene at `tick`. The counts by which a run is judged
    /// (violations, contacts, refused commands) continue.
    pub(crate) fn reset(&mut self, initial: Vec<SavedArm>, tick: u64) {
        let arms = self.drives.iter_mut().zip(&mut self.touches);
        for ((drive, touches), mut initial) in arms.zip(initial) {
            drive.reset(initial.drive, initial.stop_action, tick);
            initial.touches.carry_over(touches);
            *touches = initial.touches;
        }
    }

    /// The watchdog and the measured joints of an arm, for tests that set them.
    #[cfg(test)]
    pub(crate) fn watchdog_and_joints(&mut self, arm: usize) -> (&mut Watchdog, &mut [f64]) {
        (
            self.drives[arm].watchdog_mut(),
            &mut self.measured[arm].positions,
        )
    }
}

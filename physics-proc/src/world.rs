//! The world: one pure step per tick.

use std::panic::{AssertUnwindSafe, catch_unwind};

use cell_model::{Cell, Dynamics, ModelError};
use ipc_types::{ArmCommand, Decision, MAX_ARMS, TICK_NS};
use nalgebra::Vector3;
use rapier3d_f64::prelude::*;
use rmp::JointLimits;
use thiserror::Error;

use crate::arm::{Arm, DriveTarget};
use crate::arm_contacts::{self, ArmContact};
use crate::contacts::{self, Contacts};
use crate::equipment::Equipment;
use crate::measured::Measured;
use crate::memory::Memory;
use crate::momentum::Velocities;
use crate::settings::{self, GRAVITY};
use crate::{convert, objects, spawn, violations};

/// Why a cell cannot be simulated.
#[derive(Debug, Error)]
pub enum WorldError {
    /// Two things start inside each other.
    #[error("object '{object}' starts {:.1} mm inside '{other}'; move it or make its spawn area smaller", depth * 1.0e3)]
    Overlap {
        /// The object.
        object: String,
        /// What it overlaps.
        other: String,
        /// How deep (m).
        depth: f64,
    },
    /// The cell does not fit the messages.
    #[error("the cell has {count} {what}; at most {limit} are possible")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many.
        count: usize,
        /// How many are possible.
        limit: usize,
    },
    /// The model is wrong.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A snapshot is not of this cell and this program.
    #[error("the snapshot cannot be restored: {reason}; start from the beginning instead")]
    Snapshot {
        /// What does not fit.
        reason: String,
    },
}

/// Input of one tick.
#[derive(Clone, Copy, Default)]
pub struct StepInput<'a> {
    /// Newest accepted command of each arm, of any age.
    pub commands: [Option<&'a ArmCommand>; MAX_ARMS],
    /// Newest decision, for the cell's equipment.
    pub decision: Option<&'a Decision>,
}

/// The robot and the world.
pub struct World {
    pub(crate) engine: PhysicsWorld,
    pub(crate) arms: Vec<Arm>,
    pub(crate) objects: Vec<RigidBodyHandle>,
    /// By object: controllers may keep away from it.
    pub(crate) obstacles: Vec<bool>,
    pub(crate) equipment: Equipment,
    pub(crate) memory: Memory,
    /// Of the objects before the last step, while a cup holds one.
    pub(crate) before: Velocities,
    pub(crate) contacts: Contacts,
    pub(crate) measured: Vec<Measured>,
    /// By arm: what its drives were told in the last tick, by joint of the
    /// chain.
    pub(crate) targets: Vec<Vec<DriveTarget>>,
    pub(crate) limits: Vec<JointLimits>,
    pub(crate) dynamics: Vec<Dynamics>,
    /// Gravity in the base frame of each arm (m/s²).
    base_gravity: Vec<Vector3<f64>>,
    pub(crate) inputs: Vec<ipc_types::Input>,
    pub(crate) initial: Vec<u8>,
    /// A reset of the task leaves it paused.
    pub(crate) reset_pauses: bool,
    /// Same for the same cell and program: stamps snapshots.
    pub(crate) fingerprint: u64,
}

impl World {
    /// Sets the scene up at tick 0.
    ///
    /// # Errors
    /// [`WorldError`] where something overlaps or does not fit.
    pub fn new(cell: &Cell) -> Result<Self, WorldError> {
        spawn::check(cell)?;
        too_many("arms", cell.arms.len(), MAX_ARMS)?;
        too_many("objects", cell.objects.len(), ipc_types::MAX_OBJECTS)?;
        for arm in &cell.arms {
            too_many(
                "controlled joints",
                arm.robot.arm_joints.len(),
                ipc_types::MAX_JOINTS,
            )?;
        }
        let mut engine = settings::empty_world();
        let fixtures = objects::insert_fixtures(&mut engine, cell);
        let objects = objects::insert(&mut engine, cell);
        let arms: Vec<Arm> = cell
            .arms
            .iter()
            .enumerate()
            .map(|(index, spec)| Arm::insert(&mut engine, index, spec))
            .collect();
        let gravity = Vector3::from(GRAVITY);
        let equipment = Equipment::new(cell, &fixtures);
        if let Some(belt) = &equipment.belt {
            belt.keep_fresh(&mut engine);
        }
        let mut world = Self {
            obstacles: cell.objects.iter().map(|object| object.obstacle).collect(),
            equipment,
            memory: Memory::new(cell),
            before: Velocities::default(),
            contacts: Contacts::new(arms.len(), objects.len()),
            measured: arms.iter().map(|arm| Measured::new(&arm.robot)).collect(),
            targets: arms
                .iter()
                .map(|arm| vec![DriveTarget::default(); arm.robot.joints.len()])
                .collect(),
            limits: arms.iter().map(|arm| arm.robot.limits()).collect(),
            dynamics: arms.iter().map(|arm| Dynamics::new(&arm.robot)).collect(),
            base_gravity: cell
                .arms
                .iter()
                .map(|arm| arm.base.rotation.inverse() * gravity)
                .collect(),
            inputs: Vec::new(),
            initial: Vec::new(),
            reset_pauses: cell.reset_pauses,
            fingerprint: crate::snapshot::fingerprint(cell),
            engine,
            arms,
            objects,
        };
        world.read_back();
        world.initial = world.snapshot();
        Ok(world)
    }

    /// The tick the present state ends; 0 at the start.
    pub fn tick(&self) -> u64 {
        self.memory.tick
    }

    /// Simulates one tick.
    pub fn step(&mut self, input: &StepInput<'_>) {
        self.inputs.clear();
        for (index, command) in input.commands.iter().enumerate().take(self.arms.len()) {
            self.drive_arm(index, *command);
            self.drive_hand(index);
            self.switch_suction(index);
            self.note_input(index);
        }
        self.run_equipment(input.decision);
        self.apply_drags();
        self.note_velocities();
        self.step_engine();
        self.memory.tick += 1;
        self.read_quarantine();
        self.read_suction();
        self.read_back();
        self.count_outside();
    }

    /// Commands refused since the start: too far from the setpoint in force, or
    /// with implausible numbers.
    pub fn refused_commands(&self) -> u64 {
        self.memory
            .arms
            .iter()
            .map(|arm| arm.watchdog.refused)
            .sum()
    }

    /// Deepest penetration of any two shapes in contact (m).
    pub fn penetration(&self) -> f64 {
        contacts::deepest(&self.engine)
    }

    /// What the links of an arm touch now; its base does not count.
    pub fn arm_contacts(&self, arm: usize) -> Vec<ArmContact> {
        self.arms
            .get(arm)
            .map_or_else(Vec::new, |spec| arm_contacts::of(&self.engine, arm, spec))
    }

    fn drive_arm(&mut self, index: usize, command: Option<&ArmCommand>) {
        let arm = &self.arms[index];
        let memory = &mut self.memory.arms[index];
        let verdict =
            memory
                .watchdog
                .update(self.memory.tick, command, &arm.robot, &self.limits[index]);
        memory.stop_action = verdict.stop.action.code();
        if let (true, Some(command)) = (verdict.accepted, command) {
            memory.suction.command(&command.gripper);
            if let Some(gripper) = &arm.robot.gripper {
                memory.gripper.command(&command.gripper, gripper);
            }
        }
        let gravity = &self.base_gravity[index];
        let measured: Vec<f64> = arm
            .robot
            .arm_joints
            .iter()
            .map(|&joint| self.measured[index].positions[joint])
            .collect();
        let carried = self.dynamics[index]
            .inverse_dynamics(&measured, &[], &[], gravity)
            .to_vec();
        let setpoint: Vec<_> = memory.watchdog.setpoint().collect();
        let efforts = if verdict.own {
            let of = |value: fn(&cell_model::ramp::RampState) -> f64| {
                setpoint.iter().map(value).collect::<Vec<f64>>()
            };
            self.dynamics[index].inverse_dynamics(
                &of(|s| s.position),
                &of(|s| s.velocity),
                &of(|s| s.acceleration),
                gravity,
            )
        } else {
            memory.watchdog.efforts()
        };
        let efforts = efforts.iter().zip(&carried);
        for (&joint, (state, (effort, gravity))) in arm
            .robot
            .arm_joints
            .iter()
            .zip(setpoint.iter().zip(efforts))
        {
            let target = DriveTarget {
                position: state.position,
                velocity: state.velocity,
                effort: *effort,
                gravity: *gravity,
                max_effort: arm.robot.joints[joint].effort,
            };
            arm.drive(&mut self.engine, joint, &target);
            self.targets[index][joint] = target;
        }
    }

    fn drive_hand(&mut self, index: usize) {
        let arm = &self.arms[index];
        let Some(gripper) = &arm.robot.gripper else {
            return;
        };
        let [left, right] = gripper.finger_joints;
        let finger =
            0.5 * (self.measured[index].positions[left] + self.measured[index].positions[right]);
        let target =
            self.memory.arms[index]
                .gripper
                .step(gripper, arm.robot.joints[left].stiffness, finger);
        for joint in gripper.finger_joints {
            arm.drive(&mut self.engine, joint, &target);
            self.targets[index][joint] = target;
        }
    }

    fn note_input(&mut self, index: usize) {
        let Some(accepted) = self.memory.arms[index].watchdog.accepted() else {
            return;
        };
        let arm = u8::try_from(index).unwrap_or(u8::MAX);
        self.inputs.push(ipc_types::Input {
            topic: ipc_types::topic::TopicId::ArmCommand(arm).code(),
            generation: accepted.generation,
            seq: accepted.seq,
            age_ticks: self.memory.tick.saturating_sub(accepted.tick),
        });
    }

    fn apply_drags(&mut self) {
        let (bodies, objects) = (&mut self.engine.bodies, &self.objects);
        self.memory.drags.retain_mut(|drag| {
            let body = objects
                .get(drag.object)
                .and_then(|handle| bodies.get_mut(*handle));
            body.is_some_and(|body| drag.apply(body))
        });
    }

    /// The engine panics when a driven joint is no longer finite. Then every arm
    /// is at fault and the scene stands still until it is reset, which replaces
    /// the engine.
    fn step_engine(&mut self) {
        if self.memory.broken {
            return;
        }
        let hooks = self.hooks();
        let engine = &mut self.engine;
        let step = AssertUnwindSafe(|| engine.step_with_events(&hooks, &()));
        if catch_unwind(step).is_err() {
            self.memory.broken = true;
            self.memory.quarantined += 1;
            for arm in &mut self.memory.arms {
                arm.watchdog.fault = true;
            }
        }
    }

    /// Bodies the engine had to disable: an arm with such a link is at fault.
    fn read_quarantine(&mut self) {
        if self.memory.broken {
            return;
        }
        for body in self.engine.quarantine().bodies() {
            self.memory.quarantined += 1;
            let at_fault = self.arms.iter().position(|arm| arm.bodies.contains(body));
            if let Some(arm) = at_fault {
                self.memory.arms[arm].watchdog.fault = true;
            }
        }
    }

    /// Reads joints and contacts back from the engine.
    pub(crate) fn read_back(&mut self) {
        for ((arm, measured), memory) in self
            .arms
            .iter()
            .zip(&mut self.measured)
            .zip(&self.memory.arms)
        {
            if !memory.watchdog.fault {
                measured.read(arm, &self.engine);
            }
        }
        if !self.memory.broken {
            self.contacts.read(&self.engine, &self.arms);
            for arm in &self.memory.arms {
                self.contacts.attach(arm.suction.attached());
            }
            self.refresh_held();
        }
    }

    fn count_outside(&mut self) {
        for ((arm, measured), memory) in self
            .arms
            .iter()
            .zip(&self.measured)
            .zip(&mut self.memory.arms)
        {
            let joints = arm.robot.arm_joints.iter().filter(|&&joint| {
                violations::outside(measured.positions[joint], &arm.robot.joints[joint])
            });
            memory.watchdog.violations += joints.count() as u64;
        }
    }

    /// Simulated time of the present state (ns).
    pub fn sim_time_ns(&self) -> u64 {
        self.memory.tick * TICK_NS
    }

    /// Pose of an object in the world frame, if it exists and is finite.
    pub(crate) fn object_pose(&self, index: usize) -> Option<nalgebra::Isometry3<f64>> {
        let body = self.engine.bodies.get(*self.objects.get(index)?)?;
        let pose = convert::from_pose(body.position());
        let finite = pose
            .translation
            .vector
            .iter()
            .chain(pose.rotation.coords.iter())
            .all(|x: &f64| x.is_finite());
        finite.then_some(pose)
    }
}

fn too_many(what: &'static str, count: usize, limit: usize) -> Result<(), WorldError> {
    if count <= limit {
        Ok(())
    } else {
        Err(WorldError::TooMany { what, count, limit })
    }
}

//! Requests of people.

use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::{GripperGoal, MAX_BREAKS, OperatorRequest, Validate};
use nalgebra::Isometry3;
use rapier3d_f64::prelude::PhysicsWorld;

use crate::arm::measured::{Measured, finite_tcp};
use crate::arm::multibody::Arm;
use crate::engine::convert;
use crate::engine::objects::Objects;
use crate::equipment::devices::Equipment;
use crate::equipment::site::Site;
use crate::error::WorldError;
use crate::operator::drag::Drag;
use crate::state::memory::Memory;

/// An answer: a code, and a sentence for the person: the reason of a refusal, or the condition
/// under which an accepted request takes effect.
pub(crate) type Reply = (ReplyCode, String);

/// The parts of the world that a request acts upon.
pub(crate) struct Desk<'w> {
    pub(crate) engine: &'w mut PhysicsWorld,
    pub(crate) objects: &'w Objects,
    pub(crate) equipment: &'w Equipment,
    pub(crate) arms: &'w [Arm],
    pub(crate) measured: &'w [Measured],
    pub(crate) memory: &'w mut Memory,
    /// A reset of the task leaves it paused.
    pub(crate) reset_pauses: bool,
}

impl Desk<'_> {
    /// Executes a request. Pause, resume, step, script and end are refused here: they belong
    /// to the process around the world.
    pub(crate) fn act(&mut self, action: OperatorAction, request: &OperatorRequest) -> Reply {
        // Once, before any request reads a number: a pose that is not finite would reach the
        // engine.
        if let Err(invalid) = request.validate() {
            return (ReplyCode::OutOfRange, invalid.to_string());
        }
        match action {
            OperatorAction::Ping => accepted(),
            OperatorAction::Drag => self.drag(request),
            OperatorAction::Target => self.target(request),
            OperatorAction::Joints => self.joints(request),
            OperatorAction::Break => self.breakpoint(request),
            OperatorAction::Gripper => self.gripper(request),
            OperatorAction::TaskStart => self.start_task(),
            OperatorAction::TaskReset => self.reset_task(),
            OperatorAction::TaskPause => self.pause_task(true),
            OperatorAction::TaskResume => self.pause_task(false),
            OperatorAction::DropParts => self.operator_drops(request.count),
            OperatorAction::AddBin => self.operator_adds(request.count == 1),
            OperatorAction::Reset
            | OperatorAction::Pause
            | OperatorAction::Resume
            | OperatorAction::Step
            | OperatorAction::ScriptDone
            | OperatorAction::Speed
            | OperatorAction::End => (
                ReplyCode::NotInThisCell,
                "the world has no clock of its own".to_owned(),
            ),
        }
    }

    fn drag(&mut self, request: &OperatorRequest) -> Reply {
        let object = request.object as usize;
        let (engine, objects) = (&*self.engine, self.objects);
        let pose = objects.pose(engine, object);
        let here = pose.filter(|_| objects.is_here(engine, object));
        let Some(pose) = here else {
            let count = self.objects.bodies.len();
            return (
                ReplyCode::UnknownObject,
                format!("object {object} is not here; this cell has {count}"),
            );
        };
        let target = request.pose.position;
        let far = target.iter().any(|x| x.abs() > 20.0);
        if far || request.seconds < 0.0 {
            return (
                ReplyCode::OutOfRange,
                "the place must be within 20 m and the time not negative".to_owned(),
            );
        }
        // A new drag replaces the one of the same object; two springs on it would fight each
        // other.
        self.memory.drags.retain(|drag| drag.object != object);
        self.memory
            .drags
            .push(Drag::new(object, &pose, target, request.seconds));
        // In the order of objects, not of requests: equal runs have equal snapshots.
        self.memory.drags.sort_by_key(|drag| drag.object);
        accepted()
    }

    fn arm_of(&self, request: &OperatorRequest) -> Result<u32, Reply> {
        if (request.arm as usize) < self.arms.len() {
            return Ok(request.arm);
        }
        let message = format!(
            "arm {} is not here; this cell has {}",
            request.arm,
            self.arms.len()
        );
        Err((ReplyCode::UnknownArm, message))
    }

    fn target(&mut self, request: &OperatorRequest) -> Reply {
        let arm = match self.arm_of(request) {
            Ok(arm) => arm,
            Err(reply) => return reply,
        };
        let panel = &mut self.memory.panel;
        // The panel addresses one arm at a time: the hand of the previous arm keeps its last
        // command, which must not become the command of this one.
        if panel.target_arm != arm {
            panel.gripper = GripperGoal::Keep.code();
        }
        panel.target_arm = arm;
        panel.target_position = request.pose.position;
        panel.target_orientation_wxyz = request.pose.orientation_wxyz;
        panel.target_joints = None;
        count(&mut panel.target_seq)
    }

    fn joints(&mut self, request: &OperatorRequest) -> Reply {
        let arm = match self.arm_of(request) {
            Ok(arm) => arm,
            Err(reply) => return reply,
        };
        let robot = self.arms.get(arm as usize).map(|arm| &arm.robot);
        let joints = robot.map_or(&[][..], |robot| &robot.arm_joints);
        let specs = joints.iter().filter_map(|joint| robot?.joints.get(*joint));
        for (place, (spec, position)) in specs.zip(&request.joints).enumerate() {
            if !(spec.lower..=spec.upper).contains(position) {
                let message = format!(
                    "joint {} is {position:.4}; allowed are {:.4} to {:.4}",
                    place + 1,
                    spec.lower,
                    spec.upper
                );
                return (ReplyCode::OutOfRange, message);
            }
        }
        // The pose is that of the tool: a reader of the pose alone does not move the arm.
        let here = convert::to_wire(&self.tcp(arm as usize));
        let panel = &mut self.memory.panel;
        // As for a pose.
        if panel.target_arm != arm {
            panel.gripper = GripperGoal::Keep.code();
        }
        panel.target_arm = arm;
        panel.target_position = here.position;
        panel.target_orientation_wxyz = here.orientation_wxyz;
        panel.target_joints = Some(request.joints);
        count(&mut panel.target_seq)
    }

    fn breakpoint(&mut self, request: &OperatorRequest) -> Reply {
        let (name, breaks) = (request.name.as_str(), &mut self.memory.panel.breaks);
        let known = breaks.iter().position(|known| known == name);
        match (request.count, known) {
            (_, _) if name.is_empty() => {
                let message = "a breakpoint has the name of a node, state or guard".to_owned();
                return (ReplyCode::OutOfRange, message);
            }
            // Setting one again is not an error: the request states a level.
            (1, Some(_)) => {}
            (1, None) if breaks.len() == MAX_BREAKS => {
                let message = format!("there are {MAX_BREAKS} breakpoints; remove one");
                return (ReplyCode::OutOfRange, message);
            }
            (1, None) => breaks.push(name.to_owned()),
            (_, Some(place)) => {
                breaks.remove(place);
            }
            (_, None) => {
                return (
                    ReplyCode::OutOfRange,
                    format!("no breakpoint is named {name:?}"),
                );
            }
        }
        accepted()
    }

    fn gripper(&mut self, request: &OperatorRequest) -> Reply {
        let arm = match self.arm_of(request) {
            Ok(arm) => arm,
            Err(reply) => return reply,
        };
        if self
            .arms
            .get(arm as usize)
            .is_none_or(|arm| arm.robot.gripper.is_none() && arm.robot.suction.is_none())
        {
            return (
                ReplyCode::NotInThisCell,
                "this arm has no gripper".to_owned(),
            );
        }
        // Nor is the target of the previous arm a target of this one: it stays where it is.
        if self.memory.panel.target_arm != arm {
            let here = convert::to_wire(&self.tcp(arm as usize));
            let panel = &mut self.memory.panel;
            panel.target_arm = arm;
            panel.target_position = here.position;
            panel.target_orientation_wxyz = here.orientation_wxyz;
            panel.target_joints = None;
        }
        self.memory.panel.gripper = request.count;
        count(&mut self.memory.panel.gripper_seq)
    }

    fn operator_drops(&mut self, parts: u32) -> Reply {
        let Some(dispenser) = &self.equipment.dispenser else {
            let message = "this cell has no dispenser".to_owned();
            return (ReplyCode::NotInThisCell, message);
        };
        let per_drop = dispenser.table.per_drop;
        let parts = if parts == 0 { per_drop } else { parts };
        // Counted before the request is accepted, so that the answer is true.
        let memory = self.memory.equipment.dispenser.clone();
        let left = dispenser.parts_left(&memory, &self.site());
        if left == 0 {
            let message = "no part is left; a reset of the scene brings them back".to_owned();
            return (ReplyCode::OutOfRange, message);
        }
        if parts > left {
            let message = format!("{parts} parts were asked for and {left} are left");
            return (ReplyCode::OutOfRange, message);
        }
        self.memory.equipment.dispenser.ask(parts);
        count(&mut self.memory.panel.drop_parts)
    }

    fn operator_adds(&mut self, flipped: bool) -> Reply {
        let Some(supply) = &self.equipment.supply else {
            let message = "this cell has no conveyor that brings bins".to_owned();
            return (ReplyCode::NotInThisCell, message);
        };
        let (equipment, mut memory) = (self.equipment, self.memory.equipment.supply.clone());
        let added = supply.add(&mut memory, &mut equipment.way(&mut self.site()), flipped);
        self.memory.equipment.supply = memory;
        if let Err(why) = added {
            let (supply, tick) = (&self.memory.equipment.supply, self.memory.tick);
            let message = self.equipment.supply.as_ref();
            let message = message.map(|table| table.refusal(why, supply, tick));
            return (ReplyCode::OutOfRange, message.unwrap_or_default());
        }
        count(&mut self.memory.panel.add_bin)
    }

    fn start_task(&mut self) -> Reply {
        let panel = &mut self.memory.panel;
        let was_started = std::mem::replace(&mut panel.task_started, true);
        count(&mut panel.task_start);
        match (panel.task_paused, was_started) {
            (true, _) => told("the task is paused; it takes effect at `robocell task resume`"),
            (false, true) => told("it was given before; only a task that failed starts again"),
            (false, false) => accepted(),
        }
    }

    fn reset_task(&mut self) -> Reply {
        let panel = &mut self.memory.panel;
        panel.task_started = false;
        panel.task_paused |= self.reset_pauses;
        count(&mut panel.task_reset);
        if panel.task_paused {
            return told(
                "gripper open, start and targets cleared, arm to default pose, paused until \
                 `robocell task resume`",
            );
        }
        told("start cleared; the job restarts from where the arm is")
    }

    fn pause_task(&mut self, paused: bool) -> Reply {
        let was_paused = std::mem::replace(&mut self.memory.panel.task_paused, paused);
        match (was_paused, paused) {
            (true, true) => told("it was paused before"),
            (false, false) => told("it was not paused"),
            _ => accepted(),
        }
    }

    fn site(&mut self) -> Site<'_> {
        Site {
            engine: self.engine,
            objects: self.objects,
            drags: &mut self.memory.drags,
            arms: &self.memory.arms,
            tick: self.memory.tick,
        }
    }

    fn tcp(&self, arm: usize) -> Isometry3<f64> {
        let arms = self.arms.get(arm).zip(self.measured.get(arm));
        arms.map_or_else(Isometry3::identity, |(arm, measured)| {
            finite_tcp(self.engine, arm, measured)
        })
    }
}

/// The answer to a reset of the scene. If a person paused the task, a reset does not resume
/// it, and the answer reports that.
pub(crate) fn answer_to(reset: Result<(), WorldError>, task_paused: bool) -> Reply {
    match reset {
        Ok(()) if task_paused => told("the task is still paused; `robocell task resume` starts it"),
        Ok(()) => accepted(),
        Err(error) => (ReplyCode::OutOfRange, error.to_string()),
    }
}

fn accepted() -> Reply {
    told("")
}

/// Accepted, with the condition under which the request takes effect.
fn told(message: &str) -> Reply {
    (ReplyCode::Accepted, message.to_owned())
}

/// Counts a request; 0 remains "never".
fn count(counter: &mut u32) -> Reply {
    *counter = counter.checked_add(1).unwrap_or(1);
    accepted()
}

//! The operator as a component of the world: the panel, the drags, and the requests that change
//! them.

use ipc_types::operator::ReplyCode;
use ipc_types::{GripperGoal, MAX_BREAKS, MAX_JOINTS, OperatorPanel, OperatorRequest, Pose};
use nalgebra::Isometry3;
use rapier3d_f64::prelude::RigidBody;

use crate::arm::arms::Arms;
use crate::arm::multibody::Arm;
use crate::engine::convert;
use crate::engine::settings::GRAVITY;
use crate::engine::simulation::Engine;
use crate::error::WorldError;
use crate::operator::contact_stop::Place;
use crate::operator::drag::{Drags, MAX_FORCE_N};
use crate::operator::panel::Panel;
use crate::state::touching;

/// An answer: a code, and a sentence for the person: the reason of a refusal, or the condition
/// under which an accepted request takes effect.
pub(crate) type Reply = (ReplyCode, String);

/// The operator's panel and drags.
pub(crate) struct Operator {
    panel: Panel,
    drags: Drags,
    /// A reset of the task leaves it paused.
    reset_pauses: bool,
}

impl Operator {
    /// Without a request so far.
    pub(crate) fn new(reset_pauses: bool) -> Self {
        Self {
            panel: Panel::NEW,
            drags: Drags::default(),
            reset_pauses,
        }
    }

    /// Pulls the dragged objects.
    pub(crate) fn before_step(&mut self, engine: &mut Engine) {
        self.drags.pull(engine);
    }

    /// Ends a target at a contact: the arm stays where it is. `held` gives the object that an arm
    /// holds.
    pub(crate) fn after_step(
        &mut self,
        engine: &Engine,
        arms: &Arms,
        held: impl Fn(usize) -> Option<usize>,
    ) {
        if !self.panel.contact.is_on || !self.panel.task_paused {
            return;
        }
        let arm = self.panel.target_arm;
        let index = arm as usize;
        let pressure = touching::pressure(engine.rapier(), index, held(index));
        let tool = tool(engine, arms, arm);
        let here = Place {
            position: tool.position,
            orientation_wxyz: tool.orientation_wxyz,
            joints: arms.controlled_positions(index),
        };
        if let Some(stay) = self.panel.contact.update(&pressure, here) {
            let joints = self.panel.target_joints.map(|_| stay.joints);
            let pose = Pose {
                position: stay.position,
                orientation_wxyz: stay.orientation_wxyz,
            };
            // A new target, so that the controller does not continue to the old one.
            let _counted = self.aim(arm, pose, joints);
        }
    }

    /// The drags, for equipment that takes objects out of the cell.
    pub(crate) fn drags_mut(&mut self) -> &mut Drags {
        &mut self.drags
    }

    /// Whether an object is dragged.
    pub(crate) fn is_dragged(&self, object: usize) -> bool {
        self.drags.contains(object)
    }

    /// Whether the operator paused the task.
    pub(crate) fn task_is_paused(&self) -> bool {
        self.panel.task_paused
    }

    /// Orientation last requested for `arm` (w, x, y, z).
    pub(crate) fn target_orientation(&self, arm: u32) -> Option<[f64; 4]> {
        let panel = &self.panel;
        let is_set = panel.target_seq > 0 && panel.target_arm == arm;
        is_set.then_some(panel.target_orientation_wxyz)
    }

    /// The panel as it is published.
    pub(crate) fn report(&self) -> OperatorPanel {
        self.panel.to_wire()
    }

    /// Its two parts of a snapshot.
    pub(crate) fn save(&self) -> (&Drags, &Panel) {
        (&self.drags, &self.panel)
    }

    /// Continues from a snapshot.
    pub(crate) fn restore(&mut self, drags: Drags, panel: Panel) {
        (self.drags, self.panel) = (drags, panel);
    }

    /// Ends the drags with the scene; the requests continue.
    pub(crate) fn reset(&mut self) {
        self.drags = Drags::default();
        self.panel.scene_reset = self.panel.scene_reset.wrapping_add(1);
        self.panel.contact.end();
    }
}

/// The requests.
impl Operator {
    /// Drags an object to the place of the request.
    pub(crate) fn start_drag(&mut self, engine: &Engine, request: &OperatorRequest) -> Reply {
        let object = request.object as usize;
        let pose = engine.object_pose(object);
        let here = pose.filter(|_| engine.is_here(object));
        let Some(pose) = here else {
            let count = engine.objects().len();
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
        self.drags.start(object, &pose, target, request.seconds);
        let mass_kg = engine.object(object).map_or(0.0, RigidBody::mass);
        let weight_n = mass_kg * GRAVITY[2].abs();
        if weight_n > MAX_FORCE_N {
            return accepted_but(&format!(
                "{mass_kg:.1} kg weigh {weight_n:.0} N: a drag pulls with at most \
                 {MAX_FORCE_N:.0} N and does not lift it"
            ));
        }
        accepted()
    }

    /// Sets the pose to which an arm moves.
    pub(crate) fn set_target(&mut self, arms: &Arms, request: &OperatorRequest) -> Reply {
        match arm_of(arms, request) {
            Ok(arm) => {
                self.panel.contact.start(request.contact_limit);
                self.aim(arm, request.pose, None)
            }
            Err(reply) => reply,
        }
    }

    /// Sets the joint positions to which an arm moves.
    pub(crate) fn set_joints(
        &mut self,
        engine: &Engine,
        arms: &Arms,
        request: &OperatorRequest,
    ) -> Reply {
        let arm = match arm_of(arms, request) {
            Ok(arm) => arm,
            Err(reply) => return reply,
        };
        let robot = arms.bodies().get(arm as usize).map(Arm::robot);
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
        self.panel.contact.start(request.contact_limit);
        // The pose is that of the tool: a reader of the pose alone does not move the arm.
        self.aim(arm, tool(engine, arms, arm), Some(request.joints))
    }

    fn aim(&mut self, arm: u32, pose: Pose, joints: Option<[f64; MAX_JOINTS]>) -> Reply {
        // The panel addresses one arm at a time: the gripper of the previous arm keeps its last
        // command, which must not become the command of this one.
        if self.panel.target_arm != arm {
            self.panel.gripper = GripperGoal::Keep.code();
        }
        self.address(arm, pose, joints);
        count(&mut self.panel.target_seq)
    }

    fn address(&mut self, arm: u32, pose: Pose, joints: Option<[f64; MAX_JOINTS]>) {
        let panel = &mut self.panel;
        panel.target_arm = arm;
        panel.target_position = pose.position;
        panel.target_orientation_wxyz = pose.orientation_wxyz;
        panel.target_joints = joints;
    }

    /// Sets a breakpoint of the task, or removes it.
    pub(crate) fn set_breakpoint(&mut self, request: &OperatorRequest) -> Reply {
        let (name, breaks) = (request.name.as_str(), &mut self.panel.breaks);
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

    /// Commands the gripper of an arm.
    pub(crate) fn command_gripper(
        &mut self,
        engine: &Engine,
        arms: &Arms,
        request: &OperatorRequest,
    ) -> Reply {
        let arm = match arm_of(arms, request) {
            Ok(arm) => arm,
            Err(reply) => return reply,
        };
        let robot = arms.bodies().get(arm as usize).map(Arm::robot);
        if robot.is_none_or(|robot| robot.gripper.is_none() && robot.suction.is_none()) {
            return (
                ReplyCode::NotInThisCell,
                "this arm has no gripper".to_owned(),
            );
        }
        // Nor is the target of the previous arm a target of this one: it stays where it is.
        if self.panel.target_arm != arm {
            self.address(arm, tool(engine, arms, arm), None);
        }
        self.panel.gripper = request.count;
        count(&mut self.panel.gripper_seq)
    }

    /// Counts a request that the equipment answered with `done`.
    pub(crate) fn count_drop(&mut self, done: Result<(), Reply>) -> Reply {
        done.map_or_else(|refused| refused, |()| count(&mut self.panel.drop_parts))
    }

    /// As [`Operator::count_drop`], for a bin.
    pub(crate) fn count_bin(&mut self, done: Result<(), Reply>) -> Reply {
        done.map_or_else(|refused| refused, |()| count(&mut self.panel.add_bin))
    }

    /// Gives the task its start event.
    pub(crate) fn start_task(&mut self) -> Reply {
        let panel = &mut self.panel;
        let was_started = std::mem::replace(&mut panel.task_started, true);
        count(&mut panel.task_start);
        match (panel.task_paused, was_started) {
            (true, _) => {
                accepted_but("the task is paused; it takes effect at `robocell task resume`")
            }
            (false, true) => {
                accepted_but("it was given before; only a task that failed starts again")
            }
            (false, false) => accepted(),
        }
    }

    /// Sets the task back to its start.
    pub(crate) fn reset_task(&mut self) -> Reply {
        let panel = &mut self.panel;
        panel.task_started = false;
        panel.task_paused |= self.reset_pauses;
        panel.contact.end();
        count(&mut panel.task_reset);
        if panel.task_paused {
            return accepted_but(
                "gripper open, start and targets cleared, arm to default pose, paused until \
                 `robocell task resume`",
            );
        }
        accepted_but("start cleared; the job restarts from where the arm is")
    }

    /// Pauses the task, or resumes it.
    pub(crate) fn pause_task(&mut self, paused: bool) -> Reply {
        let was_paused = std::mem::replace(&mut self.panel.task_paused, paused);
        if was_paused != paused {
            self.panel.contact.end();
        }
        match (was_paused, paused) {
            (true, true) => accepted_but("it was paused before"),
            (false, false) => accepted_but("it was not paused"),
            _ => accepted(),
        }
    }

    /// The answer to a reset of the scene. If a person paused the task, a reset does not resume
    /// it, and the answer reports that.
    pub(crate) fn answer_to_reset(&self, reset: Result<(), WorldError>) -> Reply {
        match reset {
            Ok(()) if self.panel.task_paused => {
                accepted_but("the task is still paused; `robocell task resume` starts it")
            }
            Ok(()) => accepted(),
            Err(error) => (ReplyCode::OutOfRange, error.to_string()),
        }
    }
}

fn arm_of(arms: &Arms, request: &OperatorRequest) -> Result<u32, Reply> {
    let count = arms.bodies().len();
    if (request.arm as usize) < count {
        return Ok(request.arm);
    }
    let message = format!("arm {} is not here; this cell has {count}", request.arm);
    Err((ReplyCode::UnknownArm, message))
}

fn tool(engine: &Engine, arms: &Arms, arm: u32) -> Pose {
    let tcp = arms.tcp(engine, arm as usize);
    convert::to_wire(&tcp.unwrap_or_else(Isometry3::identity))
}

/// Accepted without a condition.
pub(crate) fn accepted() -> Reply {
    accepted_but("")
}

/// Accepted, with the condition under which the request takes effect.
fn accepted_but(message: &str) -> Reply {
    (ReplyCode::Accepted, message.to_owned())
}

/// Counts a request; 0 remains "never".
fn count(counter: &mut u32) -> Reply {
    *counter = counter.checked_add(1).unwrap_or(1);
    accepted()
}

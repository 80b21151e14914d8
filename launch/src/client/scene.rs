//! Where everything in a cell is, for `status`.

use cell_model::Cell;
use ipc_types::arm::{NotReached, StopAction, StopCause};
use ipc_types::equipment::SuctionRefusal;
use ipc_types::world::{OBJECT_DRAGGED, OBJECT_ENABLED};
use ipc_types::{ArmState, ArmStatus, Pose, WorldState};
use schemars::JsonSchema;
use serde::Serialize;

/// Position (m) and orientation in the world frame.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Place {
    pub(super) position: [f64; 3],
    orientation_wxyz: [f64; 4],
}

impl From<&Pose> for Place {
    fn from(pose: &Pose) -> Self {
        Self {
            position: pose.position,
            orientation_wxyz: pose.orientation_wxyz,
        }
    }
}

/// An arm as measured.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ArmReport {
    name: String,
    joint_positions: Vec<f64>,
    tcp: Place,
    /// The object in the gripper.
    holds: Option<String>,
    /// Whether the arm has a gripper or a cup.
    has_gripper: bool,
    /// What stops the arm, if anything does.
    stop: Option<String>,
    suction: Option<SuctionReport>,
    /// Why the arm does not reach its goal: `unreachable`, `joint_limit`, `blocked`,
    /// `singular`, `local_minimum` or `in_collision`.
    not_reached: Option<String>,
    limit_violations: u64,
    obstacle_contacts: u64,
    self_contacts: u64,
}

/// A suction gripper.
#[derive(Debug, Serialize, JsonSchema)]
struct SuctionReport {
    on: bool,
    attached: bool,
    /// Switchings-on that attached nothing.
    refused: u32,
    /// Why the last of them did not.
    refused_because: Option<&'static str>,
    /// Grips that broke.
    broke: u32,
}

/// An object that is in the cell.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ObjectReport {
    name: String,
    #[serde(flatten)]
    place: Place,
    /// The arm that holds it.
    held_by: Option<String>,
    /// The operator drags it.
    dragged: bool,
}

/// The arms of `cell` in `state`; `said` is what their controllers say.
pub(super) fn arms(cell: &Cell, state: &WorldState, said: &[Option<&ArmStatus>]) -> Vec<ArmReport> {
    let specs = cell.arms.iter().zip(state.arms()).enumerate();
    let report = |(index, (spec, arm)): (usize, (&cell_model::ArmSpec, &ArmState))| {
        let count = (arm.joint_count as usize).min(arm.joint_positions.len());
        let has_cup = spec.robot.suction.is_some();
        // A state carries the action of physics without its cause.
        let ours = stop(arm.stop_action, None);
        let said = said.get(index).copied().flatten();
        let theirs = said.and_then(|said| stop(said.stop_action, Some(said.stop_cause)));
        let reason = said.and_then(|said| NotReached::from_code(said.not_reached));
        let reason = reason.filter(|reason| *reason != NotReached::None);
        ArmReport {
            name: spec.name.clone(),
            joint_positions: arm.joint_positions[..count].to_vec(),
            tcp: (&arm.tcp).into(),
            holds: held(cell, arm).map(|object| object.name.clone()),
            stop: ours.or(theirs),
            has_gripper: has_cup || spec.robot.gripper.is_some(),
            suction: has_cup.then(|| suction(arm)),
            not_reached: reason.map(|reason| reason.name().to_owned()),
            limit_violations: arm.limit_violations,
            obstacle_contacts: arm.obstacle_contacts,
            self_contacts: arm.self_contacts,
        }
    };
    specs.map(report).collect()
}

fn held<'c>(cell: &'c Cell, arm: &ArmState) -> Option<&'c cell_model::ObjectSpec> {
    let index = (arm.gripper.held_object as usize).checked_sub(1)?;
    cell.objects.get(index)
}

/// A stop in words; `None` where there is none.
pub(super) fn stop(action: u32, cause: Option<u32>) -> Option<String> {
    let action = match StopAction::from_code(action)? {
        StopAction::None => return None,
        StopAction::Hold => "holds",
        StopAction::Stop1 => "category 1 stop",
        StopAction::Stop0 => "category 0 stop",
    };
    let why = match cause.and_then(StopCause::from_code) {
        None | Some(StopCause::None) => return Some(action.to_owned()),
        Some(StopCause::DecisionLost) => "no decision of the task",
        Some(StopCause::CommandLost) => "no command of the controller",
        Some(StopCause::TrackingError) => "something blocks it",
        Some(StopCause::Quarantine) => "the physics engine disabled it",
    };
    Some(format!("{action}: {why}"))
}

fn suction(arm: &ArmState) -> SuctionReport {
    let gripper = &arm.gripper;
    SuctionReport {
        on: gripper.suction == 1,
        attached: gripper.attached == 1,
        refused: gripper.refusals,
        refused_because: refusal(gripper.refusal).filter(|_| gripper.refusals > 0),
        broke: gripper.breaks,
    }
}

/// Why suction attached nothing.
pub(super) fn refusal(code: u32) -> Option<&'static str> {
    match SuctionRefusal::from_code(code)? {
        SuctionRefusal::None => None,
        SuctionRefusal::NothingThere => Some("nothing was in front of the cup"),
        SuctionRefusal::NotMovable => Some("the object there cannot be moved"),
        SuctionRefusal::TooOblique => Some("the surface was too oblique"),
    }
}

/// The objects of `cell` that are in the cell in `state`.
pub(super) fn objects(cell: &Cell, state: &WorldState) -> Vec<ObjectReport> {
    let holder = |index: usize| {
        let arms = cell.arms.iter().zip(state.arms());
        let mut holders = arms.filter(|(_, arm)| arm.gripper.held_object as usize == index + 1);
        holders.next().map(|(spec, _)| spec.name.clone())
    };
    let specs = cell.objects.iter().zip(state.objects()).enumerate();
    let here = specs.filter(|(_, (_, object))| object.flags & OBJECT_ENABLED != 0);
    here.map(|(index, (spec, object))| ObjectReport {
        name: spec.name.clone(),
        place: (&object.pose).into(),
        held_by: holder(index),
        dragged: object.flags & OBJECT_DRAGGED != 0,
    })
    .collect()
}

impl std::fmt::Display for ArmReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ([x, y, z], name) = (self.tcp.position, &self.name);
        write!(f, "arm {name}: tool at {x:.3} {y:.3} {z:.3} m, ")?;
        match &self.holds {
            _ if !self.has_gripper => f.write_str("no gripper")?,
            None => f.write_str("holds nothing")?,
            Some(object) => write!(f, "holds {object}")?,
        }
        if let Some(cup) = &self.suction {
            write!(f, ", suction {}", if cup.on { "on" } else { "off" })?;
            if let Some(why) = cup.refused_because {
                write!(f, ", refused {} times, the last as {why}", cup.refused)?;
            }
        }
        if let Some(stop) = &self.stop {
            write!(f, "; {stop}")?;
        }
        match &self.not_reached {
            Some(why) => write!(f, "; not at its goal: {why}"),
            None => Ok(()),
        }
    }
}

impl std::fmt::Display for ObjectReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ([x, y, z], name) = (self.place.position, &self.name);
        write!(f, "  {name:<16} {x:>7.3} {y:>7.3} {z:>7.3} m")?;
        match &self.held_by {
            Some(arm) => write!(f, ", held by {arm}"),
            None if self.dragged => f.write_str(", dragged by the operator"),
            None => Ok(()),
        }
    }
}

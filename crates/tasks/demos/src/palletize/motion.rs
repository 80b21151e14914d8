//! The goal of the arm in a step, and whether the step has ended.

use ipc_types::decision::GoalKind;
use nalgebra::{Isometry3, Translation3, Vector3};
use robocell_skills::setup::ARM;
use robocell_skills::{KeptPose, Waypoint, pose};
use robocell_task::{Job, Output, PolicyTime};

use super::geometry::{self, Lie, lie};
use super::memory::{Memory, Work};
use super::numbers::{GoTable, Suction, Target};
use super::scene::View;
use super::setup::PalletizeSetup;
use super::steps::Step;
use crate::failure::Failure;

/// Suction that has not released after this is blocked (s).
const RELEASE_TIMEOUT_S: f64 = 5.0;
/// Suction is given this long at least before the next motion starts (s).
const RELEASE_S: f64 = 0.05;
/// Tolerance for the target of a lift (m): it stays `lead_m` ahead of the tool, so its height
/// decides and not the distance.
const NEAR_AHEAD_M: f64 = 1.0;
/// Tolerance that every rotation meets (rad): larger than pi.
const ANY_ANGLE_RAD: f64 = 4.0;

/// A waypoint to the rest pose from anywhere, also with the tool pointing up.
pub(super) fn home_by_joints(setup: &PalletizeSetup) -> Waypoint {
    Waypoint::new(pose::wire(&setup.home)).by_joints(setup.home_joints)
}

/// The waypoint of a step; `None` if the bin cannot be gripped.
pub(super) fn waypoint(view: &View<'_>, work: &Work, go: &GoTable) -> Option<Waypoint> {
    let setup = view.setup;
    let base = work.base.isometry();
    let with = |offset: Vector3<f64>| {
        let at = Translation3::from(base.translation.vector + offset);
        Isometry3::from_parts(at, base.rotation)
    };
    let mut approach = go.approach_m;
    let target = match go.to {
        // Aimed again in every decision: a bin on the belt may still move.
        Target::Bin { gap_m, approach_m } => {
            let (shape, bin) = (&setup.bins.get(work.bin)?.shape, view.bin(work.bin)?);
            let (tool, jig) = (&view.tool.rotation, &setup.jig.rotation);
            let target = geometry::grasp(&bin.pose, shape, gap_m, tool, jig)?;
            approach = (target.rotation * Vector3::x() * approach_m).into();
            target
        }
        Target::Up { by_m, lead_m } => {
            // `lead_m` ahead of the tool, up to the whole lift: far from its target the arm
            // turns its tool freely, and the bin would swing.
            let lifted = view.tool.translation.z - base.translation.z;
            with(Vector3::z() * (lifted.max(0.0) + lead_m).min(by_m))
        }
        Target::Home { .. } => setup.home,
        Target::Jig {} => setup.jig,
        Target::Back { by_m, aside_m } => {
            let way = base.rotation * Vector3::x() * -by_m + Vector3::from(aside_m);
            approach = way.into();
            with(way)
        }
        Target::Via { position_m } => {
            Isometry3::from_parts(Translation3::from(position_m), base.rotation)
        }
        Target::Slot { gap_m } => {
            let [x, y] = work.creep;
            with(Vector3::new(x, y, gap_m))
        }
    };
    // Joints that are named, those at the start of the step, or those of the rest pose, in this
    // order.
    let posture = match go.posture {
        Some(posture) => super::setup::joints(&posture),
        None if go.keeps_posture => work.joints,
        None => setup.home_joints,
    };
    let waypoint = Waypoint::new(pose::wire(&target)).through(approach, go.std_dev_m);
    Some(match go.to {
        Target::Home { by_joints: true } => waypoint.by_joints(posture),
        _ => waypoint.leaning(posture),
    })
}

/// Moves the target of a bin near its place by a part of its error, in every decision.
pub(super) fn creep(work: &mut Work, view: &View<'_>) {
    let (most, gain) = (view.setup.task.creep_m, view.setup.task.creep_gain);
    let Some(off) = view.off_place(work) else {
        return;
    };
    // Far from its place the error is the way that is left, not an error of the grip.
    if off.xy().norm() >= most || off.z.abs() >= most {
        return;
    }
    for (crept, missing) in work.creep.iter_mut().zip([off.x, off.y]) {
        // Bounded, so that a bin that is blocked does not push the target ever farther.
        *crept = (*crept + gain * missing).clamp(-most, most);
    }
}

/// Progress of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    /// The step is in progress.
    Running,
    /// The step has ended.
    Done,
    /// The step will not succeed; the reason applies if that happens again and again.
    Missed(Failure),
}

/// The inputs for the judgement of a step.
pub(super) struct Judge<'a> {
    pub(super) view: &'a View<'a>,
    pub(super) memory: &'a Memory,
    pub(super) job: &'a Job,
    pub(super) out: &'a Output,
}

impl Judge<'_> {
    /// Progress of `step` of `work`.
    pub(super) fn progress(&self, work: &Work, step: &Step) -> Progress {
        let table = &step.table;
        match (table.wait_s, &table.go, table.suction) {
            // The belt stops with the decision before this one: the wait starts once it is at
            // rest.
            (Some(_), ..) if table.stops_belt && work.from_belt && self.job.io.conveyor_running => {
                Progress::Running
            }
            (Some(wait), ..) => done_if(self.past(work, wait)),
            (None, Some(go), _) => {
                // Arrival is looked at first: a step that arrives in its last tick is not late.
                let late = self.past(work, self.view.setup.task.reach_timeout_s);
                match (self.arrived(work, go), late) {
                    (true, _) => Progress::Done,
                    (false, true) => Progress::Missed(self.failure(work, go)),
                    (false, false) => Progress::Running,
                }
            }
            (None, None, Some(Suction::Off)) => self.released(work),
            (None, None, _) => self.attached(work),
        }
    }

    fn arrived(&self, work: &Work, go: &GoTable) -> bool {
        let angle = go.angle_tolerance_rad.unwrap_or(ANY_ANGLE_RAD);
        // Each target has its own criterion: a lift its height, a bin its pose, a slot the bin
        // itself.
        match go.to {
            Target::Up { by_m, .. } => {
                let wanted = work.base.isometry().translation.z + by_m;
                self.reached(NEAR_AHEAD_M, ANY_ANGLE_RAD)
                    && self.view.tool.translation.z > wanted - go.tolerance_m
            }
            Target::Bin { .. } => !self.leans(work) && self.reached(go.tolerance_m, angle),
            Target::Slot { .. } => {
                let off = self.view.off_place(work).map(|off| off.xy().norm());
                self.reached(go.tolerance_m, angle) && off.is_none_or(|off| off < go.tolerance_m)
            }
            _ => self.reached(go.tolerance_m, angle),
        }
    }

    fn failure(&self, work: &Work, go: &GoTable) -> Failure {
        match go.to {
            Target::Bin { .. } if self.leans(work) => Failure::BinCannotBeGripped,
            Target::Bin { .. } => Failure::BinOutOfReach,
            Target::Jig {} | Target::Slot { .. } => Failure::BinCannotBePlaced,
            // Open ways in free space fail only for the arm's own reasons.
            _ => Failure::ArmCaught,
        }
    }

    /// Whether the step has lasted for `seconds`.
    fn past(&self, work: &Work, seconds: f64) -> bool {
        self.view.now.since(work.began) >= PolicyTime::from_seconds(seconds)
    }

    fn released(&self, work: &Work) -> Progress {
        match (self.view.cup_taken, self.past(work, RELEASE_TIMEOUT_S)) {
            (false, _) => done_if(self.past(work, RELEASE_S)),
            (true, true) => Progress::Missed(Failure::GripperBlocked),
            (true, false) => Progress::Running,
        }
    }

    /// Whether the bin leans: suction finds no level floor on it.
    fn leans(&self, work: &Work) -> bool {
        let seen = self.view.bin(work.bin);
        seen.is_some_and(|seen| lie(&seen.pose) == Lie::Tilted)
    }

    fn attached(&self, work: &Work) -> Progress {
        let view = self.view;
        let late = self.past(work, view.setup.task.attach_timeout_s);
        match view.attached {
            Some(bin) if bin == work.bin => Progress::Done,
            // A refusal since the start of the step, or another object on the cup: no bin will
            // follow.
            _ if late || view.refusals != work.refusals || view.cup_taken => {
                Progress::Missed(Failure::BinCannotBeGripped)
            }
            _ => Progress::Running,
        }
    }

    /// Whether the goal of this very step is followed and the tool is there. A goal of another
    /// step, or of the operator, is not counted.
    fn reached(&self, tolerance: f64, angle: f64) -> bool {
        let key = self.job.newest_key;
        let previous = self.out.previous(ARM);
        let Some(sent) = previous.filter(|p| p.key == key && p.kind != GoalKind::Hold) else {
            return false;
        };
        let echo = self.view.observation.echo(ARM);
        let followed = echo.is_some_and(|e| e.goal_active && e.goal_id == sent.goal_id);
        let near = self.memory.path.end().is_some_and(|end| {
            let target = KeptPose::from(end.pose()).isometry();
            let off = self.view.tool.translation.vector - target.translation.vector;
            let turned = self.view.tool.rotation.angle_to(&target.rotation);
            off.norm() < tolerance && turned < angle
        });
        followed && near
    }
}

fn done_if(over: bool) -> Progress {
    if over {
        Progress::Done
    } else {
        Progress::Running
    }
}

//! Whether a substep is over.

use ipc_types::decision::GoalKind;
use nalgebra::Isometry3;

use super::geometry::{Lie, lie};
use super::memory::{Motion, Work, WorkKind};
use super::scene::View;
use super::setup::PalletizeSetup;
use super::steps::Step;
use crate::failure::Failure;
use robocell_skills::setup::ARM;
use robocell_task::job::Job;
use robocell_task::observation::Observation;
use robocell_task::output::Output;
use robocell_task::time::PolicyTime;

/// Suction has let go at the latest after this (s).
const RELEASE_TIMEOUT_S: f64 = 5.0;
/// And is given this long at least (s).
const RELEASE_S: f64 = 0.05;

/// How a substep stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    /// It goes on.
    Running,
    /// It is over.
    Done,
    /// It will not end well; what to call it if it happens again and again.
    Missed(Failure),
}

/// What a substep is judged by.
pub(super) struct Judge<'a> {
    /// The job's numbers.
    pub(super) setup: &'a PalletizeSetup,
    /// What is seen.
    pub(super) scene: &'a View<'a>,
    /// The sample.
    pub(super) observation: &'a Observation<'a>,
    /// Where the arm was sent.
    pub(super) motion: Option<&'a Motion>,
}

impl Judge<'_> {
    /// How `step` of `work` stands.
    pub(super) fn progress(&self, work: &Work, step: Step, job: &Job, out: &Output) -> Progress {
        if let Some((there, failure)) = self.arrival(work, step, job, out) {
            let late = self.past(work, self.setup.numbers.reach_timeout_s);
            return match (there, late) {
                (true, _) => Progress::Done,
                (false, true) => Progress::Missed(failure),
                (false, false) => Progress::Running,
            };
        }
        let numbers = &self.setup.numbers;
        let timed = |seconds: f64| done_if(self.past(work, seconds));
        match step {
            // The belt has been told to stop by the decision before.
            Step::WaitForBin if work.from_belt && job.io.conveyor_running => Progress::Running,
            Step::WaitForBin => timed(numbers.pick.wait_s),
            Step::WaitAtBin => timed(numbers.pick.settle_s),
            Step::WaitAfterRelease => timed(numbers.flip.wait_s),
            Step::WaitAtPlace => timed(numbers.place.settle_s),
            Step::TimedLift if work.kind == WorkKind::PickFlipped => {
                timed(numbers.pick.flip_lift_s)
            }
            Step::TimedLift => timed(numbers.place.lift_s),
            Step::OpenSuctionGripper => self.released(work),
            _ => self.attached(work),
        }
    }

    /// Whether a step that ends with the tool at its target has ended, and what to
    /// call it if it never does; `None` for the other steps.
    fn arrival(&self, work: &Work, step: Step, job: &Job, out: &Output) -> Option<(bool, Failure)> {
        let numbers = &self.setup.numbers;
        let (pick, angle) = (&numbers.pick, numbers.pick.angle_tolerance_rad);
        let at = |tolerance: f64, angle: f64| self.reached(job, out, tolerance, angle);
        Some(match step {
            Step::ReachToPick if self.leans(work) => (false, Failure::BinCannotBeGripped),
            Step::ReachToPick => (at(pick.tolerance_m, angle), Failure::BinOutOfReach),
            Step::LiftToClearance => (
                at(NEAR_AHEAD, ANY_ANGLE) && self.lifted(work),
                Failure::ArmCaught,
            ),
            Step::OrientToHome => {
                let home = &numbers.home;
                let there = at(home.tolerance_m, home.angle_tolerance_rad);
                (there, Failure::ArmCaught)
            }
            Step::MoveToFlipStation => (
                at(numbers.flip.tolerance_m, angle),
                Failure::BinCannotBePlaced,
            ),
            Step::ReleaseFlipStationBin => (
                at(numbers.flip.retreat_tolerance_m, ANY_ANGLE),
                Failure::ArmCaught,
            ),
            Step::LeaveFlipStation => (
                at(numbers.flip.leave_tolerance_m, ANY_ANGLE),
                Failure::ArmCaught,
            ),
            Step::SwingOut => (
                at(numbers.place.swing_tolerance_m, ANY_ANGLE),
                Failure::ArmCaught,
            ),
            Step::ReachToPlace => {
                let tolerance = numbers.place.tolerance_m;
                let off = self.off_place(work);
                let there = at(tolerance, angle) && off.is_none_or(|off| off < tolerance);
                (there, Failure::BinCannotBePlaced)
            }
            _ => return None,
        })
    }

    /// The step has lasted that long (s).
    fn past(&self, work: &Work, seconds: f64) -> bool {
        let since = self.observation.time().since(work.began);
        since >= PolicyTime::from_seconds(seconds)
    }

    fn released(&self, work: &Work) -> Progress {
        match (self.scene.cup_taken, self.past(work, RELEASE_TIMEOUT_S)) {
            (false, _) => done_if(self.past(work, RELEASE_S)),
            (true, true) => Progress::Missed(Failure::GripperBlocked),
            (true, false) => Progress::Running,
        }
    }

    /// Suction finds no level floor on a bin that leans.
    fn leans(&self, work: &Work) -> bool {
        let seen = self.scene.bin(work.bin);
        seen.is_some_and(|seen| lie(&seen.pose) == Lie::Tilted)
    }

    /// The tool is as high as it shall be.
    fn lifted(&self, work: &Work) -> bool {
        let numbers = &self.setup.numbers.pick;
        let wanted = work.base.isometry().translation.z + numbers.lift_m;
        self.scene.tool.translation.z > wanted - numbers.lift_tolerance_m
    }

    fn attached(&self, work: &Work) -> Progress {
        let late = self.past(work, self.setup.numbers.pick.attach_timeout_s);
        match self.scene.attached {
            Some(bin) if bin == work.bin => Progress::Done,
            _ if late || self.scene.refusals != work.refusals || self.scene.cup_taken => {
                Progress::Missed(Failure::BinCannotBeGripped)
            }
            _ => Progress::Running,
        }
    }

    /// Distance of the bin from its place, in the plane (m).
    pub(super) fn off_place(&self, work: &Work) -> Option<f64> {
        let slot = self.setup.slots.get(work.slot?)?;
        let bin = self.scene.bin(work.bin)?;
        let off = bin.pose.translation.vector - slot.translation.vector;
        Some(off.xy().norm())
    }

    /// The goal of this very substep is followed, and the tool is there. What was
    /// said for another substep, or by the operator, says nothing about this one.
    fn reached(&self, job: &Job, out: &Output, tolerance: f64, angle: f64) -> bool {
        let key = u64::from(job.counters.phase_entry);
        let previous = out.previous(ARM);
        let Some(previous) = previous.filter(|p| p.key == key && p.kind != GoalKind::Hold) else {
            return false;
        };
        let echo = self.observation.echo(ARM);
        let followed = echo.is_some_and(|e| e.goal_active && e.goal_id == previous.goal_id);
        let near = self.motion.is_some_and(|motion| {
            near(
                &self.scene.tool,
                &motion.target.isometry(),
                tolerance,
                angle,
            )
        });
        followed && near
    }
}

/// Every rotation is nearer than that (rad).
const ANY_ANGLE: f64 = 4.0;
/// The target of a lift stays within reach of the tool, so it only has to be
/// followed (m).
const NEAR_AHEAD: f64 = 1.0;

fn near(tool: &Isometry3<f64>, target: &Isometry3<f64>, tolerance: f64, angle: f64) -> bool {
    let off = tool.translation.vector - target.translation.vector;
    off.norm() < tolerance && tool.rotation.angle_to(&target.rotation) < angle
}

fn done_if(over: bool) -> Progress {
    if over {
        Progress::Done
    } else {
        Progress::Running
    }
}

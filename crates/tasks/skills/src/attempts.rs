//! Failures with objects, and the end of a job after too many of them.

use behavior::Status;
use cell_model::robots::dynamics::GRAVITY;
use grasp::{Exclusion, arm_in_the_way};
use ipc_types::Pose;
use ipc_types::equipment::{BreakCause, BreakLimit};
use robocell_task::job::Attempts;
use robocell_task::{PolicyTime, Reason, TraceEvent};

use crate::geometry;
use crate::pose::isometry;
use crate::progress::Step;
use crate::refusal::Refusal;
use crate::setup::Tool;
use crate::suction;
use crate::world::World;

/// Time for which an object out of reach is waited for (s); the operator may bring it back.
const REACH_PATIENCE_S: f64 = 10.0;
/// Time for which another arm in the way is waited for, and another object, which may still
/// move (s).
const ARM_PATIENCE_S: f64 = 10.0;
const OBJECT_PATIENCE_S: f64 = 0.8;
/// Share of the force limit of a cup beyond which a weight leaves nothing for the motion.
const HEAVY: f64 = 0.8;
/// A motion ends at another arm that is nearer to its end than this (m).
const ARM_CLEARANCE_M: f64 = 0.05;
/// An object nearer to its position in the cell file was not moved (m).
const MOVED_M: f64 = 0.01;

/// Why a cup lost an object.
pub(crate) struct BrokenGrip {
    /// Its weight broke the grip: another attempt ends the same way.
    pub(crate) is_too_heavy: bool,
    /// For the log, with force and limit.
    pub(crate) why: String,
}

impl World<'_> {
    /// The arm's failures with an object.
    pub fn attempts(&self, object: usize) -> Attempts {
        self.job.attempts(self.arm, object)
    }

    /// The arm's failures with an object, to change.
    pub fn attempts_mut(&mut self, object: usize) -> Option<&mut Attempts> {
        self.job.attempts_mut(self.arm, object)
    }

    /// Ends the wait of [`World::wait_for_reach`].
    pub fn note_in_reach(&mut self) {
        if let Some(wait) = self.job.unreachable_since.get_mut(self.arm) {
            *wait = None;
        }
    }

    /// Counts a drop, and logs it.
    pub fn note_drop(&mut self, object: usize) {
        self.job.counters.drops += 1;
        let setup = self.setup;
        let name = setup.object_name(object);
        self.out.event(
            TraceEvent::Drop,
            format_args!("[drop] {name} left the gripper"),
        );
    }

    /// Counts that an object moved before it was gripped, and logs it.
    pub fn note_resync(&mut self, object: usize) {
        self.job.counters.resyncs += 1;
        let setup = self.setup;
        let name = setup.object_name(object);
        self.out
            .event(TraceEvent::Resync, format_args!("[resync] {name} moved"));
    }

    /// Counts a failed pick-up of an object, `why`. After `most` in a row the job fails with
    /// `reason`.
    pub fn count_failed_pick(&mut self, object: usize, most: u32, reason: &str, why: &str) {
        let Some(attempts) = self.attempts_mut(object) else {
            return;
        };
        attempts.pick += 1;
        if attempts.pick >= most {
            let setup = self.setup;
            let name = setup.object_name(object);
            self.fail(reason, format_args!("{name} {why}, again and again"));
        }
    }

    /// Counts a set-down that failed, `why`. After `most` in a row the job fails with `reason`.
    pub fn count_failed_place(&mut self, object: usize, most: u32, reason: &str, why: &str) {
        let Some(attempts) = self.attempts_mut(object) else {
            return;
        };
        attempts.place += 1;
        if attempts.place >= most {
            let setup = self.setup;
            let name = setup.object_name(object);
            self.fail(reason, format_args!("{name} {why}, again and again"));
        }
    }

    /// Records that a skill refuses to start: its node fails, and the job does unless a policy
    /// with another answer takes it. The first refusal of a decision counts.
    pub fn refuse(&mut self, reason: &str, why: std::fmt::Arguments<'_>) -> Status {
        if self.refusal.is_none() {
            self.refusal = Some(Refusal {
                reason: Reason::new(reason),
                why: why.to_string(),
            });
        }
        Status::Failure
    }

    /// Waits for what may leave the way to `object`, or refuses the job with its reason; `since` is
    /// the start of the wait.
    pub(crate) fn wait_or_refuse(
        &mut self,
        object: usize,
        why: &Exclusion,
        since: &mut Option<PolicyTime>,
    ) -> Status {
        let patience_s = match why {
            Exclusion::Arm(_) => ARM_PATIENCE_S,
            Exclusion::Object(_) => OBJECT_PATIENCE_S,
            _ => 0.0,
        };
        let (now, name) = (self.now(), self.setup.object_name(object));
        if self.resumed {
            *since = None;
        }
        let since = *since.get_or_insert(now);
        if now.since(since) < PolicyTime::from_seconds(patience_s) {
            if since == now {
                self.out.log(format_args!("[wait] {name}: {why}"));
            }
            self.note_wait(since, format_args!("{name}: {why}"));
            return Status::Running;
        }
        self.refuse(why.reason(), format_args!("{name}: {why}"))
    }

    /// Whether an object is where the cell file has it, so it was not moved.
    pub(crate) fn is_where_it_began(&self, object: usize) -> bool {
        let scene = self.setup.grasping.scene_at_start();
        let began = scene.and_then(|scene| scene.objects.get(object)?.pose);
        began
            .zip(self.position(object))
            .is_some_and(|(began, seen)| {
                geometry::plane_distance(began.translation.vector, seen) < MOVED_M
            })
    }

    /// Refuses the job if another arm is where the tool shall be (TCP, world frame).
    pub(crate) fn refuse_if_arm_blocks(&mut self, tcp: &Pose) -> Option<Status> {
        let grasping = &self.setup.grasping;
        let scene = grasping.scene(self.arm, self.observation)?;
        let gripper = grasping.gripper(self.arm)?;
        let why = arm_in_the_way(gripper, &scene, &isometry(tcp), ARM_CLEARANCE_M)?;
        let arm = self.arm_name();
        Some(self.refuse(why.reason(), format_args!("{arm}: {why}")))
    }

    /// `what`, with the controller's reason where it has one.
    pub(crate) fn why_not_reached(&self, what: &str) -> String {
        let echo = self.observation.echo(self.arm);
        match echo.and_then(|echo| echo.not_reached) {
            Some(reason) => format!("{what} ({})", reason.name()),
            None => what.to_owned(),
        }
    }

    /// `what`, with the reason for which the gripper does not hold what it closed on in `step`.
    pub(crate) fn why_not_caught(&self, step: &Step, what: &str) -> String {
        let arm = self.observation.arm(self.arm);
        let Some(gripper) = arm.map(|arm| arm.gripper) else {
            return what.to_owned();
        };
        if let Some(held) = self.held() {
            let name = self.setup.object_name(held);
            return format!("{what}: {name} is in the gripper");
        }
        let why = match step.switched {
            _ if self.tool() != Tool::Suction => None,
            None if gripper.suction != 0 => Some("suction does not switch off".to_owned()),
            None => Some("the arm does not come to rest".to_owned()),
            Some(on) if gripper.breaks != on.breaks => self.breaking(),
            Some(_) => Some(suction::refusal(&gripper).to_owned()),
        };
        why.map_or(what.to_owned(), |why| format!("{what}: {why}"))
    }

    /// Whether a grip broke since `step` switched suction on.
    pub(crate) fn has_broken(&self, step: &Step) -> bool {
        let arm = self.observation.arm(self.arm);
        let switched = step.switched;
        arm.zip(switched)
            .is_some_and(|(arm, switched)| arm.gripper.breaks != switched.breaks)
    }

    /// How the last grip of the cup broke.
    fn breaking(&self) -> Option<String> {
        let (arm, gripper) = (self.arm_setup()?, &self.observation.arm(self.arm)?.gripper);
        let (limit, cause) = (suction::break_limit(gripper), suction::break_cause(gripper));
        let of = match BreakLimit::from_code(gripper.break_limit) {
            Some(BreakLimit::Torque) => {
                let limit_n_m = arm.suction_limit_n_m?;
                format!("{:.1} N m of {limit_n_m:.1} N m", gripper.peak_torque)
            }
            _ => format!(
                "{:.0} N of {:.0} N",
                gripper.peak_force, arm.suction_limit_n?
            ),
        };
        Some(format!(
            "the grip broke at its {limit} limit ({cause}), {of}"
        ))
    }

    /// Why the cup lost `object`, if its grip broke.
    pub(crate) fn broken_grip(&self, object: usize) -> Option<BrokenGrip> {
        let gripper = &self.observation.arm(self.arm)?.gripper;
        let limit_n = self.arm_setup()?.suction_limit_n?;
        if gripper.attached != 0 || gripper.break_limit == 0 {
            return None;
        }
        let weight_n = self.object_setup(object)?.mass_kg * -GRAVITY[2];
        let is_weight = BreakCause::from_code(gripper.break_cause) == Some(BreakCause::Weight);
        let is_too_heavy = is_weight || weight_n > HEAVY * limit_n;
        let why = if is_too_heavy {
            format!("too heavy: {weight_n:.0} N of {limit_n:.0} N")
        } else {
            self.breaking()?
        };
        Some(BrokenGrip { is_too_heavy, why })
    }

    /// Waits for an object that is out of reach. Returns failure, and fails the job with
    /// `reason`, if it stays there. [`World::note_in_reach`] ends the wait when the object is within
    /// reach again.
    pub fn wait_for_reach(&mut self, object: usize, reason: &str) -> Status {
        let now = self.now();
        let setup = self.setup;
        let name = setup.object_name(object);
        // The start of the wait is in the job, not in the skill: another skill continues the
        // same wait.
        let Some(wait) = self.job.unreachable_since.get_mut(self.arm) else {
            return Status::Failure;
        };
        let Some(since) = *wait else {
            *wait = Some(now);
            self.out.log(format_args!("[wait] {name} is out of reach"));
            return Status::Running;
        };
        if now.since(since) < PolicyTime::from_seconds(REACH_PATIENCE_S) {
            self.note_wait(since, format_args!("{name} is out of reach"));
            return Status::Running;
        }
        self.fail(reason, format_args!("{name} stayed out of reach"));
        Status::Failure
    }
}

//! Commands to the arm, the state of the job, and the log.

use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::{GripperGoal, Text};
use robocell_task::{ArmIntent, PolicyTime, TraceEvent};

use super::World;
use super::seen::LEFT_SIDES;
use crate::condition::PLACE_TOLERANCE_M;
use crate::setup::Tool;

/// A wait is reported after this time (s): shorter ones are part of normal work of two arms.
const REPORTED_WAIT_S: f64 = 2.0;

impl World<'_> {
    /// Commands the arm. A later command of a decision replaces an earlier one, except for the
    /// gripper, which keeps its last command.
    pub fn act(&mut self, intent: ArmIntent) {
        self.told.acted = true;
        if intent.gripper != GripperGoal::Keep {
            self.told.gripper = intent.gripper;
        }
        // Guides count only for a motion that names them.
        let obstacle_mask = match intent.obstacle_mask {
            u64::MAX => self.setup.solid_obstacles,
            mask => mask,
        };
        let intent = ArmIntent {
            obstacle_mask,
            gripper: self.told.gripper,
            grip_force: self.grip_force(),
            open_width: self.told.open_width_m,
            ..intent
        };
        self.out.arm(self.arm, intent);
    }

    /// Fingers that open in this decision do so to this distance (m); 0 for as far as they open.
    pub(crate) fn opening_to(&mut self, width_m: f64) {
        self.told.open_width_m = width_m;
    }

    /// The arm keeps its target, and the gripper gets `gripper`.
    pub fn stay(&mut self, gripper: GripperGoal) {
        let mut intent = ArmIntent {
            gripper,
            ..ArmIntent::default()
        };
        // Only a goal of a pose can be kept: one of joints would need its posture, too.
        if let Some(previous) = self.out.previous(self.arm)
            && previous.kind == GoalKind::Pose
        {
            intent.kind = GoalKind::Pose;
            intent.key = previous.key;
            intent.target = previous.target;
        }
        self.act(intent);
    }

    /// The arm stops where it is; the gripper keeps its command.
    pub fn hold(&mut self) {
        self.act(ArmIntent::default());
    }

    /// Ends a decision: an arm without a command keeps its target, and a drop is counted, of
    /// the first arm and of every arm with a [`World::memory`].
    pub fn finish(&mut self) {
        self.end_refused(true);
        if !self.told.acted {
            self.stay(GripperGoal::Keep);
        }
        let before = match &self.memory {
            Some(memory) => memory.held,
            None => self.job.held.filter(|_| self.arm == 0),
        };
        let held = self.kept(before);
        if let Some(memory) = &mut self.memory {
            memory.held = held;
        }
        if self.arm == 0 {
            self.job.held = held;
        }
    }

    /// Takes the refusal of a skill; with `failed` it fails the job.
    pub(crate) fn end_refused(&mut self, failed: bool) {
        if let Some(refusal) = self.refusal.take().filter(|_| failed) {
            self.fail(refusal.reason.as_str(), format_args!("{}", refusal.why));
        }
    }

    /// Reports whether the job is done, and which objects are in a slot of a place.
    ///
    /// A job that is done stays done until an object leaves its place or an arm picks one up: a
    /// policy that only looks again has not begun again, and its end is not another end.
    pub fn report(&mut self, done: bool) {
        self.report_within(done, PLACE_TOLERANCE_M);
    }

    /// As [`World::report`]; an object nearer to its slot than `tolerance_m` in the
    /// plane is in it.
    pub fn report_within(&mut self, done: bool, tolerance_m: f64) {
        let mut arms = 0..self.setup.arms.len();
        let holds = arms.any(|arm| self.held_by(arm).is_some());
        let mut placed = self.job.placed.iter();
        let lasts = self.job.done
            && (self.job.done_holding || !holds)
            && placed.all(|object| self.is_placed(*object as usize, tolerance_m));
        if done && !lasts {
            self.job.done_holding = holds;
        }
        self.job.done = done || lasts;
        self.out.outcome = if self.job.done {
            Outcome::Done
        } else {
            Outcome::Running
        };
        self.job.placed.clear();
        for (number, object) in (0_u32..).zip(0..self.setup.objects.len()) {
            if self.is_placed(object, tolerance_m) {
                self.job.placed.push(number);
            }
        }
    }

    fn is_placed(&self, object: usize, tolerance_m: f64) -> bool {
        let mut places = 0..self.setup.places.len();
        places.any(|place| self.slot_of(object, place, tolerance_m).is_some())
    }

    /// The object in the gripper. One that is not observed for a moment is kept; one that left
    /// a gripper that was not opened is counted as a drop.
    fn kept(&mut self, before: Option<usize>) -> Option<usize> {
        let held = self.held();
        let Some(before) = before.filter(|before| held != Some(*before)) else {
            return held;
        };
        // The command of the decision before: a gripper that was opened on purpose dropped
        // nothing.
        let told = self.out.previous(self.arm).map(|told| told.gripper);
        if told == Some(GripperGoal::Open) {
            return held;
        }
        let longest = self.object_setup(before).map_or(0.0, |of| of.longest_m);
        let left = self.has_left(before, LEFT_SIDES * longest);
        // A policy that opens the gripper now has noticed the loss, too.
        if held.is_none() && !left && self.told.gripper != GripperGoal::Open {
            return Some(before);
        }
        self.note_drop(before);
        held
    }

    /// Reports `what` the arm has been waiting for since `since`, after a while. The first wait of
    /// a decision counts.
    pub fn note_wait(&mut self, since: PolicyTime, what: std::fmt::Arguments<'_>) {
        let lasted = self.now().since(since);
        if self.out.wait.is_empty() && lasted >= PolicyTime::from_seconds(REPORTED_WAIT_S) {
            self.out.wait = Text::format(format_args!("{}: {what}", self.arm_name()));
        }
    }

    /// Records that something has to be done again.
    pub fn note_retry(&mut self, object: usize, why: &str) {
        self.job.counters.recoveries += 1;
        let setup = self.setup;
        let name = setup.object_name(object);
        self.out
            .event(TraceEvent::Recover, format_args!("[retry] {name} {why}"));
    }

    /// Fails the job with `reason`; `why` is for the log.
    pub fn fail(&mut self, reason: &str, why: std::fmt::Arguments<'_>) {
        self.out
            .event(TraceEvent::Fault, format_args!("[failed] {why}"));
        self.job.fail(reason);
    }

    fn grip_force(&self) -> f64 {
        match self.tool() {
            Tool::Fingers { force_n, .. } => force_n,
            Tool::Suction | Tool::None => 0.0,
        }
    }
}

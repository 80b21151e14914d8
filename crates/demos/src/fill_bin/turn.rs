//! One decision: what the cells of the matrix do.

use behavior::machine::Fault;
use behavior::matrix::{Cell, HandlerId, Handlers, Next};
use ipc_types::{GripperGoal, Pose};
use robocell_task::TraceEvent;

use super::grasp::{self, Grasp, NoGrasp};
use super::hold;
use super::memory::Memory;
use super::names::{Handler, State};
use super::scene::View;
use crate::failure::Failure;
use robocell_skills::matrix::goto;
use robocell_skills::suction::{break_cause, break_limit, refusal};
use robocell_skills::{Named as _, Waypoint, pose};
use robocell_task::job::Job;
use robocell_task::output::Output;
use robocell_task::time::PolicyTime;

/// How far the cup gives way while suction comes on (m).
const GIVE_WAY_M: f64 = 0.001;

/// What a handler works with.
pub(super) struct Turn<'t, 's, 'o> {
    pub(super) scene: View<'s, 'o>,
    pub(super) memory: &'t mut Memory,
    pub(super) job: &'t mut Job,
    pub(super) out: &'t mut Output,
    pub(super) now: PolicyTime,
    /// The grip broke at a limit since the last decision.
    pub(super) broken: bool,
}

impl Handlers for Turn<'_, '_, '_> {
    fn handle(&mut self, handler: HandlerId, cell: Cell<'_>) -> Result<Next, Fault> {
        let handler = Handler::at(handler.0).ok_or(Fault {
            reason: "there is no such handler",
        })?;
        Ok(match handler {
            Handler::ToAboveBin => self.above_bin(),
            Handler::ToSurface => self.down_to_surface(),
            Handler::AimAgain => self.aim_again(),
            Handler::CloseGripper => self.close_gripper(),
            Handler::Lift => self.lift(),
            Handler::AskForParts => self.ask_for_parts(),
            Handler::GiveUp => self.give_up(State::at(cell.state.0).unwrap_or(State::Standby)),
            Handler::StopTasks => self.stop_tasks(),
        })
    }
}

/// Picking.
impl Turn<'_, '_, '_> {
    /// Where the bin can be gripped now; a failure of the job after it could not
    /// for too long.
    fn grasp(&mut self) -> Option<Grasp> {
        let found = grasp::find(&self.scene);
        let why = match found {
            Ok(grasp) => {
                self.memory.stuck_since = None;
                return Some(grasp);
            }
            Err(why) => why,
        };
        let since = *self.memory.stuck_since.get_or_insert(self.now);
        if self.now.since(since) >= self.scene.setup.times.patience {
            let (failure, text) = match why {
                NoGrasp::Lost => (Failure::BinLost, "is not in the cell any more"),
                NoGrasp::OutOfReach => (Failure::BinOutOfReach, "lies out of reach"),
                NoGrasp::NoSurface => (
                    Failure::BinCannotBeGripped,
                    "lies so that suction finds no flat spot",
                ),
            };
            self.fail(failure, text);
        }
        None
    }

    fn fail(&mut self, failure: Failure, text: &str) {
        let name = &self.scene.setup.task.bin;
        self.out
            .event(TraceEvent::Fault, format_args!("[stuck] {name} {text}"));
        self.job.fail(failure.reason());
        // Whoever starts the job again has as much patience again.
        self.memory.stuck_since = None;
        self.memory.motion.stop();
        self.memory.switch(false);
    }

    /// The bin is looked for, and approached if it can be gripped.
    fn above_bin(&mut self) -> Next {
        // What hangs on the cup already is handled by ATTACHED, in the next decision.
        if !self.job.started || !self.scene.bin_still || self.memory.attached {
            return Next::Stay;
        }
        let Some(grasp) = self.grasp() else {
            return Next::Stay;
        };
        let name = &self.scene.setup.task.bin;
        let side = grasp.side.name();
        self.out.log(format_args!("[decide] -> pick {name} {side}"));
        self.memory.switch(false);
        self.memory.tried = false;
        let above = self.above(&grasp);
        self.go(above);
        goto(State::Picking)
    }

    /// PICKING aims at the bin as it lies now, on every decision.
    fn aim_again(&mut self) -> Next {
        if let Some(grasp) = self.grasp() {
            let above = self.above(&grasp);
            self.memory.motion.aim(above);
        }
        Next::Stay
    }

    fn down_to_surface(&mut self) -> Next {
        let grasp = self.grasp().filter(|_| self.scene.bin_still);
        let Some(grasp) = grasp else {
            // Not yet: the same place is reached again.
            self.memory.motion.again();
            return Next::Stay;
        };
        let surface = self.surface(&grasp);
        self.go(surface);
        goto(State::Attach)
    }

    /// At the surface: suction on, and once more in place; then back off.
    fn close_gripper(&mut self) -> Next {
        if self.scene.holds_bin() {
            return Next::Stay;
        }
        if self.memory.gripper() == GripperGoal::Close {
            return self.not_gripped();
        }
        let setup = self.scene.setup;
        if !std::mem::replace(&mut self.memory.settled, true) {
            self.memory.again_after(setup.times.settle, self.now);
            return Next::Stay;
        }
        self.memory.again_after(setup.times.attach, self.now);
        // A cup that was on has to be seen off first.
        if self.scene.gripper.suction == 0 {
            self.memory.switch(true);
            self.out.log(format_args!("<close gripper>"));
            // A cup that went on towards its target would press the bin against
            // what it lies on, at once beyond the limits: it stays and gives way.
            let here = pose::along_approach(&self.scene.tcp, -GIVE_WAY_M);
            let here = self.beside_stand(here);
            self.memory.motion.aim(here);
        }
        Next::Stay
    }

    fn not_gripped(&mut self) -> Next {
        let why = refusal(self.scene.gripper);
        self.out.log(format_args!("[missed] suction: {why}"));
        self.memory.switch(false);
        if !self.memory.tried {
            self.memory.tried = true;
            if let Some(grasp) = self.grasp() {
                let surface = self.surface(&grasp);
                self.go(surface);
            }
            let pause = self.scene.setup.times.attach;
            self.memory.again_after(pause, self.now);
            return Next::Stay;
        }
        self.memory.tried = false;
        if self.failed_again() {
            return Next::Stay;
        }
        let back = pose::along_approach(&self.scene.tcp, -self.scene.setup.task.back_off_m);
        self.go(self.beside_stand(back));
        goto(State::Picking)
    }

    /// Counts a failed pick-up. Answers whether that was one too many.
    fn failed_again(&mut self) -> bool {
        let setup = self.scene.setup;
        self.job.counters.resyncs += 1;
        let attempts = self.job.attempts_mut(setup.bin);
        let failed = attempts.map_or(1, |attempts| {
            attempts.pick += 1;
            attempts.pick
        });
        let too_many = failed >= setup.task.max_attempts;
        if too_many {
            self.fail(
                Failure::BinCannotBeGripped,
                "was not gripped again and again",
            );
        }
        too_many
    }
}

/// Holding.
impl Turn<'_, '_, '_> {
    /// Something hangs on the cup: the bin is carried under the dispenser,
    /// anything else is let go.
    fn lift(&mut self) -> Next {
        self.memory.attached = false;
        if !self.scene.holds_bin() {
            self.out.log(format_args!("[missed] that is not the bin"));
            self.memory.switch(false);
            return Next::Stay;
        }
        let setup = self.scene.setup;
        self.memory.switch(true);
        self.memory.tried = false;
        self.memory.aside = false;
        self.job.held = Some(setup.bin);
        let raised = pose::shifted(&self.scene.tcp, [0.0, 0.0, setup.task.lift_m]);
        let raised = self.beside_stand(raised).gliding(setup.times.lift.ticks());
        self.go(raised);
        let hold = self.beside_stand(hold::hanging(&self.scene));
        self.memory
            .motion
            .then(hold.gliding(setup.times.carry.ticks()));
        goto(State::Holding)
    }

    /// No part would stay in a bin that hangs upside down: it is carried aside and
    /// let fall.
    fn tip_over(&mut self) -> Next {
        let setup = self.scene.setup;
        if std::mem::replace(&mut self.memory.aside, true) {
            self.memory.switch(false);
            return Next::Stay;
        }
        let name = &setup.task.bin;
        let what = "hangs upside down, it is let fall to lie otherwise";
        self.out.log(format_args!("[hold] {name} {what}"));
        let hold = self.memory.motion.end().map(Waypoint::pose);
        let aside = pose::shifted(&hold.unwrap_or(self.scene.tcp), setup.task.tip_over_m);
        let aside = self.beside_stand(aside);
        self.go(aside.gliding(setup.times.lift.ticks()));
        Next::Stay
    }

    /// The bin is under the dispenser. A bin held by a wall is turned up first.
    fn ask_for_parts(&mut self) -> Next {
        let setup = self.scene.setup;
        if let Some(attempts) = self.job.attempts_mut(setup.bin) {
            attempts.pick = 0;
        }
        if self.memory.broke && !self.job.done {
            self.job.done = true;
            let name = &setup.task.bin;
            self.out.event(
                TraceEvent::Done,
                format_args!("[done] {name} is held again after it fell"),
            );
        }
        let opens_up = hold::opens_up(&self.scene);
        if opens_up {
            self.job.io.drop_parts = self.job.io.drop_parts.wrapping_add(1);
        } else if let Some(upright) = hold::upright(&self.scene) {
            let upright = self.beside_stand(upright);
            self.go(upright.gliding(setup.times.carry.ticks()));
            return Next::Stay;
        } else {
            return self.tip_over();
        }
        self.memory.again_after(setup.times.between_drops, self.now);
        Next::Stay
    }
}

/// Losing it.
impl Turn<'_, '_, '_> {
    /// The grip is gone: back to the rest pose, and from there on again.
    fn give_up(&mut self, state: State) -> Next {
        let gripper = self.scene.gripper;
        if state == State::Holding {
            self.job.counters.drops += 1;
        }
        if self.broken {
            let (limit, cause) = (break_limit(gripper), break_cause(gripper));
            let (force, torque) = (gripper.peak_force, gripper.peak_torque);
            self.out.event(
                TraceEvent::Drop,
                format_args!(
                    "[break] {limit} limit, by {cause} (peak {force:.1} N, {torque:.2} N m)"
                ),
            );
            self.memory.broke |= state == State::Holding;
        } else {
            self.out.log(format_args!("<open gripper>"));
        }
        self.job.done = false;
        self.job.held = None;
        self.memory.attached = false;
        self.back_to_rest();
        goto(State::Standby)
    }

    /// A pick-up took too long: as the source, everything stops and begins
    /// anew, not paused.
    fn stop_tasks(&mut self) -> Next {
        self.out.log(format_args!("[timeout] pick-up stopped"));
        if self.failed_again() {
            return Next::Stay;
        }
        self.back_to_rest();
        goto(State::Standby)
    }

    pub(super) fn back_to_rest(&mut self) {
        self.memory.switch(false);
        self.memory.stuck_since = None;
        let rest = Waypoint::new(self.scene.setup.rest);
        self.go(rest);
    }
}

/// Ways.
impl Turn<'_, '_, '_> {
    fn go(&mut self, waypoint: Waypoint) {
        let start = self.memory.motion.target(self.now);
        let start = start.unwrap_or(self.scene.tcp);
        self.memory.wait_until = self.now;
        self.memory.settled = false;
        self.memory.motion.go(waypoint, &start, self.now);
    }

    fn beside_stand(&self, at: Pose) -> Waypoint {
        Waypoint::new(at).avoiding(self.scene.setup.beside_stand, u64::MAX)
    }

    fn above(&self, grasp: &Grasp) -> Waypoint {
        let away = -self.scene.setup.task.above_m;
        self.beside_stand(pose::along_approach(&grasp.at, away))
    }

    fn surface(&self, grasp: &Grasp) -> Waypoint {
        let gap = -self.scene.setup.task.gap_m;
        self.beside_stand(pose::along_approach(&grasp.at, gap))
    }
}

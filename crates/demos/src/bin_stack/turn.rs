//! One decision: what the cells of the matrix do.

use behavior::machine::Fault;
use behavior::matrix::{Cell, HandlerId, Handlers, Next};
use ipc_types::Pose;
use robocell_task::TraceEvent;

use super::events;
use super::memory::Memory;
use super::names::{Handler, State};
use super::paths::{self, Route};
use super::policy::Found;
use super::scene::{Bin, View};
use crate::failure::Failure;
use robocell_skills::matrix::goto;
use robocell_skills::suction::{break_cause, break_limit};
use robocell_skills::{Named as _, Waypoint, pose};
use robocell_task::job::{Attempts, Job};
use robocell_task::output::Output;
use robocell_task::time::PolicyTime;

/// The cup eases off by this before suction is switched on (m), in this time.
const EASE_M: f64 = 0.001;
const EASE_TICKS: u64 = 200;

/// A bin nearer than this to the middle of the holder is in it, or over it (m).
const NEAR_HOLDER_M: f64 = 0.3;

/// What a handler works with.
pub(super) struct Turn<'t, 'a, 'o> {
    pub(super) scene: View<'a, 'o>,
    pub(super) memory: &'t mut Memory,
    pub(super) job: &'t mut Job,
    pub(super) out: &'t mut Output,
    pub(super) found: Found,
    pub(super) now: PolicyTime,
}

impl Handlers for Turn<'_, '_, '_> {
    fn handle(&mut self, handler: HandlerId, cell: Cell<'_>) -> Result<Next, Fault> {
        let handler = Handler::at(handler.0).ok_or(Fault {
            reason: "there is no such handler",
        })?;
        let next = match handler {
            Handler::ToAboveBin => self.go_above_bin(),
            Handler::Rest => self.rest(),
            Handler::AimAgain => self.aim_again(),
            Handler::ToSurface => self.go_to_surface(),
            Handler::CloseGripper => self.close_gripper(),
            Handler::BackOff => self.back_off(),
            Handler::ChooseWay => self.choose_way(),
            Handler::OverHolder => self.over_holder(),
            Handler::OverColumn => self.over_column(),
            Handler::OpenGripper => self.open_gripper(),
            Handler::CountOrRegrip => self.count_or_regrip(),
            Handler::GiveUp => self.give_up(State::at(cell.state.0).unwrap_or(State::Standby)),
        };
        Ok(next)
    }
}

/// Picking.
impl Turn<'_, '_, '_> {
    fn go_above_bin(&mut self) -> Next {
        let Some(bin) = events::candidate(&self.scene) else {
            return Next::Stay;
        };
        let opens = if bin.up() > 0.0 { "upward" } else { "downward" };
        let name = self.scene.setup.name(bin.object);
        self.out
            .log(format_args!("[decide] -> pick {name}, which opens {opens}"));
        self.memory.forget_bin();
        self.memory.bin = Some(bin.object);
        let above = self.above(&bin, self.scene.setup.task.hover_m);
        self.path_from(&bin).around_to(above);
        goto(State::Picking)
    }

    fn aim_again(&mut self) -> Next {
        let bin = self.memory.bin.and_then(|bin| self.scene.bin(bin));
        let Some(bin) = bin else {
            self.out.log(format_args!("[lost] the bin to pick is gone"));
            self.job.counters.resyncs += 1;
            return self.go_home();
        };
        let above = self.above(&bin, self.scene.setup.task.hover_m);
        if let Some(end) = self.memory.motion.end().copied() {
            let aimed = Waypoint {
                position: above.position,
                orientation_wxyz: above.orientation_wxyz,
                ..end
            };
            self.memory.motion.aim(aimed);
        }
        Next::Stay
    }

    fn go_to_surface(&mut self) -> Next {
        let Some(bin) = self.memory.bin.and_then(|bin| self.scene.bin(bin)) else {
            return self.go_home();
        };
        let surface = self.above(&bin, self.scene.setup.task.touch_gap_m);
        // Rather pulling than pressing: what is left of the way down would push
        // the bin into its support, and break the grip.
        let eased = pose::shifted(&surface, [0.0, 0.0, EASE_M]);
        self.path_from(&bin)
            .slowly(surface)
            .settle()
            .in_ticks(eased, EASE_TICKS);
        goto(State::Attach)
    }

    fn close_gripper(&mut self) -> Next {
        self.memory.closed = true;
        self.memory.acting = Some(self.now);
        self.out.log(format_args!("<close gripper>"));
        Next::Stay
    }

    /// Suction attached nothing: up again, and aim anew.
    fn back_off(&mut self) -> Next {
        let object = self.memory.bin;
        self.memory.closed = false;
        self.memory.acting = None;
        self.job.counters.recoveries += 1;
        self.out
            .log(format_args!("[missed] suction attached nothing"));
        let failed = self.count_failed_pick();
        let bin = object.and_then(|bin| self.scene.bin(bin));
        let Some(bin) = bin.filter(|_| !failed) else {
            return self.go_home();
        };
        let above = self.above(&bin, self.scene.setup.task.hover_m);
        self.path().into_holder().slowly(above);
        goto(State::Picking)
    }

    /// One more failed pick of the bin under way; whether the job was given up.
    fn count_failed_pick(&mut self) -> bool {
        let most = self.scene.setup.task.max_attempts;
        let attempts = self.memory.bin.and_then(|bin| self.job.attempts_mut(bin));
        let Some(attempts) = attempts else {
            return false;
        };
        attempts.pick += 1;
        let failed = attempts.pick > most;
        if failed {
            self.job.fail(Failure::BinCannotBeGripped.reason());
        }
        failed
    }

    pub(super) fn above(&self, bin: &Bin, height: f64) -> Pose {
        let setup = self.scene.setup;
        paths::above(setup, bin, paths::yaw_over(setup, bin), height)
    }
}

/// Going home.
impl<'a> Turn<'_, 'a, '_> {
    /// Back to where the arm waits, clear of everything.
    pub(super) fn go_home(&mut self) -> Next {
        self.memory.forget_bin();
        self.memory.closed = false;
        let rest = paths::rest(self.scene.setup);
        if paths::points_up(&self.scene.tcp) {
            self.out_of_holder().clear_of_holder().around_to(rest);
        } else {
            self.path()
                .into_holder()
                .lift()
                .clear_of_holder()
                .around_to(rest);
        }
        goto(State::Standby)
    }

    /// At rest: what was set down stands where it belongs, or does not.
    fn rest(&mut self) -> Next {
        let Some(object) = self.memory.set_down.take() else {
            return Next::Stay;
        };
        let in_place = self.scene.stacked().any(|bin| bin.object == object);
        let name = self.scene.setup.name(object);
        if in_place {
            self.out.log(format_args!("[placed] {name}"));
            if let Some(attempts) = self.job.attempts_mut(object) {
                *attempts = Attempts::default();
            }
            return Next::Stay;
        }
        self.out.log(format_args!(
            "[missed] {name} did not stay where it was set down"
        ));
        self.job.counters.recoveries += 1;
        let most = self.scene.setup.task.max_attempts;
        if let Some(attempts) = self.job.attempts_mut(object) {
            attempts.place += 1;
            if attempts.place > most {
                self.job.fail(Failure::BinCannotBePlaced.reason());
            }
        }
        Next::Stay
    }

    /// The grip broke, or the state lasted too long. What is in the hand all the
    /// same is not let go: the way with it begins anew.
    fn give_up(&mut self, state: State) -> Next {
        let lost = self.scene.gripper.attached == 0 || self.found.grip.broken;
        if lost && self.job.held.take().is_some() {
            self.note_drop();
        } else {
            let name = self.bin_name();
            let state_name = state.name();
            self.out
                .log(format_args!("[timeout] {name} in {state_name}"));
            self.memory.stuck += 1;
            self.job.counters.recoveries += 1;
            self.give_up_for_good(state);
        }
        self.memory.since = self.now;
        if self.scene.held().is_none() {
            return self.go_home();
        }
        if self.job.failure.is_some() {
            return Next::Stay;
        }
        self.choose_way()
    }

    fn bin_name(&self) -> &'a str {
        let setup = self.scene.setup;
        self.memory.bin.map_or("no bin", |bin| setup.name(bin))
    }

    /// The bin fell. One that is lost again and again cannot be gripped.
    fn note_drop(&mut self) {
        let name = self.bin_name();
        let gripper = self.scene.gripper;
        let (limit, cause) = (break_limit(gripper), break_cause(gripper));
        if self.found.grip.broken {
            self.out.event(
                TraceEvent::Drop,
                format_args!("[drop] {name}: {limit} limit, by {cause}"),
            );
        } else {
            self.out.event(
                TraceEvent::Drop,
                format_args!("[drop] {name} is not attached any more"),
            );
        }
        self.job.counters.drops += 1;
        self.count_failed_pick();
    }

    fn give_up_for_good(&mut self, state: State) {
        let blocked = self.memory.opening() && self.scene.gripper.attached == 1;
        if self.memory.stuck < self.scene.setup.task.max_attempts && !blocked {
            return;
        }
        // Whoever starts the job again gives it as many attempts again.
        self.memory.stuck = 0;
        let failure = if blocked {
            Failure::GripperBlocked
        } else if self.scene.caught() {
            Failure::ArmCaught
        } else {
            match state {
                State::Picking => Failure::BinOutOfReach,
                State::Attach => Failure::BinCannotBeGripped,
                _ => Failure::BinCannotBePlaced,
            }
        };
        self.job.fail(failure.reason());
    }

    /// A way that begins or ends at `bin`, which may be in the holder.
    pub(super) fn path_from(&mut self, bin: &Bin) -> Route<'_> {
        let holder = nalgebra::Vector3::from(self.scene.setup.task.station.position_m);
        let in_holder = (bin.pose.translation.vector - holder).norm() < NEAR_HOLDER_M;
        let path = self.path();
        if in_holder { path.into_holder() } else { path }
    }

    pub(super) fn path(&mut self) -> Route<'_> {
        Route::from(
            self.scene.setup,
            &mut self.memory.motion,
            self.scene.tcp,
            self.now,
        )
    }
}

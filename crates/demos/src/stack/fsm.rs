//! The library-free state machine: one value for the transfer under way, a ring
//! of eight phases, and two edges that leave it (drop and resync).

use robocell_task::TraceEvent;
use std::sync::Arc;

use behavior::{Graph, NodeStatus};
use ipc_types::GripperGoal;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use crate::stack::phase::{DoneReason, PhaseClock, Progress};
use crate::stack::resume::{InHand, in_hand};
use crate::stack::scene::ARM;
use crate::stack::selection::{self, Assignment};
use crate::stack::{Phase, StackSetup, View, command, feedback, geometry, grip, picture, recovery};
use robocell_task::job::{Job, Placement};
use robocell_task::observation::Observation;
use robocell_task::output::Output;
use robocell_task::policy::Policy;
use robocell_task::time::PolicyTime;

/// One cube in transfer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PickPlaceState {
    /// Placement of the cube in the order.
    cube: usize,
    destination: Placement,
    phase: Phase,
    clock: PhaseClock,
    /// Frozen on entering GRASP.
    pickup: Option<Placement>,
    /// Where the cube was first seen by this transfer, in the plane (m).
    cube_reference_xy: [f64; 2],
    /// Turn of the tool around the cube (rad).
    grip_yaw: f64,
    /// The destination is final: the cube goes back, or out of the way.
    aborted: bool,
}

/// See the module.
#[derive(Clone, Debug)]
pub struct StackFsm {
    setup: Arc<StackSetup>,
}

/// What one tick works with.
struct Tick<'a, 'o> {
    setup: &'a StackSetup,
    scene: View,
    observation: &'a Observation<'o>,
    now: PolicyTime,
}

impl StackFsm {
    /// The machine for one job.
    pub fn new(setup: Arc<StackSetup>) -> Self {
        Self { setup }
    }

    fn tick<'a, 'o>(&'a self, observation: &'a Observation<'o>) -> Option<Tick<'a, 'o>> {
        Some(Tick {
            setup: &self.setup,
            scene: View::read(&self.setup, observation)?,
            observation,
            now: observation.time(),
        })
    }
}

/// Brings `transfer` to where it is after this tick, `None` for the empty
/// decision; says what the gripper does in that.
fn step(
    transfer: &mut Option<PickPlaceState>,
    tick: &Tick<'_, '_>,
    job: &mut Job,
    out: &mut Output,
) -> GripperGoal {
    let Some(mut state) = transfer.take() else {
        *transfer = select(tick, job, out);
        return GripperGoal::Keep;
    };
    if state.phase.holding() && recovery::dropped(tick.setup, &tick.scene, state.cube) {
        recovery::note_drop(tick.setup, state.cube, job, out);
        return GripperGoal::Open;
    }
    if state.pickup.is_none() && !available(tick, state.cube) {
        return GripperGoal::Keep;
    }
    state.resync_if_moved(tick, job, out);
    *transfer = state.advance(tick, job, out);
    GripperGoal::Keep
}

/// A cube that is off the table or out of reach is no cube to go on picking.
fn available(tick: &Tick<'_, '_>, cube: usize) -> bool {
    !recovery::fallen(&tick.scene, cube) && recovery::reachable(tick.setup, &tick.scene, cube)
}

fn select(tick: &Tick<'_, '_>, job: &mut Job, out: &mut Output) -> Option<PickPlaceState> {
    if job.failure.is_some() {
        return None;
    }
    let assignment = selection::decide(tick.setup, &tick.scene, tick.now, "decide", job, out)?;
    Some(PickPlaceState::begin(assignment, tick, job))
}

impl PickPlaceState {
    fn begin(assignment: Assignment, tick: &Tick<'_, '_>, job: &mut Job) -> Self {
        let Assignment {
            cube,
            destination,
            clears,
        } = assignment;
        let mut state = Self {
            cube,
            destination,
            phase: Phase::PreGrasp,
            clock: PhaseClock::default(),
            pickup: None,
            cube_reference_xy: [0.0; 2],
            grip_yaw: 0.0,
            aborted: clears,
        };
        state.aim(tick, job);
        state
    }

    /// (Re)starts the pick-up at the cube as it is seen now.
    fn aim(&mut self, tick: &Tick<'_, '_>, job: &mut Job) {
        let failed = tick
            .setup
            .cube(self.cube)
            .map_or(0, |c| job.attempts(c.object).pick);
        self.cube_reference_xy = tick.scene.cube(self.cube).position.xy().into();
        self.grip_yaw = grip::choose(tick.setup, &tick.scene, self.cube, failed);
        self.start(Phase::PreGrasp, tick.now, job);
    }

    fn resync_if_moved(&mut self, tick: &Tick<'_, '_>, job: &mut Job, out: &mut Output) {
        let reference = Vector2::from(self.cube_reference_xy);
        if self.pickup.is_some() || !recovery::moved(tick.setup, &tick.scene, self.cube, reference)
        {
            return;
        }
        recovery::note_resync(tick.setup, &tick.scene, self.cube, self.phase, job, out);
        self.aim(tick, job);
    }

    /// Leaves the phase if it is over. `None`: the transfer is over and there is
    /// no other, or the job was given up.
    fn advance(mut self, tick: &Tick<'_, '_>, job: &mut Job, out: &mut Output) -> Option<Self> {
        if job.failure.is_some() {
            return None;
        }
        let key = u64::from(job.counters.phase_entry);
        let previous = out.previous(ARM);
        let feedback = feedback::grade(
            tick.setup,
            self.phase,
            key,
            previous,
            tick.observation,
            &tick.scene,
        );
        match self
            .clock
            .progress(self.phase, &tick.setup.timing, tick.now, feedback)
        {
            Progress::Running => Some(self),
            Progress::Blocked => {
                recovery::note_blocked(tick.setup, self.cube, job, out);
                None
            }
            Progress::Done(reason) => self.leave(reason, tick, job, out),
        }
    }

    fn leave(
        mut self,
        reason: DoneReason,
        tick: &Tick<'_, '_>,
        job: &mut Job,
        out: &mut Output,
    ) -> Option<Self> {
        let name = tick.setup.name(self.cube);
        out.transition(format_args!(
            "[{name}] {} done ({})",
            self.phase.name(),
            reason.name()
        ));
        if let Some(next) = self.phase.next() {
            self.enter(next, tick, job, out);
            return Some(self);
        }
        if !self.aborted {
            recovery::note_placed(tick.setup, &tick.scene, self.cube, job);
        }
        select(tick, job, out)
    }

    /// What has to be decided at the border into `phase`.
    fn enter(&mut self, phase: Phase, tick: &Tick<'_, '_>, job: &mut Job, out: &mut Output) {
        if phase == Phase::Grasp {
            let position = tick.scene.cube(self.cube).position.into();
            self.pickup = Some(Placement {
                position,
                yaw: self.grip_yaw,
            });
        }
        let broken = selection::destination_lost(tick.setup, &tick.scene, self.cube);
        if phase.holding() && !self.aborted && broken {
            self.destination = recovery::note_abort(tick.setup, &tick.scene, self.cube, job, out);
            self.aborted = true;
        }
        if phase == Phase::Release {
            recovery::note_carried(tick.setup, self.cube, job);
        }
        self.start(phase, tick.now, job);
        self.remember(tick.setup, job);
    }

    fn start(&mut self, phase: Phase, now: PolicyTime, job: &mut Job) {
        self.phase = phase;
        self.clock = PhaseClock::start(now);
        job.counters.phase_entry += 1;
    }

    /// The part of the job another kind of policy could go on with.
    fn remember(&self, setup: &StackSetup, job: &mut Job) {
        recovery::forget_held(job);
        if self.phase.holding() {
            job.held = setup.cube(self.cube).map(|c| c.object);
            job.destination = Some(self.destination);
            job.aborted = self.aborted;
        }
    }

    /// What the TCP goes around in this phase: the live cube, where it was
    /// picked up, or where it goes.
    fn place(&mut self, scene: &View) -> Placement {
        match (self.phase, self.pickup) {
            (Phase::Grasp, Some(pickup)) => pickup,
            (Phase::Lift, Some(pickup)) => geometry::lift_place(pickup, self.destination),
            (Phase::PreGrasp | Phase::Approach | Phase::Grasp | Phase::Lift, _) => {
                self.grip_yaw = grip::follow(scene, self.cube, self.grip_yaw);
                Placement {
                    yaw: self.grip_yaw,
                    ..scene.cube(self.cube).place()
                }
            }
            _ => self.destination,
        }
    }

    /// Goes on with a cube that is in the hand already.
    fn adopt(found: InHand, tick: &Tick<'_, '_>, job: &mut Job, out: &mut Output) -> Self {
        let InHand {
            cube,
            destination,
            aborted,
            pickup,
            phase,
        } = found;
        out.event(
            TraceEvent::Recover,
            format_args!("[resume] {} is in the hand", tick.setup.name(cube)),
        );
        job.counters.recoveries += 1;
        job.done = false;
        let mut state = Self::begin(
            Assignment {
                cube,
                destination,
                clears: aborted,
            },
            tick,
            job,
        );
        state.grip_yaw = pickup.yaw;
        state.pickup = Some(pickup);
        state.enter(phase, tick, job, out);
        state
    }
}

impl Policy for StackFsm {
    type Memory = Option<PickPlaceState>;

    fn decide(
        &self,
        transfer: &mut Self::Memory,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let Some(tick) = self.tick(observation) else {
            return;
        };
        let gripper = step(transfer, &tick, job, out);
        let intent = match transfer {
            Some(state) => {
                let place = state.place(&tick.scene);
                let key = u64::from(job.counters.phase_entry);
                command::intent(&self.setup, state.phase, place, key)
            }
            None => command::hold(gripper),
        };
        out.arm(ARM, intent);
        let phase = transfer.as_ref().map(|t| t.phase);
        command::report(&self.setup, &tick.scene, phase, job, out);
    }

    fn is_sound(&self, transfer: &Self::Memory) -> bool {
        transfer
            .as_ref()
            .is_none_or(|t| t.cube < self.setup.cubes.len())
    }

    fn phase(&self, transfer: &Self::Memory) -> &str {
        transfer.as_ref().map_or("", |t| t.phase.name())
    }

    fn describe(&self, name: &str) -> Graph {
        picture::ring(name)
    }

    fn statuses(&self, transfer: &Self::Memory, out: &mut Vec<NodeStatus>) {
        picture::statuses(transfer.as_ref().map(|t| t.phase), out);
    }

    fn reconcile(
        &self,
        transfer: &mut Self::Memory,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let Some(tick) = self.tick(observation) else {
            return;
        };
        match transfer {
            Some(state) if state.pickup.is_some() => state.clock.unsettle(),
            _ => {
                if let Some(found) = in_hand(&self.setup, &tick.scene, job) {
                    *transfer = Some(PickPlaceState::adopt(found, &tick, job, out));
                } else {
                    recovery::forget_held(job);
                }
            }
        }
    }
}

//! The leaf that most of the tree is made of: one phase of a transfer.

use behavior::Status;
use behavior::board::Fault;
use behavior::tree::{BindError, Cx, Leaf};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::keys::{HOLDING, Keys, PICK_TARGET, Reads, Writes};
use super::world::StackHost;
use crate::stack::phase::{DoneReason, PhaseClock, Progress};
use crate::stack::scene::ARM;
use crate::stack::{Phase, command, feedback, geometry, grip, recovery, resume};
use robocell_task::job::Placement;

/// What makes one phase leaf another than the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flavour {
    /// The held cube goes to its spawn; the first such phase turns the transfer
    /// back.
    pub spawn: bool,
    /// A cube that moves away makes it fail.
    pub drift: bool,
    /// The cube counts as held until the tool is up again, as in the source,
    /// where a good place can be taken for a drop then.
    pub holds_until_retracted: bool,
}

/// One phase of a transfer.
pub struct PhaseLeaf {
    name: &'static str,
    phase: Phase,
    flavour: Flavour,
    pick_target: Reads<behavior::Str>,
    holding: Writes<behavior::Str>,
    pickup: PickupKey,
}

/// GRASP writes where it gripped, the others read it.
enum PickupKey {
    Writes(Writes<[f64; 4]>),
    Reads(Reads<[f64; 4]>),
}

/// What it remembers.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct PhaseState {
    clock: PhaseClock,
    /// Number of the phase entry: the key of its goal.
    entry: u32,
    /// Where the cube was when the phase began, in the plane (m).
    anchor_xy: [f64; 2],
    /// Turn of the tool around the cube (rad).
    grip_yaw: f64,
    /// There was nothing to do when it began.
    is_superfluous: bool,
}

type Call<'a, 'w> = Cx<'a, 'w, StackHost>;

impl PhaseLeaf {
    /// The leaf called `name`.
    ///
    /// # Errors
    /// [`BindError`] where a key was not declared.
    pub fn new(
        name: &'static str,
        phase: Phase,
        flavour: Flavour,
        mut keys: Keys<'_>,
    ) -> Result<Self, BindError> {
        let pickup = if phase == Phase::Grasp {
            PickupKey::Writes(keys.place_to_write()?)
        } else {
            PickupKey::Reads(keys.place()?)
        };
        Ok(Self {
            name,
            phase,
            flavour,
            pick_target: keys.cube(PICK_TARGET)?,
            holding: keys.cube_to_write(HOLDING)?,
            pickup,
        })
    }

    /// The cube this phase is about.
    fn cube(&self, cx: &Call<'_, '_>) -> Result<usize, Fault> {
        let held = self.holding.cube(cx)?;
        let cube = match held {
            Some(cube) => Some(cube),
            None => self.pick_target.cube(cx)?,
        };
        cube.ok_or(Fault::Node("a phase began without a cube"))
    }

    /// Picking up is over before it begins when the cube is in the hand, and
    /// carrying it when it is there.
    fn is_superfluous(&self, cx: &Call<'_, '_>) -> Result<bool, Fault> {
        let Some(cube) = self.holding.cube(cx)? else {
            return Ok(false);
        };
        let world = &cx.world;
        Ok(match (self.phase, world.job.destination) {
            (Phase::PreGrasp | Phase::Approach | Phase::Grasp, _) => true,
            (Phase::Lift | Phase::Transport, Some(destination)) => {
                resume::is_there(world.setup, world.scene, cube, destination)
            }
            _ => false,
        })
    }

    fn pickup(&self, cx: &Call<'_, '_>) -> Result<Option<Placement>, Fault> {
        match &self.pickup {
            PickupKey::Reads(key) => key.place(cx),
            PickupKey::Writes(key) => key.place(cx),
        }
    }

    /// The first phase of the way back decides where back is.
    fn turn_back(&self, cube: usize, cx: &mut Call<'_, '_>) {
        let world = &mut *cx.world;
        if self.flavour.spawn && !world.job.aborted {
            let place = recovery::note_abort(world.setup, world.scene, cube, world.job, world.out);
            world.job.destination = Some(place);
            world.job.aborted = true;
        }
    }

    fn choose_grip(&self, cube: usize, cx: &Call<'_, '_>) -> f64 {
        let (setup, scene) = (cx.world.setup, cx.world.scene);
        if self.phase == Phase::PreGrasp {
            let failed = setup
                .cube(cube)
                .map_or(0, |c| cx.world.job.attempts(c.object).pick);
            return grip::choose(setup, scene, cube, failed);
        }
        // The tool is turned already; the phase before this one chose.
        geometry::nearest_quarter(scene.cube(cube).yaw, scene.tcp_yaw)
    }

    /// What the TCP goes around.
    fn place(
        &self,
        cube: usize,
        state: &mut PhaseState,
        cx: &Call<'_, '_>,
    ) -> Result<Placement, Fault> {
        let scene = cx.world.scene;
        let destination = cx
            .world
            .job
            .destination
            .ok_or(Fault::Node("a cube is carried to nowhere"))?;
        Ok(match (self.phase, self.pickup(cx)?) {
            (Phase::Grasp, Some(pickup)) => pickup,
            (Phase::Lift, Some(pickup)) => geometry::lift_place(pickup, destination),
            (Phase::PreGrasp | Phase::Approach | Phase::Grasp | Phase::Lift, _) => {
                state.grip_yaw = grip::follow(scene, cube, state.grip_yaw);
                Placement {
                    yaw: state.grip_yaw,
                    ..scene.cube(cube).place()
                }
            }
            _ => destination,
        })
    }

    /// A cube that went away while it was picked up ends the attempt.
    fn lost_sight(&self, cube: usize, state: &PhaseState, cx: &mut Call<'_, '_>) -> bool {
        let world = &mut *cx.world;
        let (setup, scene) = (world.setup, world.scene);
        if !matches!(self.phase, Phase::PreGrasp | Phase::Approach) {
            return false;
        }
        let anchor = Vector2::from(state.anchor_xy);
        if self.flavour.drift && recovery::moved(setup, scene, cube, anchor) {
            world.out.log(format_args!(
                "[{}] target drifted, restarting pickup",
                self.name
            ));
            recovery::note_resync(setup, scene, cube, self.phase, world.job, world.out);
            return true;
        }
        recovery::fallen(scene, cube) || !recovery::reachable(setup, scene, cube)
    }

    /// Above a cube that was moved the fingers are turned anew: it may have
    /// other neighbours now.
    fn aim_again(&self, cube: usize, state: &mut PhaseState, cx: &Call<'_, '_>) {
        let (setup, scene) = (cx.world.setup, cx.world.scene);
        let anchor = Vector2::from(state.anchor_xy);
        if self.phase == Phase::PreGrasp && recovery::moved(setup, scene, cube, anchor) {
            state.anchor_xy = scene.cube(cube).position.xy().into();
            state.grip_yaw = self.choose_grip(cube, cx);
        }
    }

    fn progress(
        &self,
        cube: usize,
        state: &mut PhaseState,
        cx: &mut Call<'_, '_>,
    ) -> Result<Status, Fault> {
        let world = &mut *cx.world;
        let key = u64::from(state.entry);
        let (setup, previous) = (world.setup, world.out.previous(ARM));
        let feedback = feedback::grade(
            setup,
            self.phase,
            key,
            previous,
            world.observation,
            world.scene,
        );
        let timing = &setup.timing;
        match state
            .clock
            .progress(self.phase, timing, world.now, feedback)
        {
            Progress::Running => Ok(Status::Running),
            Progress::Blocked => {
                recovery::note_blocked(setup, cube, world.job, world.out);
                Ok(Status::Failure)
            }
            Progress::Done(reason) => {
                self.done(cube, reason, cx)?;
                Ok(Status::Success)
            }
        }
    }

    fn done(&self, cube: usize, reason: DoneReason, cx: &mut Call<'_, '_>) -> Result<(), Fault> {
        let world = &mut *cx.world;
        let name = world.setup.name(cube);
        if reason == DoneReason::Timeout {
            world
                .out
                .log(format_args!("[{}] timeout, advancing", self.name));
        }
        world.out.transition(format_args!(
            "[{name}] {} done ({})",
            self.phase.name(),
            reason.name()
        ));
        if self.phase == Phase::Retract && !world.job.aborted {
            recovery::note_placed(world.setup, world.scene, cube, world.job);
        }
        if self.phase == Phase::Release && !self.flavour.holds_until_retracted {
            cx.world.job.held = None;
            self.holding.name(cx, None)?;
        }
        Ok(())
    }
}

impl Leaf<StackHost> for PhaseLeaf {
    type State = PhaseState;

    fn start(&self, state: &mut PhaseState, cx: &mut Call<'_, '_>) -> Result<(), Fault> {
        state.is_superfluous = self.is_superfluous(cx)?;
        if state.is_superfluous {
            return Ok(());
        }
        let cube = self.cube(cx)?;
        self.turn_back(cube, cx);
        cx.world.job.counters.phase_entry += 1;
        *state = PhaseState {
            clock: PhaseClock::start(cx.world.now),
            entry: cx.world.job.counters.phase_entry,
            anchor_xy: cx.world.scene.cube(cube).position.xy().into(),
            grip_yaw: self.choose_grip(cube, cx),
            is_superfluous: false,
        };
        if self.phase == Phase::Release {
            recovery::note_carried(cx.world.setup, cube, cx.world.job);
        }
        if let PickupKey::Writes(key) = &self.pickup {
            let gripped = Placement {
                yaw: state.grip_yaw,
                ..cx.world.scene.cube(cube).place()
            };
            key.remember(cx, Some(gripped))?;
        }
        Ok(())
    }

    fn tick(&self, state: &mut PhaseState, cx: &mut Call<'_, '_>) -> Result<Status, Fault> {
        if state.is_superfluous {
            return Ok(Status::Success);
        }
        let cube = self.cube(cx)?;
        if cx.world.unsettled {
            state.clock.unsettle();
        }
        self.aim_again(cube, state, cx);
        let place = self.place(cube, state, cx)?;
        let intent = command::intent(cx.world.setup, self.phase, place, u64::from(state.entry));
        // Said before the check, so also in the decision in which it fails.
        cx.world.intent = Some((self.phase, intent));
        if self.lost_sight(cube, state, cx) {
            return Ok(Status::Failure);
        }
        self.progress(cube, state, cx)
    }
}

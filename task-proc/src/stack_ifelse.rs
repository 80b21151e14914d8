//! The same job as one if/else controller: attributes side by side, a phase
//! number, one long function. It is kept in one piece on purpose, to show what
//! the other policies tidy up; compare it with [`crate::stack_fsm`].

use std::sync::Arc;

use behavior::{Graph, NodeStatus};
use ipc_types::{GripperGoal, Text};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use crate::job::{Job, Place};
use crate::observation::Observation;
use crate::output::Output;
use crate::policy::Policy;
use crate::record;
use crate::stack::phase::{PhaseClock, Progress};
use crate::stack::resume::in_hand;
use crate::stack::scene::ARM;
use crate::stack::{
    Phase, Scene, StackSetup, command, feedback, geometry, grip, picture, recovery, selection,
};

/// See the module.
#[derive(Clone, Debug)]
pub struct StackIfElse {
    setup: Arc<StackSetup>,
    memory: Memory,
}

/// Everything it remembers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Memory {
    cube: Option<usize>,
    destination: Option<Place>,
    /// 0 to 7.
    phase: u32,
    clock: PhaseClock,
    pickup: Option<Place>,
    cube_reference_xy: [f64; 2],
    grip_yaw: f64,
    aborted: bool,
}

impl StackIfElse {
    /// Name on the command line.
    pub const NAME: &'static str = "ifelse";

    /// A controller between transfers.
    pub fn new(setup: Arc<StackSetup>) -> Self {
        Self {
            setup,
            memory: Memory::default(),
        }
    }

    /// One decision up to the target: select, or drop, or resync and advance.
    fn decide(
        &mut self,
        scene: &Scene,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) -> GripperGoal {
        let setup = Arc::clone(&self.setup);
        let now = observation.time();
        let mut gripper = GripperGoal::Keep;
        let mut select = self.memory.cube.is_none();
        if let Some(cube) = self.memory.cube {
            let phase = self.phase();
            let reference = Vector2::from(self.memory.cube_reference_xy);
            let gone = recovery::fallen(scene, cube) || !recovery::reachable(&setup, scene, cube);
            if phase.holding() && recovery::dropped(&setup, scene, cube) {
                recovery::note_drop(&setup, cube, job, out);
                self.memory = Memory::default();
                gripper = GripperGoal::Open;
            } else if self.memory.pickup.is_none() && gone {
                self.memory = Memory::default();
            } else {
                if self.memory.pickup.is_none() && recovery::moved(&setup, scene, cube, reference) {
                    recovery::note_resync(&setup, scene, cube, phase, job, out);
                    self.aim(scene, observation, job);
                }
                let phase = self.phase();
                let key = u64::from(job.counters.phase_entry);
                let feedback =
                    feedback::grade(&setup, phase, key, out.previous(ARM), observation, scene);
                let progress = self
                    .memory
                    .clock
                    .progress(phase, &setup.timing, now, feedback);
                if job.failure.is_some() {
                    self.memory = Memory::default();
                } else if progress == Progress::Blocked {
                    recovery::note_blocked(&setup, cube, job, out);
                    self.memory = Memory::default();
                } else if let Progress::Done(reason) = progress {
                    let (name, number) = (setup.name(cube), phase.index());
                    let why = reason.name();
                    out.transition(format_args!("[{name}] phase {number} done ({why})"));
                    if let Some(next) = phase.next() {
                        self.enter(next, cube, scene, observation, job, out);
                    } else {
                        if !self.memory.aborted {
                            recovery::note_placed(&setup, scene, cube, job);
                        }
                        self.memory = Memory::default();
                        select = true;
                    }
                }
            }
        }
        if select && job.failure.is_none() {
            self.select(scene, observation, job, out);
        }
        gripper
    }

    fn select(
        &mut self,
        scene: &Scene,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let setup = Arc::clone(&self.setup);
        if let Some(next) = selection::decide(&setup, scene, observation.time(), "decide", job, out)
        {
            self.memory.cube = Some(next.cube);
            self.memory.destination = Some(next.destination);
            self.memory.aborted = next.clears;
            self.aim(scene, observation, job);
        }
    }

    fn aim(&mut self, scene: &Scene, observation: &Observation<'_>, job: &mut Job) {
        let Some(cube) = self.memory.cube else { return };
        let failed = self
            .setup
            .cube(cube)
            .map_or(0, |c| job.attempts(c.object).pick);
        self.memory.cube_reference_xy = scene.cube(cube).position.xy().into();
        self.memory.grip_yaw = grip::choose(&self.setup, scene, cube, failed);
        self.memory.phase = 0;
        self.memory.clock = PhaseClock::start(observation.time());
        job.counters.phase_entry += 1;
    }

    fn enter(
        &mut self,
        phase: Phase,
        cube: usize,
        scene: &Scene,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let setup = Arc::clone(&self.setup);
        if phase == Phase::Grasp {
            let position = scene.cube(cube).position.into();
            self.memory.pickup = Some(Place {
                position,
                yaw: self.memory.grip_yaw,
            });
        } else if phase == Phase::Release {
            recovery::note_carried(&setup, cube, job);
        }
        let broken = phase.holding() && selection::destination_lost(&setup, scene, cube);
        if broken && !self.memory.aborted {
            self.memory.destination = Some(recovery::note_abort(&setup, scene, cube, job, out));
            self.memory.aborted = true;
        }
        self.memory.phase = phase.index();
        self.memory.clock = PhaseClock::start(observation.time());
        job.counters.phase_entry += 1;
        recovery::forget_held(job);
        if phase.holding() {
            job.held = setup.cube(cube).map(|c| c.object);
            job.destination = self.memory.destination;
            job.aborted = self.memory.aborted;
        }
    }

    fn place(&mut self, scene: &Scene, cube: usize) -> Option<Place> {
        let phase = self.memory.phase;
        if phase < 2 {
            self.memory.grip_yaw = grip::follow(scene, cube, self.memory.grip_yaw);
            Some(Place {
                yaw: self.memory.grip_yaw,
                ..scene.cube(cube).place()
            })
        } else if phase == Phase::Lift.index() {
            let (pickup, destination) = (self.memory.pickup?, self.memory.destination?);
            Some(geometry::lift_place(pickup, destination))
        } else if phase < 4 {
            self.memory.pickup
        } else {
            self.memory.destination
        }
    }

    fn phase(&self) -> Phase {
        Phase::RING
            .get(self.memory.phase as usize)
            .copied()
            .unwrap_or(Phase::PreGrasp)
    }
}

impl Policy for StackIfElse {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn reset(&mut self) {
        self.memory = Memory::default();
    }

    fn tick(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(scene) = Scene::read(&setup, observation) else {
            return;
        };
        let gripper = self.decide(&scene, observation, job, out);
        let place = self.memory.cube.and_then(|cube| self.place(&scene, cube));
        if let Some(place) = place {
            let key = u64::from(job.counters.phase_entry);
            out.arm(ARM, command::intent(&setup, self.phase(), place, key));
        } else {
            out.arm(ARM, command::hold(gripper));
        }
        let phase = place.map(|_| self.phase());
        command::report(&setup, &scene, phase, job, out);
    }

    fn phase(&self) -> Text<32> {
        self.memory
            .cube
            .map_or(Text::EMPTY, |_| Text::new(self.phase().name()))
    }

    fn describe(&self) -> Vec<Graph> {
        vec![picture::ring(Self::NAME)]
    }

    fn statuses(&self, _graph: usize, out: &mut Vec<NodeStatus>) {
        picture::statuses(self.memory.cube.map(|_| self.phase()), out);
    }

    fn save(&self) -> Vec<u8> {
        record::to_bytes(&self.memory)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        self.memory = record::from_bytes(bytes)?;
        if self
            .memory
            .cube
            .is_some_and(|c| c >= self.setup.cubes.len())
            || self.memory.phase > 7
        {
            self.memory = Memory::default();
        }
        Ok(())
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(scene) = Scene::read(&setup, observation) else {
            return;
        };
        if self.memory.cube.is_some() && self.memory.pickup.is_some() {
            self.memory.clock.unsettle();
        } else if let Some(found) = in_hand(&setup, &scene, job) {
            out.log(format_args!(
                "[resume] {} is in the hand",
                setup.name(found.cube)
            ));
            job.counters.recoveries += 1;
            job.done = false;
            self.memory = Memory {
                cube: Some(found.cube),
                destination: Some(found.destination),
                pickup: Some(found.pickup),
                grip_yaw: found.pickup.yaw,
                aborted: found.aborted,
                ..Memory::default()
            };
            self.enter(found.phase, found.cube, &scene, observation, job, out);
        } else {
            recovery::forget_held(job);
        }
    }
}

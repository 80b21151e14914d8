//! The same job as one if/else controller: attributes side by side, a phase
//! number, one long function. It is kept in one piece on purpose, to show what
//! the other policies tidy up; compare it with [`crate::stack::fsm`].

use robocell_task::TraceEvent;
use std::sync::Arc;

use behavior::{Graph, NodeStatus};
use ipc_types::GripperGoal;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use crate::stack::phase::{PhaseClock, Progress};
use crate::stack::resume::in_hand;
use crate::stack::scene::ARM;
use crate::stack::{
    Phase, StackSetup, View, command, feedback, geometry, grip, picture, recovery, selection,
};
use robocell_task::job::{Job, Placement};
use robocell_task::observation::Observation;
use robocell_task::output::Output;
use robocell_task::policy::Policy;

/// See the module.
#[derive(Clone, Debug)]
pub struct StackIfElse {
    setup: Arc<StackSetup>,
}

/// Everything it remembers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    cube: Option<usize>,
    destination: Option<Placement>,
    /// 0 to 7.
    phase: u32,
    clock: PhaseClock,
    pickup: Option<Placement>,
    cube_reference_xy: [f64; 2],
    grip_yaw: f64,
    aborted: bool,
}

impl StackIfElse {
    /// The controller for one job.
    pub fn new(setup: Arc<StackSetup>) -> Self {
        Self { setup }
    }
}

/// The controller with what it remembers.
struct Controller<'a> {
    setup: &'a StackSetup,
    memory: &'a mut Memory,
}

impl Controller<'_> {
    /// One decision up to the target: select, or drop, or resync and advance.
    fn decide(
        &mut self,
        scene: &View,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) -> GripperGoal {
        let setup = self.setup;
        let now = observation.time();
        let mut gripper = GripperGoal::Keep;
        let mut select = self.memory.cube.is_none();
        if let Some(cube) = self.memory.cube {
            let phase = self.phase();
            let reference = Vector2::from(self.memory.cube_reference_xy);
            let gone = recovery::fallen(scene, cube) || !recovery::reachable(setup, scene, cube);
            if phase.holding() && recovery::dropped(setup, scene, cube) {
                recovery::note_drop(setup, cube, job, out);
                *self.memory = Memory::default();
                gripper = GripperGoal::Open;
            } else if self.memory.pickup.is_none() && gone {
                *self.memory = Memory::default();
            } else {
                if self.memory.pickup.is_none() && recovery::moved(setup, scene, cube, reference) {
                    recovery::note_resync(setup, scene, cube, phase, job, out);
                    self.aim(scene, observation, job);
                }
                let phase = self.phase();
                let key = u64::from(job.counters.phase_entry);
                let feedback =
                    feedback::grade(setup, phase, key, out.previous(ARM), observation, scene);
                let progress = self
                    .memory
                    .clock
                    .progress(phase, &setup.timing, now, feedback);
                if job.failure.is_some() {
                    *self.memory = Memory::default();
                } else if progress == Progress::Blocked {
                    recovery::note_blocked(setup, cube, job, out);
                    *self.memory = Memory::default();
                } else if let Progress::Done(reason) = progress {
                    let (name, number) = (setup.name(cube), phase.index());
                    let why = reason.name();
                    out.transition(format_args!("[{name}] phase {number} done ({why})"));
                    if let Some(next) = phase.next() {
                        self.enter(next, cube, scene, observation, job, out);
                    } else {
                        if !self.memory.aborted {
                            recovery::note_placed(setup, scene, cube, job);
                        }
                        *self.memory = Memory::default();
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
        scene: &View,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let setup = self.setup;
        if let Some(next) = selection::decide(setup, scene, observation.time(), "decide", job, out)
        {
            self.memory.cube = Some(next.cube);
            self.memory.destination = Some(next.destination);
            self.memory.aborted = next.clears;
            self.aim(scene, observation, job);
        }
    }

    fn aim(&mut self, scene: &View, observation: &Observation<'_>, job: &mut Job) {
        let Some(cube) = self.memory.cube else { return };
        let failed = self
            .setup
            .cube(cube)
            .map_or(0, |c| job.attempts(c.object).pick);
        self.memory.cube_reference_xy = scene.cube(cube).position.xy().into();
        self.memory.grip_yaw = grip::choose(self.setup, scene, cube, failed);
        self.memory.phase = 0;
        self.memory.clock = PhaseClock::start(observation.time());
        job.counters.phase_entry += 1;
    }

    fn enter(
        &mut self,
        phase: Phase,
        cube: usize,
        scene: &View,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let setup = self.setup;
        if phase == Phase::Grasp {
            let position = scene.cube(cube).position.into();
            self.memory.pickup = Some(Placement {
                position,
                yaw: self.memory.grip_yaw,
            });
        } else if phase == Phase::Release {
            recovery::note_carried(setup, cube, job);
        }
        let broken = phase.holding() && selection::destination_lost(setup, scene, cube);
        if broken && !self.memory.aborted {
            self.memory.destination = Some(recovery::note_abort(setup, scene, cube, job, out));
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

    fn place(&mut self, scene: &View, cube: usize) -> Option<Placement> {
        let phase = self.memory.phase;
        if phase < 2 {
            self.memory.grip_yaw = grip::follow(scene, cube, self.memory.grip_yaw);
            Some(Placement {
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
        self.memory.phase()
    }
}

impl Memory {
    fn phase(&self) -> Phase {
        let phase = Phase::RING.get(self.phase as usize);
        phase.copied().unwrap_or(Phase::PreGrasp)
    }

    /// The phase of the transfer, if there is one.
    fn active(&self) -> Option<Phase> {
        self.cube.map(|_| self.phase())
    }
}

impl Policy for StackIfElse {
    type Memory = Memory;

    fn decide(
        &self,
        memory: &mut Memory,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let Some(scene) = View::read(&self.setup, observation) else {
            return;
        };
        let mut controller = Controller {
            setup: &self.setup,
            memory,
        };
        let gripper = controller.decide(&scene, observation, job, out);
        let cube = controller.memory.cube;
        let place = cube.and_then(|cube| controller.place(&scene, cube));
        if let Some(place) = place {
            let key = u64::from(job.counters.phase_entry);
            let intent = command::intent(&self.setup, memory.phase(), place, key);
            out.arm(ARM, intent);
        } else {
            out.arm(ARM, command::hold(gripper));
        }
        let phase = place.map(|_| memory.phase());
        command::report(&self.setup, &scene, phase, job, out);
    }

    fn is_sound(&self, memory: &Memory) -> bool {
        let cubes = self.setup.cubes.len();
        memory.phase <= 7 && memory.cube.is_none_or(|cube| cube < cubes)
    }

    fn phase(&self, memory: &Memory) -> &str {
        memory.active().map_or("", Phase::name)
    }

    fn describe(&self, name: &str) -> Graph {
        picture::ring(name)
    }

    fn statuses(&self, memory: &Memory, out: &mut Vec<NodeStatus>) {
        picture::statuses(memory.active(), out);
    }

    fn reconcile(
        &self,
        memory: &mut Memory,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let setup = &*self.setup;
        let Some(scene) = View::read(setup, observation) else {
            return;
        };
        if memory.cube.is_some() && memory.pickup.is_some() {
            memory.clock.unsettle();
        } else if let Some(found) = in_hand(setup, &scene, job) {
            let name = setup.name(found.cube);
            out.event(
                TraceEvent::Recover,
                format_args!("[resume] {name} is in the hand"),
            );
            job.counters.recoveries += 1;
            job.done = false;
            *memory = Memory {
                cube: Some(found.cube),
                destination: Some(found.destination),
                pickup: Some(found.pickup),
                grip_yaw: found.pickup.yaw,
                aborted: found.aborted,
                ..Memory::default()
            };
            let mut controller = Controller { setup, memory };
            controller.enter(found.phase, found.cube, &scene, observation, job, out);
        } else {
            recovery::forget_held(job);
        }
    }
}

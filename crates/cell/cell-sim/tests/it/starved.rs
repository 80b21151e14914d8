//! Controllers that get too little of the processor: they sleep through states,
//! answer late, lose commands and restart, and never break a limit.
//!
//! Time is counted in ticks and parts of ticks; each controller takes the newest
//! state when it is free and publishes when it is done, as the processes do.

use cell_model::random::Random;
use cell_model::{Cell, Data};
use controller_proc::cycle::Cycle;
use ipc_types::arm::StopAction;
use ipc_types::decision::GoalKind;
use ipc_types::{
    ArmCommand, ArmStatus, Decision, GripperGoal, Header, MAX_ARMS, Pose, Wire, WorldState,
};
use physics_proc::world::{StepInput, World};

/// Age limit of decisions (ticks): without real-time scheduling.
const LIMIT: u64 = 100;
/// Ticks between two goals: arms are always on their way.
const GOAL_TICKS: u64 = 250;

/// How a controller fares.
#[derive(Clone, Copy)]
enum Fate {
    /// Each answer takes this long (ticks).
    Steady(f64),
    /// Bursts of every length of starvation, losses, and new starts.
    Random,
}

/// One controller and its place on a busy machine.
struct Starved {
    arm: usize,
    cycle: Cycle,
    status: ArmStatus,
    generation: u32,
    seq: u64,
    /// Busy or starved until then (ticks).
    free_at: f64,
    /// The present spell: its end, and how long answers take in it (ticks).
    spell: (f64, f64),
    /// Last state it took.
    answered: u64,
    /// Published, but not before its time.
    pending: Vec<(f64, ArmCommand)>,
    /// The messages that physics has.
    newest: Option<ArmCommand>,
    random: Random,
}

impl Starved {
    fn new(cell: &Cell, arm: usize, seed: u64) -> Self {
        Self {
            arm,
            status: ArmStatus::zeroed(),
            cycle: Cycle::new(cell, arm).expect("a controller"),
            generation: 1,
            seq: 0,
            free_at: 0.0,
            spell: (0.0, 0.3),
            answered: u64::MAX,
            pending: Vec::new(),
            newest: None,
            random: Random::new(seed * 16 + arm as u64),
        }
    }

    /// Evenly from 0 to `most`.
    fn upto(&mut self, most: f64) -> f64 {
        0.5 * most + self.random.around_zero(0.5 * most)
    }

    fn is_lucky(&mut self, chance: f64) -> bool {
        self.upto(1.0) < chance
    }

    /// How long this answer takes (ticks).
    fn duration(&mut self, now: f64, fate: Fate) -> f64 {
        if let Fate::Steady(ticks) = fate {
            return ticks;
        }
        if now >= self.spell.0 {
            let (length, takes) = [(300.0, 0.4), (100.0, 1.6), (60.0, 6.0), (40.0, 60.0)]
                [usize::try_from(self.random.bits() % 4).expect("small")];
            self.spell = (now + self.upto(length), takes);
        }
        self.upto(self.spell.1)
    }

    /// Its actions between the publication of `state` and that of the next one.
    fn live(&mut self, cell: &Cell, state: &WorldState, decision: &Decision, fate: Fate) {
        let tick = state.header.tick;
        let end = tick as f64 + 1.0;
        // A state is there as soon as it is published; one is taken once.
        if self.free_at < end && self.answered != tick {
            let start = self.free_at.max(tick as f64);
            self.answered = tick;
            let done = start + self.duration(start, fate);
            self.free_at = done;
            self.answer(cell, state, decision, done, fate);
        }
        while self.pending.first().is_some_and(|(at, _)| *at < end) {
            self.newest = Some(self.pending.remove(0).1);
        }
    }

    /// Answers `state`; the command is there `at` a time (ticks).
    fn answer(&mut self, cell: &Cell, state: &WorldState, goal: &Decision, at: f64, fate: Fate) {
        let unlucky = matches!(fate, Fate::Random);
        if unlucky && self.is_lucky(1.0 / 3_000.0) {
            self.restart(cell, at);
            return;
        }
        let mut command = ArmCommand::zeroed();
        self.cycle
            .update(state, Some(goal), LIMIT, &mut command, &mut self.status);
        self.seq += 1;
        command.header.generation = self.generation;
        command.header.seq = self.seq;
        if !unlucky || !self.is_lucky(0.02) {
            self.pending.push((at, command));
        }
    }

    /// Dies; a new one starts some time later.
    fn restart(&mut self, cell: &Cell, at: f64) {
        self.cycle = Cycle::new(cell, self.arm).expect("a controller");
        self.generation += 1;
        self.seq = 0;
        self.pending.clear();
        self.free_at = at + self.upto(300.0);
    }
}

/// A cell, the machine on which it runs, and the task that moves the arms back and forth.
struct Machine {
    cell: Cell,
    world: World,
    state: Box<WorldState>,
    decision: Decision,
    controllers: Vec<Starved>,
    random: Random,
}

impl Machine {
    fn new(demo: &str, seed: u64) -> Self {
        let cell = Cell::load(&Data::checkout(), demo, seed, None).expect("a cell");
        let arms = cell.arms.len();
        let mut decision = Decision::zeroed();
        decision.arm_count = u32::try_from(arms).expect("few");
        for goal in &mut decision.goals {
            goal.target = Pose::IDENTITY;
            goal.obstacle_mask = u64::MAX;
        }
        Self {
            world: World::new(&cell).expect("a world"),
            controllers: (0..arms)
                .map(|arm| Starved::new(&cell, arm, seed))
                .collect(),
            cell,
            state: Box::new(WorldState::zeroed()),
            decision,
            random: Random::new(seed),
        }
    }

    /// Sends every arm somewhere else, hands down.
    fn goals(&mut self) {
        for goal in &mut self.decision.goals[..self.controllers.len()] {
            goal.goal_id += 1;
            goal.kind = GoalKind::Pose.code();
            goal.gripper = GripperGoal::Open.code();
            let mut around = |middle: f64, half| middle + self.random.around_zero(half);
            goal.target = Pose {
                position: [around(0.45, 0.15), around(0.0, 0.4), around(0.35, 0.2)],
                orientation_wxyz: [0.0, 1.0, 0.0, 0.0],
            };
        }
    }

    fn run(&mut self, ticks: u64, fate: Fate) {
        for _ in 0..ticks {
            self.world.write_state(&mut self.state);
            self.state.header.generation = 1;
            let tick = self.state.header.tick;
            if tick.is_multiple_of(GOAL_TICKS) {
                self.goals();
            }
            if tick.is_multiple_of(10) {
                self.decision.header = Header::caused_by::<Decision>(tick);
                self.decision.header.generation = 1;
            }
            let mut commands = [None; MAX_ARMS];
            for (slot, controller) in commands.iter_mut().zip(&mut self.controllers) {
                controller.live(&self.cell, &self.state, &self.decision, fate);
                *slot = controller.newest.as_ref();
            }
            self.world.step(&StepInput {
                commands,
                decision: None,
            });
        }
        self.world.write_state(&mut self.state);
    }

    fn assert_no_violation(&self, what: &str) {
        for arm in self.state.arms() {
            assert_eq!((arm.limit_violations, arm.fault), (0, 0), "{what}");
        }
    }

    /// Every arm follows its controller.
    fn assert_heard(&self, what: &str) {
        for arm in self.state.arms() {
            let stop = StopAction::None.code();
            assert_eq!(arm.stop_action, stop, "{what}");
            assert!(arm.command_tick + 4 > self.state.header.tick, "{what}");
        }
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn no_spell_of_starvation_breaks_a_limit_and_each_is_recovered_from() {
    for (demo, seeds) in [("franka-stack", 1..=12), ("franka-pyramid", 13..=20)] {
        for seed in seeds {
            let mut machine = Machine::new(demo, seed);
            machine.run(100, Fate::Steady(0.3));
            machine.run(8_000, Fate::Random);
            machine.run(600, Fate::Steady(0.3));
            let what = format!("{demo}, seed {seed}");
            machine.assert_no_violation(&what);
            machine.assert_heard(&what);
        }
    }
}

#[test]
fn a_controller_that_is_always_late_is_heard_all_the_same() {
    for late in [1.2, 2.5, 8.0] {
        let mut machine = Machine::new("franka-stack", 1);
        machine.run(500, Fate::Steady(late));
        // Everything is stopped for long enough that physics brakes.
        machine.controllers[0].free_at += 100.0;
        machine.run(1_500, Fate::Steady(late));
        let what = format!("{late} ticks late");
        machine.assert_no_violation(&what);
        let arm = &machine.state.arms[0];
        assert_eq!(arm.stop_action, StopAction::None.code(), "{what}");
    }
}

#[test]
fn a_scene_that_was_reset_is_begun_anew_though_the_first_answer_is_not_taken() {
    let mut machine = Machine::new("franka-stack", 1);
    machine.run(700, Fate::Steady(0.3));
    // The tick of the reset is answered a second time, and that is not taken.
    machine.world.reset().expect("the scene it began with");
    machine.run(600, Fate::Steady(0.3));
    machine.assert_no_violation("reset");
    machine.assert_heard("reset");
}

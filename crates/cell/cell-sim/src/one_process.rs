//! The cores of a cell in one process, called in the order in which their messages would be
//! delivered.
//!
//! `eval`, the tests and `robocell.Cell` of Python trust that a run here has the state hash of
//! the four processes in lockstep (ADR 0004). It differs as soon as one core sees a message one
//! tick earlier or later than its process would. The rules that prevent it:
//!
//! - A decision and a command that are computed from a state act on the *next* tick: physics
//!   gets them in its following step, controllers in their following update.
//! - A restart of the task or of a controller rebuilds it from the same checkpoint or from
//!   nothing, exactly as its process would.
//! - Plans are answered by the same pure function, after the same number of ticks (ADR 0021).
//! - Nothing here reads a clock: ages are differences of ticks (ADR 0002).
//!
//! A change must keep the order in `answer`: state, then decision, then commands, with the
//! *previous* decision given to the controllers.

use cell_model::Cell;
use cell_model::cells::script::ScriptAction;
use cell_model::stop::DECISION_AGE_FIFO_TICKS;
use cell_run::message::Message;
use cell_run::spec::RunSpec;
use cell_run::summary::{RunFacts, RunSummary};
use controller_proc::Controllers;
use controller_proc::cycle::Cycle;
use controller_proc::planning::Planner;
use ipc_types::{
    ArmCommand, ArmStatus, DECISION_TICKS, Decision, MAX_ARMS, OperatorReply, OperatorRequest,
    Wire, WorldState,
};
use physics_proc::plant::{Next, Plant};
use physics_proc::world::StepInput;
use robocell_task::starts::{Decider, NoHistory};
use robocell_task::{Policies, Task};

use crate::SimError;
use crate::action::Hold;
use crate::given::{self, Decisions};

/// A cell without a bus. One call of [`OneProcess::tick`] is one tick of the
/// cell: physics, controllers, and on every tenth tick the task.
pub struct OneProcess {
    pub(crate) cell: Cell,
    pub(crate) policies: Policies,
    pub(crate) controllers: Controllers,
    pub(crate) policy: String,
    pub(crate) plant: Plant,
    pub(crate) cycles: Vec<Cycle>,
    /// By arm.
    planners: Vec<Planner>,
    pub(crate) decider: Decider,
    pub(crate) state: Box<WorldState>,
    pub(crate) commands: Vec<ArmCommand>,
    pub(crate) statuses: Vec<ArmStatus>,
    /// Of actions below the rate of decisions.
    hold: Option<Hold>,
    /// In place of those of the task.
    decisions: Option<Decisions>,
    /// The newest decision. Once made it acts from the next tick on.
    pub(crate) decision: Decision,
    pub(crate) decided: bool,
    pub(crate) trace: Vec<(u64, String)>,
    lines: Vec<robocell_task::TraceLineText>,
    pub(crate) task_restarts: u32,
    /// Reason for which the task failed.
    pub(crate) message: Message,
    warnings: Vec<String>,
    /// Faults of physics reported so far.
    faults: usize,
    lost: usize,
}

impl OneProcess {
    /// Sets up the cell of `spec` with the built-in controllers. Every core answers its first
    /// state.
    pub fn new(policies: &Policies, spec: &RunSpec, cell: Cell) -> Result<Self, SimError> {
        Self::with(policies, &Controllers::default(), spec, cell)
    }

    /// As [`OneProcess::new`], with `controllers`.
    pub fn with(
        policies: &Policies,
        controllers: &Controllers,
        spec: &RunSpec,
        cell: Cell,
    ) -> Result<Self, SimError> {
        let task = policies.task(&cell, &spec.policy)?;
        Self::assembled(policies, controllers, spec, cell, (task, None))
    }

    /// A cell without a task, whose arms and equipment follow `decisions`.
    pub fn following(
        controllers: &Controllers,
        spec: &RunSpec,
        cell: Cell,
        decisions: Decisions,
    ) -> Result<Self, SimError> {
        let task = (given::task(&cell), Some(decisions));
        Self::assembled(&Policies::default(), controllers, spec, cell, task)
    }

    fn assembled(
        policies: &Policies,
        controllers: &Controllers,
        spec: &RunSpec,
        cell: Cell,
        (task, decisions): (Task, Option<Decisions>),
    ) -> Result<Self, SimError> {
        let plant = Plant::new(&cell, spec)?;
        let cycles = cycles(&cell, controllers)?;
        let decider = Decider::new(task);
        let mut sim = Self {
            policies: policies.clone(),
            controllers: controllers.clone(),
            policy: spec.policy.clone(),
            plant,
            commands: vec![ArmCommand::zeroed(); cycles.len()],
            statuses: vec![ArmStatus::zeroed(); cycles.len()],
            planners: (0..cycles.len())
                .map(|arm| Planner::new(&cell, arm))
                .collect::<Result<_, _>>()?,
            cycles,
            decider,
            hold: Hold::of(spec)?,
            decisions,
            state: Box::new(WorldState::zeroed()),
            decision: Decision::zeroed(),
            decided: false,
            trace: Vec::new(),
            lines: Vec::new(),
            task_restarts: 0,
            message: Message::default(),
            // Warnings of the cell are reported first: they explain errors in the ticks that
            // follow.
            warnings: physics_proc::warnings(&cell),
            faults: 0,
            lost: 0,
            cell,
        };
        // Processes answer the first state before the first step, too; without this the first
        // step would have no command.
        sim.answer();
        Ok(sim)
    }

    /// The newest state.
    pub fn state(&self) -> &WorldState {
        &self.state
    }

    /// The memory of the task, encoded.
    pub fn task_checkpoint(&self) -> Vec<u8> {
        self.decider.task.checkpoint()
    }

    /// The newest decision.
    pub fn decision(&self) -> &Decision {
        &self.decision
    }

    /// The newest status of each arm.
    pub fn statuses(&self) -> &[ArmStatus] {
        &self.statuses
    }

    /// The plant, for measuring.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Log lines of the task since the last call, with their ticks.
    pub fn take_trace(&mut self) -> Vec<(u64, String)> {
        std::mem::take(&mut self.trace)
    }

    /// Warnings about the run since the last call.
    pub fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    /// The task, for the graphs of its policy.
    pub fn task(&self) -> &Task {
        &self.decider.task
    }

    /// Summary of the run up to now; `wall_time_s` is copied into it.
    pub fn summary(&self, spec: &RunSpec, wall_time_s: f64) -> RunSummary {
        let names = self.cell.objects.iter().map(|object| object.name.clone());
        let facts = RunFacts {
            demo: &spec.demo,
            policy: &spec.policy,
            seed: spec.seed,
            objects: &names.collect::<Vec<_>>(),
            wall_time_s,
            task_restarts: self.task_restarts,
            missed_cycles: self.statuses.iter().map(|s| s.missed_cycles).sum(),
        };
        let summary = RunSummary::new(&facts, &self.state, &self.decision);
        RunSummary {
            script_replies: self.plant.script_replies().to_vec(),
            policy_server: self.decider.task.server_report(),
            ..summary.with_message(self.message.text())
        }
    }

    /// Starts of the task after the first.
    pub fn task_restarts(&self) -> u32 {
        self.task_restarts
    }

    /// Whether the run has ended: its task is done or failed, or its time limit is reached.
    pub fn is_ending(&self) -> bool {
        self.plant.is_ending()
    }

    /// Handles an operator's request and returns the answer of physics.
    pub fn answer_request(&mut self, request: &OperatorRequest) -> OperatorReply {
        self.plant.answer_request(request)
    }

    /// One tick. `false` if no step was made: the cell is paused, or its run has ended.
    pub fn tick(&mut self) -> Result<bool, SimError> {
        self.tick_observed(|_| {})
    }

    /// As [`OneProcess::tick`]; `observe` is called right before the step of
    /// physics (`true`) and right after it (`false`), for measuring.
    pub fn tick_observed(&mut self, mut observe: impl FnMut(bool)) -> Result<bool, SimError> {
        let decision = self.decided.then_some(&self.decision);
        let mut next = self.plant.before_step(decision);
        // Lines of a script that concern a process (kill, stop) are the launcher's, which
        // physics waits for (ADR 0001). Here the request is carried out and acknowledged at
        // once.
        while let Some((line, action)) = self.plant.waiting().cloned() {
            self.apply_script(&action)?;
            let mut done = OperatorRequest::zeroed();
            done.action = ipc_types::operator::OperatorAction::ScriptDone.code();
            done.count = line;
            self.plant.answer_request(&done);
            next = self
                .plant
                .before_step(self.decided.then_some(&self.decision));
        }
        // The state is written even without a step: a request may have changed the panel in it.
        if next == Next::Wait {
            self.plant.write_state(&mut self.state);
            return Ok(false);
        }
        // Commands are those of the last `answer`: each acts one tick after the state that
        // caused it.
        let mut commands = [None; MAX_ARMS];
        for (slot, command) in commands.iter_mut().zip(&self.commands) {
            *slot = Some(command);
        }
        let decision = self.decided.then_some(&self.decision);
        observe(true);
        self.plant.step(&StepInput { commands, decision });
        observe(false);
        self.report_faults();
        self.answer();
        Ok(true)
    }

    /// Reports the faults of physics that its process would log.
    fn report_faults(&mut self) {
        let world = self.plant.world();
        if std::mem::replace(&mut self.faults, world.faults()) < world.faults() {
            self.warnings.push(world.fault_words());
        }
        let known = std::mem::replace(&mut self.lost, world.lost());
        if known < self.lost {
            self.warnings.push(world.lost_words(known));
        }
    }

    /// The task and all controllers answer the present state.
    fn answer(&mut self) {
        self.plant.write_state(&mut self.state);
        let tick = self.state.header.tick;
        // A decision of this tick counts from the next tick on, so controllers get the one
        // before. The copy is made only then.
        let decides = tick.is_multiple_of(DECISION_TICKS);
        let (was_decided, copy) = (self.decided, decides.then_some(self.decision));
        if decides {
            self.decide(tick);
        }
        let in_force = copy.as_ref().unwrap_or(&self.decision);
        let previous = was_decided.then_some(in_force);
        let answers = self
            .cycles
            .iter_mut()
            .zip(&mut self.commands)
            .zip(&mut self.statuses)
            .zip(&mut self.planners);
        // A plan is taken before the update, as in the controller process: its answer belongs
        // to this tick (ADR 0021).
        for (((cycle, command), status), planner) in answers {
            cycle.plan_with(planner, tick);
            cycle.update(
                &self.state,
                previous,
                DECISION_AGE_FIFO_TICKS,
                command,
                status,
            );
        }
    }

    fn decide(&mut self, tick: u64) {
        if let Some(decisions) = &mut self.decisions {
            decisions(tick, &mut self.decision);
            self.decided = true;
            return;
        }
        let mut statuses = [None; MAX_ARMS];
        for (slot, status) in statuses.iter_mut().zip(&self.statuses) {
            // At tick 0 no controller has a status yet: their memory is zeroed, not a message.
            *slot = (tick > 0).then_some(status);
        }
        self.lines.clear();
        // Physics is started once here, so no older state of it can return: no history is
        // needed.
        let _begun = self.decider.begin(&self.state, &mut NoHistory);
        let before = self.hold.map(|_| self.decision);
        self.decider
            .decide(&self.state, &statuses, &mut self.decision, &mut self.lines);
        if let (Some(hold), Some(before)) = (self.hold, before) {
            hold.apply(tick, &before, &mut self.decision);
        }
        // As in a process, the generation is the number of starts of the task: physics reports
        // by it which task it obeys.
        self.decision.header.generation = self.task_restarts + 1;
        self.decided = true;
        self.warnings.extend(self.decider.task.take_warnings());
        self.message
            .update(self.decider.task.message(), self.decider.task.has_failed());
        self.trace.extend(
            self.lines
                .iter()
                .filter(|line| line.kind.is_for_people())
                .map(|line| (tick, line.text.as_str().to_owned())),
        );
    }

    /// Carries out an action that the launcher would apply to a process.
    fn apply_script(&mut self, action: &ScriptAction) -> Result<(), SimError> {
        if let ScriptAction::Restart {
            policy: Some(policy),
            ..
        } = action
        {
            self.policy.clone_from(policy);
        }
        let (ScriptAction::Kill { process } | ScriptAction::Restart { process, .. }) = action
        else {
            return Ok(());
        };
        match process.as_str() {
            "task" => self.restart_task(),
            "controller" => {
                self.cycles = cycles(&self.cell, &self.controllers)?;
                Ok(())
            }
            word if word.starts_with("controller-") => self.restart_controller(word),
            // Physics and this process are the same, and no monitor exists: nothing to restart.
            _ => Ok(()),
        }
    }

    /// Drops one controller, named as a process, for a new one.
    fn restart_controller(&mut self, process: &str) -> Result<(), SimError> {
        let arms = self.cycles.iter_mut().enumerate();
        for (arm, cycle) in arms.filter(|(arm, _)| process == format!("controller-{arm}")) {
            *cycle = Cycle::with(&self.cell, arm, &self.controllers)?;
        }
        Ok(())
    }

    /// Drops the task; a new one resumes from its checkpoint.
    pub fn restart_task(&mut self) -> Result<(), SimError> {
        // The tick of the last decision is handed over, too: by it the new decider notices
        // missed ticks and another start of physics.
        let checkpoint = self.decider.task.checkpoint();
        let decided = self.decider.decided();
        let mut decider = Decider::new(self.policies.task(&self.cell, &self.policy)?);
        decider.restore(&checkpoint, decided)?;
        self.decider = decider;
        self.task_restarts += 1;
        // The log line that a task process writes after a restart.
        let line = self.decider.task.restored().line();
        self.trace.push((self.state.header.tick, line.to_owned()));
        Ok(())
    }
}

fn cycles(cell: &Cell, controllers: &Controllers) -> Result<Vec<Cycle>, SimError> {
    (0..cell.arms.len())
        .map(|arm| Cycle::with(cell, arm, controllers).map_err(SimError::from))
        .collect()
}

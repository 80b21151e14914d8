//! What the loops that command an arm have in common: states in, a command and a status out.
//!
//! A new kind of controller for an arm adds its cycle, and its waits for other inputs.

use cell_bus::{Bus, BusError, Doorbell, Publisher, Subscriber};
use cell_rt::Clock;
use cell_rt::periodic::{SPIN_FIFO_NS, SPIN_OTHER_NS};
use cell_rt::priority::CONTROLLER_PRIORITY;
use ipc_types::topic::{Process, TopicId};
use ipc_types::world::FLAG_LOCKSTEP;
use ipc_types::{ArmCommand, ArmStatus, Header, Invalid, TICK_NS, Wire, WorldState};

use crate::{HealthReporter, Keyframes, LoopClass, Start, Wait};

/// How long lockstep polls before it sleeps (ns): longer than a step of physics.
// Sleeping costs two switches of context in each tick.
const SPIN_LOCKSTEP_NS: u64 = 300_000;
/// Longest wait for a state in real time (ns); after it the turn ends without a cycle.
// Five ticks: health is reported and late subscribers are served while physics is away.
const PATIENCE_NS: u64 = 5_000_000;

/// Ports and timing of the loop that commands an arm.
pub struct ArmLoop<C> {
    state: Subscriber<WorldState>,
    command: Publisher<ArmCommand>,
    status: Publisher<ArmStatus>,
    keyframes: Keyframes,
    /// The command of the cycle.
    pub sent: ArmCommand,
    /// The status of the cycle.
    pub report: ArmStatus,
    physics_bell: Doorbell,
    task_bell: Doorbell,
    /// Health of the process.
    pub health: HealthReporter,
    clock: C,
    spin_ns: u64,
    class: LoopClass,
    lockstep: bool,
    expected_ns: u64,
    woke_ns: u64,
    polling: Polling,
}

/// A wait for a state.
#[derive(Clone, Copy, Default)]
struct Polling {
    /// Time of the last look; `None` before the first.
    until_ns: Option<u64>,
    /// Whether lockstep has slept at its doorbell.
    has_slept: bool,
}

/// The end of a turn.
pub struct Ended {
    /// Whether it had a cycle.
    pub has_cycle: bool,
    /// Tick of the last cycle.
    pub tick: u64,
    /// Values of the cycle that are kept for an incident.
    pub values: [f64; 4],
    /// Ticks without a cycle.
    pub missed: u64,
    /// Messages of other topics that were rejected, and that came from an earlier start of their
    /// writer.
    pub refused: (u64, u64),
}

impl<C: Clock> ArmLoop<C> {
    /// The loop of the arm of this process, whose thread has `SCHED_FIFO` if `fifo`.
    ///
    /// # Errors
    ///
    /// When a port cannot be opened.
    pub fn new(start: &Start, bus: &Bus, fifo: bool, clock: C) -> Result<Self, BusError> {
        let arm = start.arm;
        let process = Process::Controller(arm);
        let health = HealthReporter::new(start, bus, process, fifo, clock.now_ns())?;
        Ok(Self {
            state: bus.subscriber(TopicId::WorldState)?,
            command: bus.publisher(TopicId::ArmCommand(arm))?,
            status: bus.publisher(TopicId::ArmStatus(arm))?,
            keyframes: Keyframes::new(bus.publisher(TopicId::Keyframe(process))?),
            sent: ArmCommand::zeroed(),
            report: ArmStatus::zeroed(),
            physics_bell: bus.doorbell(Process::Physics)?,
            task_bell: bus.doorbell(Process::Task)?,
            health,
            clock,
            spin_ns: if fifo { SPIN_FIFO_NS } else { SPIN_OTHER_NS },
            class: LoopClass::new(start, CONTROLLER_PRIORITY, fifo),
            lockstep: false,
            expected_ns: 0,
            woke_ns: 0,
            polling: Polling::default(),
        })
    }

    /// The newest state.
    pub fn state(&self) -> Option<&WorldState> {
        self.state.current()
    }

    /// The newest state, and where its cycle writes command and status.
    pub fn cycle(&mut self) -> (Option<&WorldState>, &mut ArmCommand, &mut ArmStatus) {
        (self.state.current(), &mut self.sent, &mut self.report)
    }

    /// Generation of physics and tick of the newest state.
    pub fn newest(&self) -> Option<(u32, u64)> {
        let header = self.state.current().map(|state| &state.header)?;
        Some((header.generation, header.tick))
    }

    /// Whether simulated time waits for this process.
    pub fn is_lockstep(&self) -> bool {
        self.lockstep
    }

    /// When the present cycle began (ns).
    pub fn woke_ns(&self) -> u64 {
        self.woke_ns
    }

    /// Takes a state that has arrived: false where there is none.
    pub fn take_state(&mut self) -> bool {
        let Some(state) = self.state.take() else {
            return false;
        };
        // The mode is part of the state: it changes with the speed, at a known tick.
        self.lockstep = state.has(FLAG_LOCKSTEP);
        self.class.follow(self.lockstep);
        self.health.set_lockstep(self.lockstep);
        true
    }

    /// A cycle begins.
    pub fn begin(&mut self) {
        self.woke_ns = self.clock.now_ns();
    }

    /// How to wait for a state that has not arrived; `None` where it stays away, and the turn ends
    /// without a cycle.
    pub fn poll(&mut self, now_ns: u64) -> Option<Wait> {
        let patience_ns = if self.lockstep {
            SPIN_LOCKSTEP_NS
        } else {
            PATIENCE_NS
        };
        let until_ns = *self.polling.until_ns.get_or_insert(now_ns + patience_ns);
        Some(match self.lockstep {
            true if now_ns < until_ns => Wait::Yield,
            true if !self.polling.has_slept => {
                self.polling.has_slept = true;
                Wait::Bell
            }
            // Overdue: physics is late, starting, or not running. Polling would take its core.
            false if now_ns <= until_ns && now_ns > self.expected_ns + self.spin_ns => {
                Wait::Sleep(now_ns + self.spin_ns)
            }
            false if now_ns <= until_ns => Wait::Spin,
            _ => {
                self.woke_ns = now_ns;
                return None;
            }
        })
    }

    /// Publishes status and command; whether the command was sent.
    pub fn publish(&mut self) -> bool {
        let (command, report) = (&self.sent, &self.report);
        // Status before command: a process that has the command may rely on the status.
        let _sent = self.status.publish(|message| *message = *report).is_ok();
        let is_sent = self.command.publish(|message| *message = *command).is_ok();
        if self.lockstep {
            self.physics_bell.ring();
            self.task_bell.ring();
        }
        is_sent
    }

    /// Publishes the checkpoint of before the first command, so that a replay can start there.
    pub fn keep_first(&mut self, save: impl FnOnce(&mut [u8]) -> Option<usize>) {
        self.keep(&Header::zeroed(), save);
    }

    /// Publishes the checkpoint of after the command of `tick`, once a second.
    pub fn keep_if_due(&mut self, tick: u64, save: impl FnOnce(&mut [u8]) -> Option<usize>) {
        if self.keyframes.is_due(tick, false) {
            let of_command = self.sent.header;
            self.keep(&of_command, save);
        }
    }

    fn keep(&mut self, of_command: &Header, save: impl FnOnce(&mut [u8]) -> Option<usize>) {
        let after_seq = self.command.seq();
        if !self.keyframes.send_whole(of_command, after_seq, save) {
            self.health
                .note("the controller's checkpoint could not be kept: no replay verifies this run");
        }
    }

    /// A message of another topic was invalid.
    pub fn refused(&mut self, topic: &'static str, invalid: Option<Invalid>) {
        if invalid.is_some() {
            self.health.refused(topic, invalid, self.clock.now_ns());
        }
    }

    /// Ends a turn, and starts the wait for the next state.
    pub fn finish(&mut self, ended: &Ended) -> Wait {
        // Before the first state nothing is expected, so nothing is late. In lockstep the time
        // of a state depends on all processes, so lateness means nothing.
        let late_ns = if self.lockstep || self.expected_ns == 0 {
            0
        } else {
            self.woke_ns.saturating_sub(self.expected_ns)
        };
        self.expected_ns = self.woke_ns + TICK_NS;
        let now_ns = self.clock.now_ns();
        if ended.has_cycle {
            self.health
                .cycle(ended.tick, self.woke_ns, late_ns, ended.values, now_ns);
        } else {
            self.health.idle();
            // A subscriber that joined late gets the newest message only by this call.
            self.command.update_connections();
            self.status.update_connections();
        }
        let states = self.state.counts();
        let (rejected, fenced) = ended.refused;
        self.health.totals(
            ended.missed,
            rejected + states.rejected,
            fenced + states.fenced,
        );
        self.health
            .refused("state", self.state.take_invalid(), now_ns);
        self.health.publish_if_due(ended.tick, now_ns);
        self.polling = Polling::default();
        if self.lockstep {
            return Wait::Spin;
        }
        // Sleeping is not exact enough for the start of a cycle; polling all the time takes a
        // core. So it sleeps until shortly before the next state is due, then polls.
        Wait::Sleep(self.expected_ns.saturating_sub(self.spin_ns))
    }
}

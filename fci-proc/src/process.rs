//! The interface on the bus: one cycle for each new state.
//!
//! - State k goes to the client in the cycle of tick k. Its answer is taken in the next cycle,
//!   so a client has a millisecond, as at the robot.
//! - In real time a cycle never waits for the client.
//! - In lockstep it waits for the answer of a client that moves the arm. Without such a client
//!   simulated time does not pass, and states are repeated every millisecond of the wall clock.
//! - Ticks that this process missed are not sent later: the client answers only the newest
//!   state, and the others would count as lost. They do not count as time of the robot.

use std::net::{IpAddr, Ipv4Addr};

use cell_bus::{Bus, BusError, Doorbell, Publisher, Subscriber};
use cell_model::runs::spec::Fci;
use cell_rt::periodic::{SPIN_FIFO_NS, SPIN_OTHER_NS};
use cell_rt::priority::CONTROLLER_PRIORITY;
use cell_rt::{Clock, Monotonic};
use cell_worker::{HealthReporter, Keyframes, LoopClass, Start, Turn, Wait, Woken};
use fci::STATE_BYTES;
use ipc_types::topic::{Process, TopicId};
use ipc_types::world::FLAG_LOCKSTEP;
use ipc_types::{ArmCommand, ArmStatus, Header, TICK_NS, Wire, WorldState};

use crate::cycle::Cycle;
use crate::error::ProcessError;
use crate::messages;
use crate::net::Net;

mod client;
mod inputs;

use inputs::Inputs;

/// Longest wait for a state in real time (ns); after it the turn ends without a cycle.
const PATIENCE_NS: u64 = 5_000_000;
/// How long lockstep polls for an answer before it sleeps in between (ns).
const SPIN_LOCKSTEP_NS: u64 = 300_000;

/// Runs the interface until it is asked to stop.
///
/// # Errors
///
/// When the robot has no such interface, its ports are in use, or the bus cannot be joined.
pub fn run(start: &Start) -> Result<(), ProcessError> {
    let cycle = Cycle::new(&start.cell, start.arm)?;
    let arm = start.cell.arms.get(usize::from(start.arm));
    let urdf = arm.map(|arm| fci::urdf(&arm.robot)).unwrap_or_default();
    // Before this thread gets its priority, which new threads would inherit.
    let net = Net::listen(address(start), urdf, cycle.gripper().is_some())?;
    let fifo = start.real_time(CONTROLLER_PRIORITY, 1 + usize::from(start.arm));
    let bus = start.join(Process::Controller(start.arm))?;
    let mut bell = bus.sleeper(Process::Controller(start.arm))?;
    let mut process = FciProcess::new(start, &bus, (cycle, net), fifo, Monotonic)?;
    start.populate();
    cell_worker::run(&mut process, &mut bell);
    Ok(())
}

/// Where the arm listens: the address of its run, or the loopback address of its number.
fn address(start: &Start) -> IpAddr {
    interface(start).map_or(IpAddr::V4(Ipv4Addr::LOCALHOST), |fci| fci.address)
}

/// The interface in the run file.
fn interface(start: &Start) -> Option<Fci> {
    *start.spec.fci.get(usize::from(start.arm))?
}

struct FciProcess<C> {
    /// The interface itself, without ports and sockets.
    cycle: Cycle,
    inputs: Inputs,
    keyframes: Keyframes,
    net: Net,
    arm: u8,
    /// Another arm of the cell works, so time passes without a client.
    has_other_arms: bool,
    state: Subscriber<WorldState>,
    command: Publisher<ArmCommand>,
    status: Publisher<ArmStatus>,
    sent: ArmCommand,
    report: ArmStatus,
    datagram: [u8; STATE_BYTES],
    physics_bell: Doorbell,
    task_bell: Doorbell,
    health: HealthReporter,
    clock: C,
    spin_ns: u64,
    awaits: Await,
    hand_messages: u32,
    /// In lockstep: ticks for which time passes without a client.
    free_ticks: u32,
    lockstep: bool,
    /// An answer that takes longer than a tick of wall time is lost in lockstep, too.
    strict: bool,
    class: LoopClass,
    expected_ns: u64,
    woke_ns: u64,
}

/// What the cycle waits for.
#[derive(Clone, Copy)]
enum Await {
    /// A state, until this time.
    State(Option<u64>),
    /// In lockstep the client: since, and the time to repeat the state.
    Client { since_ns: u64, repeat_ns: u64 },
}

impl<C: Clock> Turn for FciProcess<C> {
    /// The cycle: take the newest state and what the client sent, update, publish, and send the
    /// state to the client.
    fn turn(&mut self, woken: Woken) -> Wait {
        if let Await::State(until_ns) = self.awaits {
            if !self.take_state() {
                return self.poll_for_state(until_ns, woken.now_ns);
            }
            self.woke_ns = self.clock.now_ns();
            let newest = self.state.current().map(|state| &state.header);
            let newest = newest.map(|header| (header.generation, header.tick));
            if newest.is_none_or(|newest| self.cycle.answered() == Some(newest)) {
                return self.finish(false);
            }
            self.awaits = Await::Client {
                since_ns: self.woke_ns,
                repeat_ns: self.woke_ns + TICK_NS,
            };
        }
        self.listen();
        if let Await::Client {
            since_ns,
            repeat_ns,
        } = self.awaits
            && self.lockstep
            && let Some(wait) = self.wait_for_client((since_ns, repeat_ns), woken.now_ns)
        {
            return wait;
        }
        self.answer();
        self.finish(true)
    }
}

impl<C: Clock> FciProcess<C> {
    fn new(
        start: &Start,
        bus: &Bus,
        (cycle, net): (Cycle, Net),
        fifo: bool,
        clock: C,
    ) -> Result<Self, BusError> {
        let arm = start.arm;
        let process = Process::Controller(arm);
        let others = start.spec.fci.iter().filter(|fci| fci.is_none()).count();
        let mut process = Self {
            cycle,
            inputs: Inputs::new(arm, bus.publisher(TopicId::ClientTap(arm))?),
            keyframes: Keyframes::new(bus.publisher(TopicId::Keyframe(process))?),
            net,
            arm,
            has_other_arms: others > 0,
            state: bus.subscriber(TopicId::WorldState)?,
            command: bus.publisher(TopicId::ArmCommand(arm))?,
            status: bus.publisher(TopicId::ArmStatus(arm))?,
            sent: ArmCommand::zeroed(),
            report: ArmStatus::zeroed(),
            datagram: [0; STATE_BYTES],
            physics_bell: bus.doorbell(Process::Physics)?,
            task_bell: bus.doorbell(Process::Task)?,
            health: HealthReporter::new(start, bus, process, fifo, clock.now_ns())?,
            clock,
            spin_ns: if fifo { SPIN_FIFO_NS } else { SPIN_OTHER_NS },
            awaits: Await::State(None),
            hand_messages: 0,
            free_ticks: 0,
            lockstep: false,
            strict: interface(start).is_some_and(|fci| fci.strict),
            class: LoopClass::new(start, CONTROLLER_PRIORITY, fifo),
            expected_ns: 0,
            woke_ns: 0,
        };
        // The state before the first command, so that a replay can start there.
        process.publish_keyframe(&Header::zeroed());
        Ok(process)
    }

    fn take_state(&mut self) -> bool {
        let Some(state) = self.state.take() else {
            return false;
        };
        self.lockstep = state.has(FLAG_LOCKSTEP);
        self.class.follow(self.lockstep);
        self.health.set_lockstep(self.lockstep);
        true
    }

    /// How to wait for a state that has not arrived. Ends the turn without a cycle if it stays
    /// away.
    fn poll_for_state(&mut self, until_ns: Option<u64>, now_ns: u64) -> Wait {
        let until_ns = until_ns.unwrap_or(now_ns + PATIENCE_NS);
        if now_ns > until_ns {
            self.woke_ns = now_ns;
            self.listen();
            // Physics is paused or away: a client that only reads sees that the robot is there. One
            // that moves would send the commands of its motion in vain.
            if !self.cycle.robot().is_moving() {
                self.repeat_state();
            }
            return self.finish(false);
        }
        self.awaits = Await::State(Some(until_ns));
        if self.lockstep && now_ns + PATIENCE_NS > until_ns + SPIN_LOCKSTEP_NS {
            return Wait::Bell;
        }
        if self.lockstep {
            return Wait::Yield;
        }
        // Overdue: polling would take the core of physics.
        if now_ns > self.expected_ns + self.spin_ns {
            return Wait::Sleep(now_ns + self.spin_ns);
        }
        Wait::Spin
    }

    /// One cycle of the robot, for the state that was taken.
    fn answer(&mut self) {
        self.inputs.settle(&mut self.cycle, &self.state);
        let Some(state) = self.state.current() else {
            return;
        };
        if !self.cycle.update(state, &mut self.sent, &mut self.report) {
            return;
        }
        let tick = state.header.tick;
        // Counted from rest: a client may end before or after that.
        if self.cycle.robot().is_at_rest() {
            self.free_ticks = self.free_ticks.saturating_sub(1);
        }
        let is_sent = self.publish();
        self.send();
        self.reply();
        if let Some(reflex) = self.cycle.take_reflex() {
            self.health.incident(&messages::reflex(&reflex));
        }
        // A command that was not sent has no number for the checkpoint to follow.
        if is_sent && self.keyframes.is_due(tick, false) {
            let of_command = self.sent.header;
            self.publish_keyframe(&of_command);
        }
    }

    /// Publishes command and status; whether the command was sent.
    fn publish(&mut self) -> bool {
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

    /// Publishes a checkpoint for replay, as of the newest command, whose header is
    /// `of_command`.
    fn publish_keyframe(&mut self, of_command: &Header) {
        let cycle = &self.cycle;
        let after_seq = self.command.seq();
        let save = |bytes: &mut [u8]| cycle.save(bytes).ok();
        if !self.keyframes.send_whole(of_command, after_seq, save) {
            self.health.note(
                "the checkpoint of the interface could not be kept: no replay verifies this run",
            );
        }
    }

    /// Ends a turn, which had a cycle if `has_cycle`, and starts the wait for the next state.
    fn finish(&mut self, has_cycle: bool) -> Wait {
        let late_ns = if self.lockstep || self.expected_ns == 0 {
            0
        } else {
            self.woke_ns.saturating_sub(self.expected_ns)
        };
        self.expected_ns = self.woke_ns + TICK_NS;
        let tick = self.cycle.answered().map_or(0, |(_, tick)| tick);
        let now_ns = self.clock.now_ns();
        if has_cycle {
            self.health
                .cycle(tick, self.woke_ns, late_ns, [0.0; 4], now_ns);
        } else {
            self.health.idle();
            // A subscriber that joined late gets the newest message only by this call.
            self.command.update_connections();
            self.status.update_connections();
            self.inputs.update_connections();
        }
        let states = self.state.counts();
        self.health
            .totals(self.cycle.missed_cycles(), states.rejected, states.fenced);
        self.health
            .refused("state", self.state.take_invalid(), now_ns);
        self.health.publish_if_due(tick, now_ns);
        self.awaits = Await::State(None);
        if self.lockstep {
            return Wait::Spin;
        }
        Wait::Sleep(self.expected_ns.saturating_sub(self.spin_ns))
    }
}

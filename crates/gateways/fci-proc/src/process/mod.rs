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

use cell_bus::{Bus, BusError};
use cell_rt::priority::CONTROLLER_PRIORITY;
use cell_rt::{Clock, Monotonic};
use cell_run::spec::Fci;
use cell_worker::{ArmLoop, Ended, Start, Turn, Wait, Woken};
use fci::STATE_BYTES;
use ipc_types::TICK_NS;
use ipc_types::topic::{Process, TopicId};

use crate::cycle::Cycle;
use crate::error::ProcessError;
use crate::messages;
use crate::net::Net;

mod client;
mod inputs;

use inputs::Inputs;

/// Reported where the drives end a motion.
const HELD: &str = "the motion of the client ended: the drives hold the arm, as after late commands or a restart of physics";

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
    net: Net,
    arm: ArmLoop<C>,
    /// Number of the arm.
    number: u8,
    /// Another arm of the cell works, so time passes without a client.
    has_other_arms: bool,
    datagram: [u8; STATE_BYTES],
    awaits: Await,
    hand_messages: u32,
    /// In lockstep: ticks for which time passes without a client.
    free_ticks: u32,
    /// An answer that takes longer than a tick of wall time is lost in lockstep, too.
    strict: bool,
}

/// What the cycle waits for.
#[derive(Clone, Copy)]
enum Await {
    /// A state.
    State,
    /// In lockstep the client: since, and the time to repeat the state.
    Client { since_ns: u64, repeat_ns: u64 },
}

impl<C: Clock> Turn for FciProcess<C> {
    /// The cycle: take the newest state and what the client sent, update, publish, and send the
    /// state to the client.
    fn turn(&mut self, woken: Woken) -> Wait {
        if let Await::State = self.awaits {
            if !self.arm.take_state() {
                let wait = self.arm.poll(woken.now_ns);
                return wait.unwrap_or_else(|| self.without_state());
            }
            self.arm.begin();
            let newest = self.arm.newest();
            if newest.is_none_or(|newest| self.cycle.answered() == Some(newest)) {
                return self.finish(false);
            }
            let since_ns = self.arm.woke_ns();
            self.awaits = Await::Client {
                since_ns,
                repeat_ns: since_ns + TICK_NS,
            };
        }
        self.listen();
        if let Await::Client {
            since_ns,
            repeat_ns,
        } = self.awaits
            && self.arm.is_lockstep()
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
        let number = start.arm;
        let others = start.spec.fci.iter().filter(|fci| fci.is_none()).count();
        let mut arm = ArmLoop::new(start, bus, fifo, clock)?;
        arm.keep_first(|bytes| cycle.save(bytes).ok());
        Ok(Self {
            cycle,
            inputs: Inputs::new(number, bus.publisher(TopicId::ClientTap(number))?),
            net,
            arm,
            number,
            has_other_arms: others > 0,
            datagram: [0; STATE_BYTES],
            awaits: Await::State,
            hand_messages: 0,
            free_ticks: 0,
            strict: interface(start).is_some_and(|fci| fci.strict),
        })
    }

    /// Ends a turn without a state: physics is paused or away. A client that only reads sees that
    /// the robot is there; one that moves would send the commands of its motion in vain.
    fn without_state(&mut self) -> Wait {
        self.listen();
        if !self.cycle.robot().is_moving() {
            self.repeat_state();
        }
        self.finish(false)
    }

    /// One cycle of the robot, for the state that was taken.
    fn answer(&mut self) {
        self.inputs.settle(&mut self.cycle, self.arm.state());
        let (Some(state), command, report) = self.arm.cycle() else {
            return;
        };
        if !self.cycle.update(state, command, report) {
            return;
        }
        let tick = state.header.tick;
        // Counted from rest: a client may end before or after that.
        if self.cycle.robot().is_at_rest() {
            self.free_ticks = self.free_ticks.saturating_sub(1);
        }
        let is_sent = self.arm.publish();
        self.send();
        self.reply();
        if let Some(reflex) = self.cycle.take_reflex() {
            self.arm.health.incident(&messages::reflex(&reflex));
        }
        if self.cycle.take_held() {
            self.arm.health.incident(HELD);
        }
        // A command that was not sent has no number for the checkpoint to follow.
        if is_sent {
            let cycle = &self.cycle;
            self.arm.keep_if_due(tick, |bytes| cycle.save(bytes).ok());
        }
    }

    /// Ends a turn, which had a cycle if `has_cycle`, and starts the wait for the next state.
    fn finish(&mut self, has_cycle: bool) -> Wait {
        if !has_cycle {
            self.inputs.update_connections();
        }
        self.awaits = Await::State;
        self.arm.finish(&Ended {
            has_cycle,
            tick: self.cycle.answered().map_or(0, |(_, tick)| tick),
            values: [0.0; 4],
            missed: self.cycle.missed_cycles(),
            refused: (0, 0),
        })
    }
}

//! The client: its requests and commands, the states for it, and in lockstep the wait for it.

use cell_rt::Clock;
use cell_worker::Wait;
use fci::{GRIPPER_STATE_BYTES, Gripper};
use ipc_types::client::ClientEvent;
use ipc_types::{ArmState, TICK_NS};

use super::{Await, FciProcess};
use crate::messages;
use crate::net::Event;

/// How long lockstep waits for an answer of a client that moves the arm (ns).
const SILENCE_NS: u64 = 1_000_000_000;
/// How long lockstep polls for an answer before it sleeps in between (ns).
const SPIN_NS: u64 = 300_000;
/// Sleep between two looks for an answer (ns).
const NAP_NS: u64 = 50_000;
/// Ticks between two states of the hand.
const HAND_TICKS: u64 = 10;
/// In lockstep: between two states for a client that starts a motion (ns).
const START_NS: u64 = 50_000_000;
/// Ticks of simulated time after a client has ended: in them the task sees it.
const AFTER_CLIENT_TICKS: u32 = 30;

impl<C: Clock> FciProcess<C> {
    /// Takes what the clients have sent.
    pub(super) fn listen(&mut self) {
        if !self.is_started() {
            return;
        }
        while let Some(event) = self.net.event() {
            self.take(&event);
        }
        // In lockstep one for each cycle; the next one waits in the socket.
        while !(self.arm.is_lockstep() && self.cycle.robot().is_answered())
            && let Some(command) = self.net.command()
        {
            self.input(ClientEvent::Command, &command);
        }
    }

    fn take(&mut self, event: &Event) {
        match event {
            Event::Connected(..) => self.input(ClientEvent::Connected, &[]),
            Event::Request(_, request) => self.input(ClientEvent::Request, request.bytes()),
            Event::Closed(_) => self.client_ended(),
            Event::HandConnected(..) => {}
            Event::HandRequest(_, request) => self.input(ClientEvent::HandRequest, request.bytes()),
            Event::HandClosed(_) => self.input(ClientEvent::HandEnded, &[]),
        }
    }

    /// Gives the cycle an input, and the client the replies to it.
    fn input(&mut self, event: ClientEvent, bytes: &[u8]) {
        let of = (event, self.arm.is_lockstep() && !self.strict);
        self.inputs
            .take(&mut self.cycle, self.arm.state(), of, bytes);
        self.reply();
    }

    pub(super) fn reply(&mut self) {
        while let Some(reply) = self.cycle.take_reply() {
            self.net.reply(reply);
        }
        while let Some(reply) = self.cycle.take_hand_reply() {
            self.net.reply_hand(reply);
        }
    }

    /// In lockstep: how to wait for the client; `None` where the cycle can run.
    pub(super) fn wait_for_client(
        &mut self,
        (since_ns, repeat_ns): (u64, u64),
        now_ns: u64,
    ) -> Option<Wait> {
        let arm = self.cycle.robot();
        if arm.is_answered() {
            return None;
        }
        let is_running = arm.is_running();
        if !is_running {
            // Physics sends the state of its tick again when the scene is reset meanwhile.
            self.arm.take_state();
        }
        let is_busy = self.cycle.gripper().is_some_and(Gripper::is_busy);
        let state = self.arm.state();
        let is_new = state.is_some_and(|state| self.cycle.is_new_scene(state));
        let passes = self.has_other_arms || self.free_ticks > 0 || is_new || !self.is_started();
        if !is_running && (passes || !self.cycle.robot().is_at_rest() || is_busy) {
            return None;
        }
        // Before the first cycle physics knows no setpoint of this controller.
        let (_, tick) = self.cycle.answered()?;
        self.arm.health.idle();
        self.arm.health.publish_if_due(tick, now_ns);
        if is_running {
            self.wait_for_answer(since_ns, now_ns)
        } else {
            Some(self.wait_for_motion((since_ns, repeat_ns), now_ns))
        }
    }

    /// Whether the arm is known: before its first state a motion would begin elsewhere, and before
    /// the first tick its drives have no torques.
    fn is_started(&self) -> bool {
        let answered = self.cycle.answered();
        answered.is_some_and(|(_, tick)| tick > 0)
    }

    /// The wait for the answer of a client that moves the arm; `None` once it has been silent for
    /// too long, which ends its motion, or is a lost answer.
    fn wait_for_answer(&mut self, since_ns: u64, now_ns: u64) -> Option<Wait> {
        if self.strict && now_ns > since_ns + TICK_NS {
            return None;
        }
        if now_ns > since_ns + SILENCE_NS {
            self.net.drop_client();
            self.client_ended();
            self.arm
                .health
                .note("the client did not answer for 1 s: its motion has ended");
            return None;
        }
        Some(if now_ns < since_ns + SPIN_NS {
            Wait::Yield
        } else {
            Wait::Sleep(now_ns + NAP_NS)
        })
    }

    /// The wait for a client that moves the arm: simulated time does not pass, and the state is
    /// repeated.
    fn wait_for_motion(&mut self, (since_ns, mut repeat_ns): (u64, u64), now_ns: u64) -> Wait {
        let is_moving = self.cycle.robot().is_moving();
        if now_ns >= repeat_ns {
            self.repeat_state();
            // A client that starts a motion has seen it in one state; more of them would be time
            // of the robot that depends on the machine.
            repeat_ns = now_ns + if is_moving { START_NS } else { TICK_NS };
            self.awaits = Await::Client {
                since_ns,
                repeat_ns,
            };
        }
        // A client that has seen its motion in a state answers it.
        Wait::Sleep(if is_moving {
            repeat_ns.min(now_ns + NAP_NS)
        } else {
            repeat_ns
        })
    }

    /// The connection of the client has ended.
    fn client_ended(&mut self) {
        self.input(ClientEvent::Ended, &[]);
        self.free_ticks = AFTER_CLIENT_TICKS;
    }

    /// Sends the present state under the next number.
    pub(super) fn repeat_state(&mut self) {
        self.inputs.repeat(&mut self.cycle);
        self.send();
    }

    /// This arm in the newest state.
    fn present(&self) -> Option<ArmState> {
        let arms = self.arm.state()?.arms();
        arms.get(usize::from(self.number)).copied()
    }

    /// Sends the newest state.
    pub(super) fn send(&mut self) {
        let Some(arm) = self.present() else {
            return;
        };
        let measured = messages::measured(&arm, false);
        let robot = self.cycle.robot();
        robot.write_state(&measured, &mut self.datagram);
        self.net.send(&self.datagram);
        let Some(gripper) = self.cycle.gripper() else {
            return;
        };
        if robot.message_id().is_multiple_of(HAND_TICKS) {
            let mut state = [0; GRIPPER_STATE_BYTES];
            self.hand_messages = self.hand_messages.wrapping_add(1);
            gripper.write_state(self.hand_messages, &messages::fingers(&arm), &mut state);
            self.net.send_hand(&state);
        }
    }
}

//! The client: its requests and commands, the states for it, and in lockstep the wait for it.

use cell_rt::Clock;
use cell_worker::Wait;
use fci::{GRIPPER_STATE_BYTES, Gripper, Measured};
use ipc_types::{ArmState, TICK_NS};

use super::{Await, FciProcess, SPIN_LOCKSTEP_NS};
use crate::messages;
use crate::net::Event;

/// How long lockstep waits for an answer of a client that moves the arm (ns).
const SILENCE_NS: u64 = 1_000_000_000;
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
            self.take(event);
        }
        // In lockstep one for each cycle; the next one waits in the socket.
        let (arm, waits) = (&mut self.robot.arm, self.lockstep && !self.strict);
        while !(self.lockstep && arm.is_answered())
            && let Some(command) = self.net.command()
        {
            arm.datagram(&command, waits);
        }
        self.reply();
    }

    fn take(&mut self, event: Event) {
        match event {
            Event::Connected(..) => self.client.connected = 1,
            Event::Request(_, framed) => self.robot.arm.request(&framed),
            Event::Closed(_) => self.client_ended(),
            Event::HandConnected(..) => {}
            Event::HandRequest(_, framed) => {
                let fingers = self.present().map(|(_, arm)| messages::fingers(&arm));
                if let Some(gripper) = &mut self.robot.gripper {
                    gripper.request(&framed, &fingers.unwrap_or_default());
                }
            }
            Event::HandClosed(_) => {
                if let Some(gripper) = &mut self.robot.gripper {
                    gripper.disconnect();
                }
            }
        }
    }

    pub(super) fn reply(&mut self) {
        while let Some(reply) = self.robot.arm.take_reply() {
            self.client.motions += u32::from(reply.is_success_of_motion());
            self.net.reply(reply);
        }
        let Some(gripper) = &mut self.robot.gripper else {
            return;
        };
        while let Some(reply) = gripper.take_reply() {
            self.net.reply_hand(reply);
        }
    }

    /// In lockstep: how to wait for the client; `None` where the cycle can run.
    pub(super) fn wait_for_client(
        &mut self,
        (since_ns, repeat_ns): (u64, u64),
        now_ns: u64,
    ) -> Option<Wait> {
        let arm = &self.robot.arm;
        if arm.is_answered() {
            return None;
        }
        let is_running = arm.is_running();
        if !is_running {
            // Physics sends the state of its tick again when the scene is reset meanwhile.
            self.take_state();
        }
        let arm = &self.robot.arm;
        let is_busy = self.robot.gripper.as_ref().is_some_and(Gripper::is_busy);
        let is_new = !self.is_started() || self.is_new_scene();
        let passes = self.has_other_arms || self.free_ticks > 0 || is_new;
        if !is_running && (passes || !arm.is_at_rest() || is_busy) {
            return None;
        }
        // Before the first cycle physics knows no setpoint of this controller.
        let (_, tick) = self.answered?;
        self.health.idle();
        self.health.publish_if_due(tick, now_ns);
        if is_running {
            self.wait_for_answer(since_ns, now_ns)
        } else {
            Some(self.wait_for_motion((since_ns, repeat_ns), now_ns))
        }
    }

    /// Whether the arm is known: before its first state a motion would begin elsewhere, and before
    /// the first tick its drives have no torques.
    fn is_started(&self) -> bool {
        self.answered.is_some_and(|(_, tick)| tick > 0)
    }

    /// Whether no cycle has run since physics was replaced or the scene was reset. The next motion
    /// would otherwise find that out in its first cycle, and end.
    fn is_new_scene(&self) -> bool {
        self.scene()
            .is_some_and(|scene| self.began_with != Some(scene))
    }

    /// Generation of physics and count of scene resets.
    pub(super) fn scene(&self) -> Option<(u32, u32)> {
        let state = self.state.current()?;
        Some((state.header.generation, state.panel.scene_reset))
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
            self.health
                .note("the client did not answer for 1 s: its motion has ended");
            return None;
        }
        Some(if now_ns < since_ns + SPIN_LOCKSTEP_NS {
            Wait::Yield
        } else {
            Wait::Sleep(now_ns + NAP_NS)
        })
    }

    /// The wait for a client that moves the arm: simulated time does not pass, and the state is
    /// repeated.
    fn wait_for_motion(&mut self, (since_ns, mut repeat_ns): (u64, u64), now_ns: u64) -> Wait {
        let is_moving = self.robot.arm.is_moving();
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
        self.robot.arm.disconnect();
        self.client.connected = 0;
        self.client.ended += 1;
        self.free_ticks = AFTER_CLIENT_TICKS;
    }

    /// Sends the present state under the next number.
    pub(super) fn repeat_state(&mut self) {
        let Some((_, arm)) = self.present() else {
            return;
        };
        let measured = messages::measured(&arm, false);
        self.robot.arm.repeat();
        self.send(&measured, &arm);
    }

    /// The newest state, and this arm in it.
    fn present(&self) -> Option<(u64, ArmState)> {
        let state = self.state.current()?;
        let arm = state.arms().get(usize::from(self.arm))?;
        Some((state.header.tick, *arm))
    }

    pub(super) fn send(&mut self, measured: &Measured, arm: &ArmState) {
        self.robot.arm.write_state(measured, &mut self.datagram);
        self.net.send(&self.datagram);
        let Some(gripper) = &self.robot.gripper else {
            return;
        };
        if self.robot.arm.message_id().is_multiple_of(HAND_TICKS) {
            let mut state = [0; GRIPPER_STATE_BYTES];
            self.hand_messages = self.hand_messages.wrapping_add(1);
            gripper.write_state(self.hand_messages, &messages::fingers(arm), &mut state);
            self.net.send_hand(&state);
        }
    }
}

//! Latency from a message to the next one, taken from the inputs that messages name.

use std::collections::VecDeque;

use ipc_types::topic::TopicId;
use ipc_types::{ArmCommand, ArmStatus, Decision, Header, MAX_ARMS, WorldPiece};

use super::latency::{HopLatency, Window};

/// Number of messages whose time is remembered: more than one reading of the taps.
const REMEMBERED: usize = 4096;

/// Publication times by number of the message.
struct Sent(Vec<(u32, u64, u64)>);

impl Sent {
    fn new() -> Self {
        Self(vec![(0, 0, 0); REMEMBERED])
    }

    fn put(&mut self, generation: u32, number: u64, publish_ns: u64) {
        if let Some(entry) = self.0.get_mut(index(number)) {
            *entry = (generation, number, publish_ns);
        }
    }

    // The ring is indexed by number; an older message or another start has another one.
    fn find(&self, generation: u32, number: u64) -> Option<u64> {
        let entry = self.0.get(index(number))?;
        (entry.0 == generation && entry.1 == number).then_some(entry.2)
    }
}

struct Arm {
    commands: Sent,
    /// Generation and number of the command that the drives followed last.
    followed: (u32, u64),
    /// First states that followed a command: generation, number, time.
    uses: VecDeque<(u32, u64, u64)>,
    latched: (u32, u64),
    to_command: Window,
    to_drives: Window,
    to_controller: Window,
}

/// Measures the hops.
pub(super) struct Hops {
    states: Sent,
    /// By tick.
    decisions: Sent,
    arms: Vec<Arm>,
    to_decision: Window,
}

impl Hops {
    pub(super) fn new(arms: usize) -> Self {
        let arm = |arm| Arm {
            commands: Sent::new(),
            followed: (0, 0),
            uses: VecDeque::new(),
            latched: (0, 0),
            to_command: Window::new("state to command", Some(arm)),
            to_drives: Window::new("command to drives", Some(arm)),
            to_controller: Window::new("decision to controller", Some(arm)),
        };
        Self {
            states: Sent::new(),
            decisions: Sent::new(),
            arms: (0..arms.min(MAX_ARMS)).map(arm).collect(),
            to_decision: Window::new("state to decision", None),
        }
    }

    pub(super) fn state(&mut self, piece: &WorldPiece) {
        let header = &piece.state;
        self.states
            .put(header.generation, header.seq, header.publish_ns);
        for (arm, measured) in self.arms.iter_mut().zip(&piece.arms) {
            let command = (measured.command_generation, measured.command_seq);
            // Once per command: it is repeated in every state until the next one arrives.
            if command != arm.followed && command.1 > 0 {
                arm.followed = command;
                if arm.uses.len() < REMEMBERED {
                    let (generation, seq) = command;
                    arm.uses.push_back((generation, seq, header.publish_ns));
                }
            }
        }
    }

    pub(super) fn command(&mut self, arm: usize, command: &ArmCommand) {
        let header = &command.header;
        let cause_ns = state_of(&self.states, header);
        if let Some(arm) = self.arms.get_mut(arm) {
            arm.commands
                .put(header.generation, header.seq, header.publish_ns);
            // Unknown if the state was overwritten in the tap: no value instead of a wrong one.
            if let Some(cause_ns) = cause_ns {
                arm.to_command.record(cause_ns, header.publish_ns);
            }
        }
    }

    pub(super) fn decision(&mut self, decision: &Decision) {
        let header = &decision.header;
        // Decisions are made every tenth tick.
        let number = header.tick / ipc_types::DECISION_TICKS;
        self.decisions
            .put(header.generation, number, header.publish_ns);
        if let Some(cause_ns) = state_of(&self.states, header) {
            self.to_decision.record(cause_ns, header.publish_ns);
        }
    }

    pub(super) fn status(&mut self, arm: usize, status: &ArmStatus) {
        let Some(arm) = self.arms.get_mut(arm) else {
            return;
        };
        let decision = (status.goal_generation, status.decision_tick);
        // Once per decision: a status repeats it until the next one.
        if decision == arm.latched || decision.1 == 0 {
            return;
        }
        arm.latched = decision;
        let number = decision.1 / ipc_types::DECISION_TICKS;
        if let Some(sent_ns) = self.decisions.find(decision.0, number) {
            arm.to_controller.record(sent_ns, status.header.publish_ns);
        }
    }

    /// Commands are read after the states that followed them.
    pub(super) fn settle(&mut self) {
        for arm in &mut self.arms {
            for (generation, seq, used_ns) in arm.uses.drain(..) {
                if let Some(sent_ns) = arm.commands.find(generation, seq) {
                    arm.to_drives.record(sent_ns, used_ns);
                }
            }
        }
    }

    pub(super) fn report(&mut self, now_ns: u64) -> Vec<HopLatency> {
        let mut all = Vec::new();
        for arm in &mut self.arms {
            all.push(arm.to_command.report(now_ns));
            all.push(arm.to_drives.report(now_ns));
            all.push(arm.to_controller.report(now_ns));
        }
        all.push(self.to_decision.report(now_ns));
        all
    }
}

fn state_of(states: &Sent, header: &Header) -> Option<u64> {
    let world = TopicId::WorldState.code();
    let input = header.inputs().iter().find(|input| input.topic == world)?;
    states.find(input.generation, input.seq)
}

/// Place of a number in a ring.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a remainder is as small as its divisor"
)]
fn index(number: u64) -> usize {
    (number % REMEMBERED as u64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::{Input, Wire};

    #[test]
    fn a_command_is_timed_from_its_state_and_to_the_state_that_followed_it() {
        let mut hops = Hops::new(1);
        let mut piece = WorldPiece::zeroed();
        (piece.state.generation, piece.state.seq) = (1, 5);
        piece.state.publish_ns = 1_000_000;
        hops.report(0);
        hops.state(&piece);
        (piece.state.seq, piece.state.publish_ns) = (6, 2_000_000);
        (piece.arms[0].command_generation, piece.arms[0].command_seq) = (2, 9);
        hops.state(&piece);
        let mut command = ArmCommand::zeroed();
        command.header.push_input(Input {
            topic: TopicId::WorldState.code(),
            generation: 1,
            seq: 5,
            age_ticks: 0,
        });
        (command.header.generation, command.header.seq) = (2, 9);
        command.header.publish_ns = 1_300_000;
        hops.command(0, &command);
        hops.settle();
        let latency = hops.report(1);
        let max = |hop: &str| latency.iter().find(|h| h.hop == hop).unwrap().max_us;
        assert!((max("state to command") - 300.0).abs() < 3.0);
        assert!((max("command to drives") - 700.0).abs() < 7.0);
    }
}

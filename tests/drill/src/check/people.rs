//! What people asked for is in force.

use ipc_types::WorldState;
use ipc_types::operator::ReplyCode;
use ipc_types::topic::Process;
use ipc_types::world::FLAG_PAUSED;

use super::{Check, Moment, Seen, Verdict, fail_if};
use crate::model::News;
use crate::plan::Plan;

pub(super) fn all(plan: &Plan) -> Vec<Box<dyn Check>> {
    let mut all: Vec<Box<dyn Check>> = vec![Box::new(Counts::default())];
    // A script that pauses decides about pauses, too.
    if !plan.script.iter().any(|line| line.contains("pause")) {
        all.push(Box::new(Pauses::default()));
    }
    all
}

/// Requests that the panel counts.
const COUNTED: [&str; 6] = [
    "reset",
    "task_reset",
    "target",
    "gripper",
    "drop_parts",
    "add_bin",
];

/// No accepted request is forgotten by a restart of physics, and none is obeyed twice.
#[derive(Default)]
struct Counts {
    /// How often each was sent, and how often the newest state has it.
    sent: [u32; COUNTED.len()],
    seen: [u32; COUNTED.len()],
    /// Physics said that it lost requests.
    said: bool,
}

impl Counts {
    fn state(&mut self, state: &WorldState) -> Verdict {
        let panel = &state.panel;
        let now = [
            panel.scene_reset,
            panel.task_reset,
            panel.target_seq,
            panel.gripper_seq,
            panel.drop_parts,
            panel.add_bin,
        ];
        let before = std::mem::replace(&mut self.seen, now);
        // Without a saved state physics starts with a fresh scene, and reports it.
        let is_fresh = state.header.generation > 1 && state.resumed_tick == 0;
        for (name, ((now, before), sent)) in
            COUNTED.iter().zip(now.iter().zip(before).zip(self.sent))
        {
            // A contact ends a target by another one: where the arm is.
            let own = if *name == "target" {
                panel.contact_stops
            } else {
                0
            };
            let is_forgotten = *now < before && !is_fresh && !self.said;
            fail_if(is_forgotten || *now > sent + own, || {
                format!(
                    "{name} counts {now} after {before}, was sent {sent} times, and physics \
                     itself counted {own}"
                )
            })?;
        }
        Ok(())
    }
}

impl Check for Counts {
    fn number(&self) -> u32 {
        22
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        match moment.seen {
            Seen::Asked(asked) => {
                let mut all = COUNTED.iter().zip(&mut self.sent);
                if let Some((_, sent)) = all.find(|(name, _)| **name == asked.action) {
                    *sent += 1;
                }
            }
            Seen::News(News::Logged(Process::Physics, line)) => self.said |= line.contains("lost"),
            Seen::State(state) => return self.state(state),
            _ => {}
        }
        Ok(())
    }
}

/// A pause or its end that was accepted is in force in every later state, also after a restart
/// of physics.
#[derive(Default)]
struct Pauses {
    /// Whether the cell has to be paused; `None` where another request decides.
    paused: Option<bool>,
}

impl Check for Pauses {
    fn number(&self) -> u32 {
        22
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        match moment.seen {
            // In force at a tick that the person does not know yet.
            Seen::Asked(_) => {
                self.paused = None;
                Ok(())
            }
            Seen::Answered(asked, reply) if reply.code == ReplyCode::Accepted.code() => {
                self.paused = match asked.action.as_str() {
                    "pause" => Some(true),
                    "resume" => Some(false),
                    _ => None,
                };
                Ok(())
            }
            // What it lost is asked for again.
            Seen::News(News::Logged(Process::Physics, line)) if line.contains("lost") => {
                self.paused = None;
                Ok(())
            }
            Seen::State(state) => {
                let is_paused = state.has(FLAG_PAUSED);
                fail_if(
                    self.paused.is_some_and(|paused| paused != is_paused),
                    || {
                        let tick = state.header.tick;
                        format!(
                            "paused is {is_paused} in tick {tick}, against the accepted request"
                        )
                    },
                )
            }
            _ => Ok(()),
        }
    }
}

//! What people asked for is in force.

use ipc_types::operator::ReplyCode;
use ipc_types::world::FLAG_PAUSED;

use super::{Check, Moment, Seen, Verdict, fail_if};

pub(super) fn all() -> Vec<Box<dyn Check>> {
    vec![Box::new(Pauses::default())]
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

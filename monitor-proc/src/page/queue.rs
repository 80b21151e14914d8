//! Queues of commands: the bus and the launcher, or a replayed file.

use tokio::sync::oneshot;

use super::command::Order;

/// Result of a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reply {
    /// Whether it is done or under way.
    pub ok: bool,
    /// Tick at which it took effect.
    pub tick: Option<u64>,
    /// Text for the person; empty if none is needed.
    pub message: String,
}

impl Reply {
    /// Done, with nothing to say.
    pub fn done() -> Self {
        Self {
            ok: true,
            tick: None,
            message: String::new(),
        }
    }

    /// Not done, with the reason.
    pub fn refused(message: impl Into<String>) -> Self {
        Self {
            ok: false,
            tick: None,
            message: message.into(),
        }
    }
}

/// Channel for the answer. An answer that is dropped means that no process could reply.
pub type Answer = oneshot::Sender<Reply>;

/// Accepts commands; never waits.
pub trait CommandQueue: Send + Sync {
    /// Has `order` executed and `answer` sent; `description` is the text for the log.
    fn push(&self, order: Order, description: &str, answer: Answer);
}

/// Sends an answer whose receiver may be gone.
pub fn send(answer: Answer, reply: Reply) {
    // A page that has closed meanwhile is not an error of the command.
    let _heard = answer.send(reply).is_ok();
}

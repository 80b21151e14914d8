//! Who carries commands out: the bus and the launcher, or a replayed file.

use tokio::sync::oneshot;

use super::command::Order;

/// What became of a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reply {
    /// Whether it is done or under way.
    pub ok: bool,
    /// Tick at which it took effect.
    pub tick: Option<u64>,
    /// What to tell the person; empty where nothing has to be said.
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

    /// Not done, and why.
    pub fn refused(message: impl Into<String>) -> Self {
        Self {
            ok: false,
            tick: None,
            message: message.into(),
        }
    }
}

/// Where the answer goes. One that is dropped means that no process could answer.
pub type Answer = oneshot::Sender<Reply>;

/// Takes commands in; never waits.
pub trait Desk: Send + Sync {
    /// Has `order` carried out and `answer` sent; `said` is for the journal.
    fn take(&self, order: Order, said: &str, answer: Answer);
}

/// Sends an answer whose receiver may be gone.
pub fn send(answer: Answer, reply: Reply) {
    let _heard = answer.send(reply).is_ok();
}

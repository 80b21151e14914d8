//! People who operate the cell.

use cell_bus::{Answered, BusError, OperatorClient, PendingReply};
use ipc_types::OperatorReply;

use crate::model::Shared;
use crate::plan::{Asked, MS, Plan};

/// How long a person waits for an answer before asking again (ns).
const PATIENCE_NS: u64 = 500 * MS;

/// The requests of a plan, one after the other.
pub(crate) struct People {
    /// The next one last.
    due: Vec<Asked>,
    client: OperatorClient,
    asked: Option<(Asked, PendingReply, u64)>,
}

impl People {
    /// Of `plan`, on the bus of `model`.
    pub(crate) fn new(plan: &Plan, model: &Shared) -> Result<Self, BusError> {
        let mut due = plan.people.clone();
        due.sort_by_key(|asked| asked.at_us);
        due.reverse();
        Ok(Self {
            due,
            client: model.borrow().bus(1).operator_client()?,
            asked: None,
        })
    }

    /// Asks what is due; returns a request that was sent, or its answer.
    pub(crate) fn turn(&mut self, now_ns: u64) -> Option<(Asked, Option<Box<OperatorReply>>)> {
        if let Some((asked, pending, since_ns)) = self.asked.take() {
            match pending.take() {
                Answered::Reply(reply) => return Some((asked, Some(reply))),
                Answered::Waiting if now_ns < since_ns + PATIENCE_NS => {
                    self.asked = Some((asked, pending, since_ns));
                    return None;
                }
                Answered::Waiting | Answered::Dropped => self.due.push(asked),
            }
        }
        let asked = self.due.pop_if(|asked| asked.at_us * 1000 <= now_ns)?;
        match asked.request().map(|request| self.client.send(request)) {
            Some(Ok(Some(pending))) => {
                self.asked = Some((asked.clone(), pending, now_ns));
                return Some((asked, None));
            }
            // Physics is not there.
            Some(Ok(None)) => self.due.push(asked),
            // A request that is refused by its name or its numbers is dropped.
            Some(Err(_)) | None => {}
        }
        None
    }
}

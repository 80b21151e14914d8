//! Waits for what a request leads to, so that the answer states a result.

use std::time::{Duration, Instant};

use cell_bus::{Bus, Latest};
use ipc_types::WorldState;
use ipc_types::topic::TopicId;
use supervisor::failure::{Context, Failure};

use super::session::Session;

/// Physics answers within a tick; a busy machine needs longer.
pub(super) const PATIENCE: Duration = Duration::from_secs(2);

/// A state is published at least this often, or physics does not run.
const SILENCE: Duration = Duration::from_secs(10);
/// Time between two looks.
const LOOK: Duration = Duration::from_millis(1);

/// The state of the world, as it changes.
pub(super) struct Follower<'a> {
    session: &'a Session,
    latest: Latest<WorldState>,
}

impl<'a> Follower<'a> {
    /// Of the cell of `session`, which `bus` has joined.
    pub(super) fn new(session: &'a Session, bus: &Bus) -> Result<Self, Failure> {
        let latest = bus.latest(TopicId::WorldState).cannot("read the world")?;
        Ok(Self { session, latest })
    }

    /// The newest state.
    pub(super) fn now(&mut self) -> Result<WorldState, Failure> {
        let until = Instant::now() + PATIENCE;
        while !self.latest.refresh() && Instant::now() < until {
            std::thread::sleep(LOOK);
        }
        let silent = "physics publishes no state; `robocell status` says more";
        let state = self.latest.get().copied();
        state.ok_or_else(|| Failure::configuration(silent))
    }

    /// Passes each new state to `look` until it returns a value.
    pub(super) fn until<T>(
        &mut self,
        mut look: impl FnMut(&WorldState) -> Option<T>,
    ) -> Result<T, Failure> {
        let mut heard = Instant::now();
        loop {
            if self.latest.refresh() {
                heard = Instant::now();
                if let Some(seen) = self.latest.get().and_then(&mut look) {
                    return Ok(seen);
                }
            }
            // A cell that ended is reported at once, and not after `SILENCE`.
            check_lives(self.session)?;
            if heard.elapsed() > SILENCE {
                let message =
                    "physics has published no state for 10 s; `robocell status` says more";
                return Err(Failure::configuration(message));
            }
            std::thread::sleep(LOOK);
        }
    }
}

/// Refuses to wait for a cell that has ended, or was replaced.
pub(super) fn check_lives(session: &Session) -> Result<(), Failure> {
    let holder = session.dir.holder();
    if holder.is_some_and(|holder| holder.pid == session.holder.pid) {
        return Ok(());
    }
    Err(Failure::not_running(&session.spec.cell))
}

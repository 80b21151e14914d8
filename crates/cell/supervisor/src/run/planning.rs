//! The plan of the next scene, made on a thread.
//!
//! A task program is asked and a page may be built for it, which takes seconds to minutes. The
//! loop of supervision must not wait for it: a process that dies meanwhile has to be back within
//! milliseconds, and an arm that is stopped has to be stopped now.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::Duration;

use cell_rt::priority::set_other;
use cell_rt::signal::request_stop;

use super::plan::{Plan, Scene};
use crate::failure::{Context, Failure};

/// A program that is asked ends within milliseconds after a request to stop; the end of the
/// run waits no longer for one that the kernel keeps.
const STOP_LIMIT: Duration = Duration::from_secs(2);

/// At most one plan that is being made.
#[derive(Default)]
pub(super) struct Planning {
    result: Option<Receiver<Result<Plan, Failure>>>,
    is_for_client: bool,
    is_closed: bool,
}

impl Planning {
    /// Starts to plan `scene`, which follows on `plan`.
    pub(super) fn start(&mut self, plan: &Plan, scene: Scene) -> Result<(), Failure> {
        if self.is_closed || self.result.is_some() {
            let why = if self.is_closed {
                "this run of the cell is ending; try again when it has ended"
            } else {
                "another scene is being set up already; wait until that is done"
            };
            return Err(Failure::configuration(why));
        }
        self.is_for_client = matches!(scene, Scene::Other { .. });
        let replaced = Arc::clone(&plan.replaced);
        let (sender, result) = channel();
        let work = move || {
            // The launcher's priority is not for the programs that are asked.
            set_other().ok();
            sender.send(replaced(scene)).ok();
        };
        let thread = std::thread::Builder::new().name("plan".to_owned());
        thread.spawn(work).cannot("start a thread")?;
        self.result = Some(result);
        Ok(())
    }

    /// Refuses further scenes: the run has found its end, perhaps in another scene, whose
    /// programs [`Planning::end`] must not stop.
    pub(super) fn close(&mut self) {
        self.is_closed = true;
    }

    /// The plan, once it is made, or why there is none.
    pub(super) fn poll(&mut self) -> Option<Result<Plan, Failure>> {
        let planned = match self.result.as_ref()?.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err(Failure::configuration("planning has failed")),
            Ok(planned) => planned,
        };
        self.result = None;
        Some(planned)
    }

    /// Whether the last plan was made for a client, which gets the reason of a failure.
    pub(super) fn is_for_client(&self) -> bool {
        self.is_for_client
    }

    /// The run ends: programs that are asked for an unfinished plan are stopped, as they
    /// would outlive the launcher.
    pub(super) fn end(self) {
        if let Some(result) = self.result {
            request_stop();
            result.recv_timeout(STOP_LIMIT).ok();
        }
    }
}

//! The threads of the page of a live cell.

use std::sync::{Arc, mpsc};
use std::thread::{self, Scope};

use cell_run::spec::PageSpec;
use cell_worker::Start;

use crate::feed::broadcast::Broadcast;
use crate::operator::queue::{LiveCommandQueue, serve_control, serve_physics};
use crate::operator::recordings;
use crate::recorder::Recorder;
use crate::web::page_server::{self, PageError, PageProblem};

/// The page's channels on the thread of the bus.
pub(crate) struct LivePage {
    broadcast: Arc<Broadcast>,
    /// Requests of people, for the log.
    pub(crate) requests: mpsc::Receiver<String>,
}

impl LivePage {
    /// Starts the threads of the page: they end when it is closed.
    pub(crate) fn open<'scope>(
        scope: &'scope Scope<'scope, '_>,
        start: &'scope Start,
        page: &'scope PageSpec,
        broadcast: &Arc<Broadcast>,
        (recorder, problem): (&Arc<Recorder>, &PageProblem),
    ) -> Result<Self, PageError> {
        let (queue, receivers) = LiveCommandQueue::new();
        let server = page_server::prepare(start, page, broadcast.clone(), queue, recorder)?;
        let (physics, control) = (receivers.physics, receivers.control);
        let (recorder, problem) = (recorder.clone(), problem.clone());
        let opened = Self {
            broadcast: broadcast.clone(),
            requests: receivers.log,
        };
        let named = |name: &str| thread::Builder::new().name(name.to_owned());
        // One thread per recipient: a restart takes seconds, and a drag must not wait for it.
        named("operator").spawn_scoped(scope, move || serve_physics(start, &physics))?;
        let socket = start.spec.run_dir.join("control.sock");
        named("errands").spawn_scoped(scope, move || {
            let record = |order| recordings::record(&recorder, &start.spec, order);
            serve_control(&socket, &control, record);
        })?;
        named("page").spawn_scoped(scope, move || {
            page_server::serve(server, page.address, &problem);
        })?;
        Ok(opened)
    }
}

impl Drop for LivePage {
    fn drop(&mut self) {
        // For any reason: the threads must end. A reason set before stays.
        self.broadcast.close("restart");
    }
}

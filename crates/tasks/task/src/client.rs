//! The task of a cell whose arms are all commanded by client programs: it waits until the first
//! client has ended, and reports how.

use ipc_types::arm::ClientState;
use ipc_types::decision::Outcome;
use serde::{Deserialize, Serialize};

use crate::job::Job;
use crate::observation::Observation;
use crate::output::Output;
use crate::policy::Policy;

const PHASES: [&str; 3] = ["WAIT_FOR_CLIENT", "CONNECTED", "MOVING"];

/// The policy.
pub(crate) struct Client;

/// Its state from decision to decision.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct Memory {
    /// Index of the present phase.
    phase: usize,
}

impl Policy for Client {
    type Memory = Memory;

    fn decide(
        &self,
        memory: &mut Memory,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let arms = 0..observation.state().arms().len();
        let echoes = arms.filter_map(|arm| observation.echo(arm));
        let mut phase = 0;
        let mut ended: Option<ClientState> = None;
        for echo in echoes {
            let client = echo.client;
            let own = match (client.connected, echo.goal_active) {
                (0, _) => 0,
                (_, false) => 1,
                (_, true) => 2,
            };
            phase = phase.max(own);
            ended = ended.or((client.ended > 0).then_some(client));
        }
        memory.phase = phase;
        let Some(client) = ended else {
            return;
        };
        if client.failures > 0 {
            job.fail(client.failure.as_str());
        } else {
            job.done = true;
            out.outcome = Outcome::Done;
        }
    }

    fn phase(&self, memory: &Memory) -> &str {
        PHASES.get(memory.phase).copied().unwrap_or_default()
    }

    fn phases(&self) -> &[&str] {
        &PHASES
    }
}

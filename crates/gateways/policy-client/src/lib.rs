//! Policies behind a socket: a server gets observations and answers chunks of actions, in the
//! conventions of openpi and of vla-eval.
//!
//! Latency is simulated time, and a run depends on the answers alone, wherever and however fast
//! they were computed (ADR 38).
//!
//! What can go wrong: a server that is killed, slow, or answers anything at all. The rule: it ends
//! the episode with a reason of [`failure::reason`], never the process, and nothing of it is used
//! before its shape and its numbers were checked.
#![forbid(unsafe_code)]

mod action;
pub mod codec;
pub mod failure;
mod kept;
mod link;
mod observe;
mod policy;
pub mod schedule;

use std::sync::Arc;

use cell_sim::gateway::Gateway;
use robocell_task::Policies;

/// Policy servers, for the `main` of a task program: a policy may be named by the address of its
/// server.
#[derive(Clone, Copy, Debug)]
pub struct PolicyServers;

impl Gateway for PolicyServers {
    fn policies(&self, policies: Policies) -> Policies {
        let seen = Arc::default();
        policies.with_remote(move |job| Ok(Box::new(policy::RemotePolicy::new(job, &seen)?)))
    }
}

pub use link::MAX_MESSAGE_BYTES;

//! The gateways of this project: one line for each, for the `main` of a task program.
#![forbid(unsafe_code)]

use std::sync::Arc;

use cell_sim::gateway::Gateways;

/// Policy servers and the Franka control interface.
pub fn all() -> Gateways {
    vec![
        Arc::new(policy_client::PolicyServers),
        Arc::new(fci_proc::FrankaInterface),
    ]
}

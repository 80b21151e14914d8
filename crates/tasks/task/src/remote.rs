//! Policies behind a socket, as far as a registry knows them: it has the job, and the program that
//! brings the socket makes the policy.

use std::sync::Arc;

use cell_model::Cell;

use crate::goals::Goals;
use crate::policy::AnyPolicy;
use crate::settings::SetupError;

/// The job of a policy behind a socket.
pub struct Remote<'a> {
    /// The cell.
    pub cell: &'a Cell,
    /// Address of the server.
    pub address: &'a str,
    /// The slots of the job.
    pub goals: Goals,
    /// Force of a closing gripper (N).
    pub grip_force: f64,
}

/// Makes the policy of a job.
pub(crate) type MakeRemote =
    Arc<dyn Fn(Remote<'_>) -> Result<Box<dyn AnyPolicy>, SetupError> + Send + Sync>;

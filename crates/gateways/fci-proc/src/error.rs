//! Why the interface cannot run.

use cell_bus::BusError;
use cell_worker::RunError;

use crate::cycle::RobotError;

/// Why the interface cannot run.
#[derive(Debug, thiserror::Error)]
pub enum ProcessError {
    /// The robot has no such interface.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// A socket.
    #[error("the Franka control interface cannot listen: {0}")]
    Socket(#[from] std::io::Error),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
}

impl RunError for ProcessError {
    fn is_lasting(&self) -> bool {
        match self {
            Self::Robot(_) => true,
            Self::Socket(_) => false,
            Self::Bus(error) => error.is_lasting(),
        }
    }
}

//! Why a cell cannot be simulated.

use cell_model::ModelError;
use thiserror::Error;

/// Why a cell cannot be simulated.
#[derive(Debug, Error)]
pub enum WorldError {
    /// Two things start inside each other.
    #[error("object '{object}' starts {:.1} mm inside '{other}'; move it or make its spawn area smaller", depth * 1.0e3)]
    Overlap {
        /// The object.
        object: String,
        /// The other shape.
        other: String,
        /// How deep (m).
        depth: f64,
    },
    /// An arm starts inside something that motion keeps away from.
    #[error(
        "arm '{arm}' starts {:.0} mm inside fixture '{fixture}' with its link '{link}'; move one of \
         them, or let the fixture have `solid = false`",
        depth * 1.0e3
    )]
    ArmOverlap {
        /// The arm.
        arm: String,
        /// Its link.
        link: String,
        /// The fixture.
        fixture: String,
        /// How deep (m).
        depth: f64,
    },
    /// The cell does not fit the messages.
    #[error("the cell has {count} {what}; at most {limit} are possible")]
    TooMany {
        /// The excessive elements.
        what: &'static str,
        /// Their number.
        count: usize,
        /// The largest possible number.
        limit: usize,
    },
    /// The model is wrong.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A snapshot is not of this cell and this program.
    #[error("the snapshot cannot be restored: {reason}; start from the beginning instead")]
    Snapshot {
        /// The mismatch.
        reason: String,
    },
}

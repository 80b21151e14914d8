//! Communication between arms that share a blackboard: which arm works in a zone ([`Lease`]),
//! which arm an object belongs to ([`Reservations`]), and that an object is not where it should
//! be ([`Recovery`]).
//!
//! Each item is a key of the shared blackboard: it is in the checkpoint, in the trace and on
//! the page, and a tree can read it with `CheckBlackboard`.
#![allow(clippy::result_large_err, reason = "happens at load, once")]

pub(crate) mod lease;
mod recovery;
mod reserve;

pub use lease::{Lease, Turn};
pub use recovery::{Alarm, Recovery, has_lasted};
pub use reserve::{Owner, Reservations};

pub(crate) use recovery::reconcile;

use behavior::Str;
use behavior::board::Out;
use behavior::tree::{BindError, Binder};
use behavior::value::Plain;

/// The constant with the name of the tree's arm.
pub(crate) const ROBOT: &str = "robot";

/// Name of the tree's arm: the constant `robot`. In a tree without that constant, as in a
/// machine of one arm, the name is `robot`, too.
///
/// # Errors
/// Returns [`BindError::Host`] for a name that is too long for a blackboard.
pub fn robot(binder: &Binder<'_>) -> Result<Str, BindError> {
    word(binder.text_constant(ROBOT).unwrap_or(ROBOT))
}

/// A key of the shared blackboard for writing and reading, declared here unless the file
/// declares it.
///
/// # Errors
/// Returns a [`BindError::Board`] if it is declared otherwise.
pub fn key<T: Plain>(binder: &mut Binder<'_>, name: &str, default: T) -> Result<Out<T>, BindError> {
    use behavior::board::{Access, Scope};
    binder.writes(Scope::Shared, name, Some(default), Access::Write)
}

/// A text for a blackboard.
fn word(text: &str) -> Result<Str, BindError> {
    Str::new(text).ok_or_else(|| {
        BindError::Host(format!(
            "'{text}' is too long for a blackboard; give the arm or the object a name of at most \
             {} bytes",
            behavior::value::STR_BYTES - RESERVED.len() - 1
        ))
    })
}

/// The longest word before a name, see [`Owner`].
const RESERVED: &str = "reserved";

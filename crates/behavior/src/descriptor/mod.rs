//! Trees from files.

pub mod error;
pub mod json;

pub use error::{Errors, Located};

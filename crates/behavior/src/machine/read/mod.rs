//! Machines and matrices from files.

pub(crate) mod fields;
mod machine;
pub(crate) mod text;

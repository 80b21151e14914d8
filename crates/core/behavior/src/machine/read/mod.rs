//! Machines and matrices from files.

pub(crate) mod fields;
pub(crate) mod machine;
pub(crate) mod text;

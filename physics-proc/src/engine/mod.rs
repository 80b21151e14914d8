//! The physics engine: settings, shapes, contacts, and the conversion of vectors.

pub(crate) mod contacts;
pub(crate) mod convert;
pub(crate) mod entered;
pub(crate) mod friction;
pub(crate) mod hooks;
pub(crate) mod manifolds;
pub(crate) mod masses;
pub(crate) mod objects;
pub mod settings;
pub mod shapes;
pub(crate) mod simulation;
pub(crate) mod spawn;
pub(crate) mod tag;

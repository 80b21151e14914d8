//! The integration tests of this package, in one program: it links once.

mod determinism;
mod equipment;
mod grasp;
mod operator;
mod plc;
mod scene;
mod stops;
mod support;
mod two_arms;

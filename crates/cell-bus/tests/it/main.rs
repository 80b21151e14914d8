//! The integration tests of this package, in one program: it links once.

mod common;
mod faults;
mod operator;
mod topics;

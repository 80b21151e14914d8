//! The integration tests of this package, in one program: it links once.

mod files;
mod python;
mod ring;
mod support;

//! The integration tests of this package, in one program: it links once.

mod bin_stack;
mod clearance;
mod closed_pipe;
mod fill_bin;
mod palletize;
mod pyramid;
mod restart;
mod starved;
mod two_arms;
mod verify;
mod verify_file;
mod verify_record;
mod verify_support;

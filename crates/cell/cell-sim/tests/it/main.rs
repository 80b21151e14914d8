//! The integration tests of this package, in one program: it links once.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot continue has failed"
)]

mod bin_stack;
mod by_hand;
mod clearance;
mod cube;
mod episodes;
mod file_jobs;
mod fill_bin;
mod hands;
mod palletize;
mod pictures;
mod placement;
mod planned;
mod pyramid;
mod recorded;
mod reset;
mod situations;
mod snapshot;
mod suction;
mod tower;
mod two_arms;
mod user_arm;
mod verify;
mod verify_file;
mod verify_record;
mod verify_support;

/// The jobs of the demos with the cells of the checkout.
fn program() -> cell_sim::Program {
    cell_sim::Program {
        policies: demos::policies(),
        controllers: controller_proc::Controllers::default(),
        gateways: Vec::new(),
        data: cell_model::Data::checkout(),
    }
}

//! The benches, with more rows of `behavior`: the same work in other libraries. They take turns
//! with ours within one run, so they are part of one program.

mod bonsai;
mod statig;

use std::process::ExitCode;

use robocell_benches::{Peers, note};

#[global_allocator]
static ALLOCATOR: cell_rt::alloc::Counting = cell_rt::alloc::Counting;

fn main() -> ExitCode {
    let lock = include_str!("../Cargo.lock");
    robocell_benches::main(Some(&Peers {
        rows: || {
            bonsai::subjects()
                .into_iter()
                .chain(statig::subjects())
                .collect()
        },
        note: note(lock, &["bonsai-bt", "statig"]),
    }))
}

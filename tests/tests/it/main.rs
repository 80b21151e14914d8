//! The integration tests of this package, in one program: it links once.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "a test that cannot continue has failed"
)]

mod answers;
mod bad_input;
mod behaviours;
mod bins_in_real_time;
mod command_line;
mod dependencies;
#[cfg(feature = "schema")]
#[path = "../../../crates/core/behavior/tests/it/descriptor_common/mod.rs"]
mod descriptor_common;
#[cfg(feature = "schema")]
mod descriptor_schema;
mod equipment;
mod eval_rows;
mod eval_sweep;
mod fci;
mod fuzz;
mod hold_times;
mod imported;
mod incidents;
mod kill_sweep;
mod licences;
mod limits;
mod links;
mod lockstep;
mod logs;
mod machine;
mod new_project;
mod outputs;
mod page;
mod page_serving;
mod physics_kills;
mod pictures;
mod plot;
mod policy_server;
mod private_dir;
mod readers;
mod replaced;
mod replay;
mod restart_latency;
mod resume;
mod rogue;
mod running;
mod same_sentence;
mod scripts;
mod series;
mod source;
mod stacking;
mod supervision;
mod talk;
mod task_program;
mod unwritten;
mod zombie;

#![no_main]
#![allow(dead_code, unreachable_pub)]

#[path = "../../crates/fuzz-targets/tests/it/targets/mod.rs"]
mod targets;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (targets::files::TUNING.run)(bytes));

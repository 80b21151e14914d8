#![no_main]
#![allow(dead_code, unreachable_pub)]

#[path = "../../tests/tests/it/fuzz/targets/mod.rs"]
mod targets;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (targets::robot::FCI_DATAGRAM.run)(bytes));

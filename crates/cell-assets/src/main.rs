//! `robocell assets`.
#![forbid(unsafe_code)]

fn main() {}

//! The targets are in `tests/it/targets`: only tests may depend on all processes. The programs
//! in `fuzz/` are built from the same files.

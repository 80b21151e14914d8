//! The targets are in `tests/it/targets`: of the packages only tests may know all
//! processes. The programs in `fuzz/` are built of the same files.

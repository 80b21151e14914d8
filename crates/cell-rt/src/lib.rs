//! cell-rt

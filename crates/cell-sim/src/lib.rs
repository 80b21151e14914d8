//! cell-sim

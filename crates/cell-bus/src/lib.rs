//! cell-bus

//! cell-model

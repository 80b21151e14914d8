//! task-proc

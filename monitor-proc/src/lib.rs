//! monitor-proc

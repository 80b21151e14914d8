//! Recordings of a cell: MCAP files that other tools open, too, the flight
//! recorder's ring of them, and reading them again.
#![forbid(unsafe_code)]

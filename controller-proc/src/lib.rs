//! controller-proc

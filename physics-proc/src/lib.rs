//! physics-proc

//! rmp

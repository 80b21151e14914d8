//! Robots: their description, the files that they are read from, their dynamics.

pub mod cover;
pub mod dynamics;
mod file;
pub mod files;
mod load;
mod lula;
mod mimic;
mod motion;
mod movable;
mod moving_link;
mod plausible;
pub mod rmpflow;
pub mod robot;
pub mod self_distance;
mod self_pairs;
pub mod urdf;
mod urdf_check;
mod urdf_clean;
mod urdf_limits;
mod urdf_scan;
pub mod user;
pub mod xrdf;

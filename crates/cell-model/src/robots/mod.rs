//! What a robot is: its description, the files it is read from, its dynamics.

pub mod dynamics;
mod file;
mod load;
mod motion;
pub mod rmpflow;
pub mod robot;
pub mod urdf;
mod urdf_check;
mod urdf_scan;
pub mod user;
pub mod xrdf;

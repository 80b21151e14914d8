//! Meshes of robots, for two programs: `cell-assets` fetches the published meshes of our
//! robots, checks and reduces them and keeps them in the user's cache; `cell-spheres` fits
//! collision spheres to the meshes of any robot ([`spheres`]).
//!
//! The cell draws its robots from built-in primitives. `fetch` gets the meshes
//! their makers published, in one package of the Python package index whose
//! checksum is pinned here, and turns each link's COLLADA file into a small
//! binary glTF file in the frame of the link: metres, Z up, as in the URDF.
#![forbid(unsafe_code)]

pub mod cache;
pub mod collada;
pub mod decimate;
mod download;
mod error;
mod fetch;
pub mod glb;
pub mod manifest;
pub mod mesh;
pub mod normals;
pub mod package;
pub mod program;
pub mod spheres;
pub mod unpack;
pub mod wheel;

pub use cache::{cache_dir, meshes_dir};
pub use error::AssetError;
pub use fetch::{Fetched, Source, fetch};
pub use manifest::Manifest;

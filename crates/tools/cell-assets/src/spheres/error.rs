//! What can go wrong.

use cell_model::ModelError;
use thiserror::Error;

/// Why no spheres were fitted.
#[derive(Debug, Error)]
pub enum SphereError {
    /// The URDF is missing or wrong.
    #[error(transparent)]
    Robot(#[from] ModelError),
    /// A file cannot be read.
    #[error("cannot read {file}: {reason}")]
    Read {
        /// Name of the file.
        file: String,
        /// The reason.
        reason: String,
    },
    /// A mesh cannot be found.
    #[error(
        "{file}:{line}: link '{link}': mesh '{uri}' is not found; looked for {looked}. \
         `--package NAME=DIR` names the folder of a package"
    )]
    Missing {
        /// Name of the URDF.
        file: String,
        /// Line of the mesh in it.
        line: u32,
        /// The link.
        link: String,
        /// As the URDF names the mesh.
        uri: String,
        /// Paths that were tried.
        looked: String,
    },
    /// A mesh cannot be used.
    #[error("{file}:{line}: link '{link}': {reason}")]
    Geometry {
        /// Name of the URDF.
        file: String,
        /// Line of the geometry in it.
        line: u32,
        /// The link.
        link: String,
        /// The reason, with the allowed values.
        reason: String,
    },
    /// No link has geometry.
    #[error(
        "{file}: no link has collision or visual geometry, so there is nothing to fit spheres to"
    )]
    Empty {
        /// Name of the URDF.
        file: String,
    },
}

//! The list of the files in the cache, with their origin.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::AssetError;

/// File name, beside the folders of the robots.
pub const FILE: &str = "manifest.json";
/// Raised when the conversion changes, so that old caches are made again.
pub const CONVERSION: u32 = 1;

/// The files in the cache, and their origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Package of the Python package index.
    pub package: String,
    /// Its version.
    pub version: String,
    /// sha256 of the downloaded file.
    pub sha256: String,
    /// [`CONVERSION`] of the program that wrote the files.
    pub conversion: u32,
    /// Every mesh.
    pub files: Vec<MeshFile>,
    /// Notices that go with them.
    pub licences: Vec<Licence>,
}

/// The mesh of one link, at `ROBOT/LINK.glb`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeshFile {
    /// Folder of the robot.
    pub robot: String,
    /// Link in the robot's URDF.
    pub link: String,
    /// Triangles in the file.
    pub triangles: usize,
    /// Size of the file.
    pub bytes: u64,
    /// Pose of the file's frame in the frame of the link.
    pub pose: Pose,
}

/// A pose as the page's other messages give it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Metres.
    pub position: [f64; 3],
    /// Unit quaternion, scalar first.
    pub orientation_wxyz: [f64; 4],
}

impl Pose {
    /// The frame of the link itself.
    pub const IDENTITY: Self = Self {
        position: [0.0; 3],
        orientation_wxyz: [1.0, 0.0, 0.0, 0.0],
    };
}

/// A notice copied from the package.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Licence {
    /// File below the folder of the meshes.
    pub file: String,
    /// The robot, or the package, that it covers.
    pub covers: String,
}

impl MeshFile {
    /// Path below the folder of the meshes.
    pub fn path(&self) -> PathBuf {
        Path::new(&self.robot).join(format!("{}.glb", self.link))
    }
}

impl Manifest {
    /// Reads the manifest in `meshes`, the folder [`crate::meshes_dir`] gives.
    ///
    /// # Errors
    ///
    /// When it is missing or not understood.
    pub fn load(meshes: &Path) -> Result<Self, AssetError> {
        let path = meshes.join(FILE);
        if !path.exists() {
            let meshes = meshes.to_owned();
            return Err(AssetError::NotFetched { meshes });
        }
        let text = std::fs::read_to_string(&path).map_err(AssetError::file("reading", &path))?;
        serde_json::from_str(&text).map_err(|error| AssetError::Manifest {
            path,
            reason: error.to_string(),
        })
    }

    /// Whether `meshes` holds all that is listed, from the package and by the
    /// conversion of this program.
    pub fn is_current(&self, meshes: &Path) -> bool {
        let there = |file: &MeshFile| {
            std::fs::metadata(meshes.join(file.path())).is_ok_and(|m| m.len() == file.bytes)
        };
        self.sha256 == crate::package::SHA256
            && self.conversion == CONVERSION
            && self.files.len() == crate::package::LINKS.len()
            && self.files.iter().all(there)
    }
}

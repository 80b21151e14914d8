//! Which files a user's arm is read from.

use std::path::PathBuf;

/// Files of a user's arm (`--robot`, `--xrdf`, `--rmpflow`, `--tip`).
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct RobotFiles {
    /// The URDF.
    pub urdf: PathBuf,
    /// Controlled joints, limits, tool frame and spheres: an XRDF, or a robot description
    /// of Lula.
    pub xrdf: Option<PathBuf>,
    /// Tuning, `format: rmpflow`.
    pub rmpflow: Option<PathBuf>,
    /// The link of the tool; the arm ends there.
    #[serde(default)]
    pub tip: Option<String>,
}

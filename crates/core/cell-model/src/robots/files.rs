//! Which files a user's arm is read from.

use std::path::PathBuf;

/// A robot in place of that of the cell: one of `robots/`, or files of a user's arm (`--robot`, `--xrdf`, `--rmpflow`, `--tip`).
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct RobotFiles {
    /// The URDF; empty with a `name`.
    pub urdf: PathBuf,
    /// A robot of `robots/`, in place of files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Controlled joints, limits, tool frame and spheres: an XRDF, or a robot description
    /// of Lula.
    pub xrdf: Option<PathBuf>,
    /// Tuning, `format: rmpflow`.
    pub rmpflow: Option<PathBuf>,
    /// The link of the tool; the arm ends there.
    #[serde(default)]
    pub tip: Option<String>,
}

impl RobotFiles {
    /// The robot of `robots/` that is asked for by its name, unless a file has that name.
    pub fn named(asked: &std::path::Path, known: &[String]) -> Option<Self> {
        let name = asked.to_str().filter(|_| !asked.is_file())?;
        known.iter().any(|known| known == name).then(|| Self {
            name: Some(name.to_owned()),
            ..Self::default()
        })
    }
}

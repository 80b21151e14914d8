//! Where the mesh is that a URDF names.

use std::path::{Path, PathBuf};

/// Folders of packages.
#[derive(Clone, Debug, Default)]
pub struct Packages {
    /// Name and folder.
    pub named: Vec<(String, PathBuf)>,
    /// Folders with packages, as `ROS_PACKAGE_PATH` lists them.
    pub roots: Vec<PathBuf>,
}

impl Packages {
    /// `named`, and what the environment of ROS says.
    pub fn from_environment(named: Vec<(String, PathBuf)>) -> Self {
        let list = |variable: &str| std::env::var_os(variable).unwrap_or_default();
        let ros = list("ROS_PACKAGE_PATH");
        let ament = list("AMENT_PREFIX_PATH");
        let shares = std::env::split_paths(&ament).map(|prefix| prefix.join("share"));
        Self {
            named,
            roots: std::env::split_paths(&ros).chain(shares).collect(),
        }
    }

    /// The file `uri` names in the URDF at `urdf`.
    ///
    /// # Errors
    /// The paths that were tried.
    pub(crate) fn find(&self, urdf: &Path, uri: &str) -> Result<PathBuf, Vec<PathBuf>> {
        let tried = self.candidates(urdf, uri);
        let found = tried.iter().find(|path| path.is_file()).cloned();
        found.ok_or(tried)
    }

    fn candidates(&self, urdf: &Path, uri: &str) -> Vec<PathBuf> {
        let dir = urdf.parent().unwrap_or(Path::new(""));
        if let Some(path) = uri.strip_prefix("file://") {
            return vec![dir.join(path)];
        }
        let within = ["package://", "model://"]
            .iter()
            .find_map(|scheme| uri.strip_prefix(scheme));
        let Some(within) = within else {
            return vec![dir.join(uri)];
        };
        // `join` would take an absolute path in place of the folder.
        let within = within.trim_start_matches('/');
        let (name, rest) = within.split_once('/').unwrap_or((within, ""));
        if let Some((_, folder)) = self.named.iter().find(|(known, _)| known == name) {
            return vec![folder.join(rest)];
        }
        // Folders above the URDF first: mostly it is within the package or beside it. The path is
        // made absolute, because the ancestors of a relative one end at the current directory.
        let dir = std::path::absolute(dir).unwrap_or_else(|_| dir.to_owned());
        let above = dir.ancestors().take(6).flat_map(|above| {
            let is_package = above.file_name().is_some_and(|own| own == name);
            [
                is_package.then(|| above.join(rest)),
                Some(above.join(within)),
            ]
        });
        let above: Vec<PathBuf> = above.flatten().collect();
        let roots = self.roots.iter().map(|root| root.join(within));
        above.into_iter().chain(roots).collect()
    }
}

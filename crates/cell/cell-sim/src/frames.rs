//! Hashes of the pictures of a run.

use std::collections::BTreeMap;

use crate::{OneProcess, SimError};

impl OneProcess {
    /// Hashes of colour, depth and mask of the present picture of these cameras, by name.
    ///
    /// # Errors
    /// For a camera that the cell does not have.
    pub fn frames(&self, names: &[String]) -> Result<BTreeMap<String, String>, SimError> {
        let pictures = camera::observe(&self.cell, self.state(), names)?;
        let hashes = pictures.iter().map(|picture| {
            let [rgb, depth, mask] = picture.hashes();
            format!("{rgb:016x} {depth:016x} {mask:016x}")
        });
        Ok(names.iter().cloned().zip(hashes).collect())
    }
}

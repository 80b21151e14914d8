//! Reads the needed members of the package, and no more than they may hold.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use zip::ZipArchive;

use crate::{AssetError, wheel};

/// Largest member that is read, bytes. The largest mesh has 2.4 MB.
pub const MEMBER_LIMIT: u64 = 8 << 20;
/// Most members an archive may list. The package has about 1,500.
pub const MEMBERS_LIMIT: usize = 20_000;

/// An archive none of whose members points out of it.
#[derive(Debug)]
pub struct Archive<R> {
    zip: ZipArchive<R>,
    limit: u64,
}

impl Archive<BufReader<File>> {
    /// Opens a file.
    ///
    /// # Errors
    ///
    /// As [`Archive::new`], and when the file cannot be opened.
    pub fn open(path: &Path) -> Result<Self, AssetError> {
        let file = wheel::open(path)?;
        Self::new(BufReader::new(file), MEMBER_LIMIT)
    }
}

impl<R: Read + Seek> Archive<R> {
    /// Reads the list of members; no member above `limit` bytes will be read.
    ///
    /// # Errors
    ///
    /// When it is no ZIP archive, lists too many members, or one of them with
    /// an absolute path or a path through `..`.
    pub fn new(reader: R, limit: u64) -> Result<Self, AssetError> {
        let zip = ZipArchive::new(reader).map_err(|error| refuse("", error.to_string()))?;
        if zip.len() > MEMBERS_LIMIT {
            let reason = format!("{} members, allowed are {MEMBERS_LIMIT}", zip.len());
            return Err(refuse("", reason));
        }
        for name in zip.file_names_raw() {
            let name = String::from_utf8_lossy(name);
            if !is_inside(&name) {
                return Err(refuse(&name, "the path leaves the archive".to_owned()));
            }
        }
        Ok(Self { zip, limit })
    }

    /// The text of one member.
    ///
    /// # Errors
    ///
    /// When it is missing, broken, too large or no UTF-8.
    pub fn text(&mut self, member: &str) -> Result<String, AssetError> {
        let limit = self.limit;
        let file = self
            .zip
            .by_name(member)
            .map_err(|error| refuse(member, error.to_string()))?;
        let mut text = String::new();
        // The size in the header is a claim, so the unpacked bytes are counted. One byte more than
        // the limit shows that there is more, without unpacking it.
        let read = file
            .take(limit + 1)
            .read_to_string(&mut text)
            .map_err(|error| refuse(member, error.to_string()))?;
        if read as u64 > limit {
            return Err(refuse(member, format!("more than {limit} bytes")));
        }
        Ok(text)
    }
}

fn is_inside(name: &str) -> bool {
    let absolute = name.starts_with(['/', '\\']) || name.contains(':');
    !absolute && !name.contains('\0') && name.split(['/', '\\']).all(|part| part != "..")
}

fn refuse(member: &str, reason: String) -> AssetError {
    AssetError::Archive {
        member: member.to_owned(),
        reason,
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Write};

    use zip::write::SimpleFileOptions;

    use super::*;

    fn archive(members: &[(&str, &[u8])]) -> Cursor<Vec<u8>> {
        let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in members {
            zip.start_file(*name, SimpleFileOptions::default()).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap()
    }

    #[test]
    fn a_member_is_read() {
        let mut archive = Archive::new(archive(&[("a/b.dae", b"<x/>")]), 100).unwrap();
        assert_eq!(archive.text("a/b.dae").unwrap(), "<x/>");
        let said = archive.text("a/c.dae").unwrap_err().to_string();
        assert!(said.contains("a/c.dae"), "{said}");
    }

    #[test]
    fn a_member_out_of_the_archive_is_refused() {
        for name in ["a/../../b", "../b", "/etc/b", "a\\..\\b"] {
            let said = Archive::new(archive(&[("ok", b""), (name, b"")]), 100).unwrap_err();
            assert!(said.to_string().contains("leaves the archive"), "{said}");
        }
        Archive::new(archive(&[("a/..b/c..", b"")]), 100).unwrap();
    }

    #[test]
    fn a_bomb_is_refused() {
        let zeros = vec![0; 1 << 20];
        let mut archive = Archive::new(archive(&[("bomb", &zeros)]), 1000).unwrap();
        let said = archive.text("bomb").unwrap_err().to_string();
        assert!(said.contains("more than 1000 bytes"), "{said}");
    }
}

//! How large an imported file may be, so that reading any file ends soon.

/// Bytes of all files together.
pub(crate) const MAX_BYTES: usize = 4 << 20;
/// Files that one file may include, itself counted.
pub(crate) const MAX_FILES: usize = 32;
/// Elements inside one another: trees have fewer levels.
pub(crate) const MAX_NESTING: usize = 128;
/// Elements of one file.
pub(crate) const MAX_ELEMENTS: u32 = 65_536;

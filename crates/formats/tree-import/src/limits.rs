//! Limits of an imported file, so that reading any file ends soon.

/// Largest size of all files together (bytes).
// As that of a tree file: a file that is not meant is not read into memory.
pub(crate) const MAX_BYTES: usize = 4 << 20;
/// Files that one file may include, itself counted.
// Included files may include others.
pub(crate) const MAX_FILES: usize = 32;
/// Nesting of elements; trees have fewer levels.
// Bounds the recursion of the reader, which has the stack of the program.
pub(crate) const MAX_NESTING: usize = 128;
/// Elements of one file.
// Bounds the memory of the XML reader.
pub(crate) const MAX_ELEMENTS: u32 = 65_536;

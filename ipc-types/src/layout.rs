//! Memory layout of the messages' structs, for readers in other languages.

/// One field of a struct.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldLayout {
    /// Its name.
    pub name: &'static str,
    /// Type of one element: `u8`, `u32`, `u64`, `i64`, `f64`, `TextN` for N bytes of
    /// UTF-8 that end at the first zero, or the name of a struct.
    pub element: String,
    /// Elements; 1 for a field that is not an array.
    pub count: usize,
    /// Bytes from the start of the struct.
    pub offset: usize,
}

impl FieldLayout {
    pub(crate) fn new(
        name: &'static str,
        (element, count): (String, usize),
        offset: usize,
    ) -> Self {
        Self {
            name,
            element,
            count,
            offset,
        }
    }
}

/// A struct. Numbers are little-endian; there is no padding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StructLayout {
    /// Its name.
    pub name: &'static str,
    /// Its size.
    pub bytes: usize,
    /// [`crate::Wire::SCHEMA`]; in the header of a message, and behind `#` in the name of
    /// its type on the bus.
    pub schema: u64,
    /// Its fields, in the order of their offsets.
    pub fields: Vec<FieldLayout>,
}

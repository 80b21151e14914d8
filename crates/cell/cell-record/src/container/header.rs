//! What the format says of a message and of a schema.

/// What the format says of a message.
pub(crate) struct MessageHeader {
    /// Number of its channel in the file.
    pub(crate) channel: u16,
    pub(crate) sequence: u32,
    pub(crate) time_ns: u64,
    pub(crate) publish_ns: u64,
}

/// A schema: name, encoding, data.
pub(crate) type Schema<'a> = (&'a str, &'a str, &'a str);

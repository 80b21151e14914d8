//! The attachment of `rmw_zenoh` to every message: sequence number (i64), time at its source
//! (ns since 1970, i64) and 16 bytes that identify the sender, after their count;
//! little-endian.

/// Bytes of an attachment.
const SIZE: usize = 8 + 8 + 1 + 16;

/// An attachment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// Counts messages of the sender, or requests of a client.
    pub sequence: i64,
    /// Time at which the content was made (ns since 1970).
    pub source_ns: i64,
    /// Identifies the sender.
    pub gid: [u8; 16],
}

impl Attachment {
    /// In the format of the network.
    pub fn to_bytes(self) -> [u8; SIZE] {
        let mut bytes = [0; SIZE];
        let (sequence, rest) = bytes.split_at_mut(8);
        let (source, rest) = rest.split_at_mut(8);
        let (count, gid) = rest.split_at_mut(1);
        sequence.copy_from_slice(&self.sequence.to_le_bytes());
        source.copy_from_slice(&self.source_ns.to_le_bytes());
        count.fill(16);
        gid.copy_from_slice(&self.gid);
        bytes
    }

    /// `None` if the bytes are not an attachment.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let bytes: &[u8; SIZE] = bytes.try_into().ok()?;
        let (sequence, rest) = bytes.split_first_chunk()?;
        let (source, rest) = rest.split_first_chunk()?;
        let (count, gid) = rest.split_first()?;
        // The count is part of the format; another one is another version.
        (*count == 16).then_some(Self {
            sequence: i64::from_le_bytes(*sequence),
            source_ns: i64::from_le_bytes(*source),
            gid: gid.try_into().ok()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_attachment_is_read_back_and_others_are_none() {
        let attachment = Attachment {
            sequence: 7,
            source_ns: -2,
            gid: [9; 16],
        };
        let mut bytes = attachment.to_bytes();
        assert_eq!(Attachment::from_bytes(&bytes), Some(attachment));
        assert_eq!(Attachment::from_bytes(&bytes[1..]), None);
        bytes[16] = 24;
        assert_eq!(Attachment::from_bytes(&bytes), None);
    }
}

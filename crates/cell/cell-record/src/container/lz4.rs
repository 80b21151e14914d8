//! Frames of lz4, block by block.

use lz4::block::{CompressionMode, compress_bound, compress_to_buffer};

/// Bytes of a block before compression: it is still in the cache then. The file is
/// half a percent larger than with blocks of 256 kB, and 4 % smaller than with 64.
pub(super) const BLOCK_BYTES: usize = 128 << 10;
/// Magic; version 1, blocks that stand alone, no checksum (the chunk has one);
/// blocks of up to 256 kB; second byte of the xxHash of these two.
const FRONT: [u8; 7] = [0x04, 0x22, 0x4d, 0x18, 0x60, 0x50, 0xfb];
/// No block follows.
const END: [u8; 4] = [0; 4];
/// Set in the length of a block that is as it was.
const PLAIN: u32 = 1 << 31;
/// How readily the search gives up. Most of the rest of measured values is
/// noise: 1 finds 1 % more and costs a fifth more, 6 loses a tenth.
const ACCELERATION: i32 = 4;

/// A frame that grows.
#[derive(Default)]
pub(super) struct Frame {
    bytes: Vec<u8>,
    room: Vec<u8>,
}

impl Frame {
    /// Starts a new frame.
    pub(super) fn begin(&mut self) {
        self.bytes.clear();
        self.bytes.extend_from_slice(&FRONT);
    }

    /// Adds `block`, of at most [`BLOCK_BYTES`].
    pub(super) fn add(&mut self, block: &[u8]) {
        let bound = compress_bound(block.len()).unwrap_or(block.len());
        if self.room.len() < bound {
            self.room.resize(bound, 0);
        }
        let mode = Some(CompressionMode::FAST(ACCELERATION));
        let packed = compress_to_buffer(block, mode, false, &mut self.room).ok();
        let packed = packed.and_then(|length| self.room.get(..length));
        let smaller = packed.filter(|packed| packed.len() < block.len());
        let (mark, bytes) = smaller.map_or((PLAIN, block), |packed| (0, packed));
        let length = bytes.len() as u32 | mark;
        self.bytes.extend_from_slice(&length.to_le_bytes());
        self.bytes.extend_from_slice(bytes);
    }

    /// Finishes the frame; returns its bytes.
    pub(super) fn end(&mut self) -> &[u8] {
        self.bytes.extend_from_slice(&END);
        &self.bytes
    }
}

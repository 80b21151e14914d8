//! Pictures of a cell: colour, depth and instance mask of a camera, drawn by the CPU from the
//! state of the world alone.
//!
//! Each pixel shows the nearest of the shapes that physics computes with. Pictures look
//! flat: one light with hard shadows, one colour per object, no texture, no noise of a sensor.
//!
//! What can go wrong: another processor computes another last bit, and a data set of pictures
//! cannot be made twice. The rule: poses are computed in f64 with the functions of `libm`;
//! pixels in f32 with `+ - * /`, square roots, comparisons and selections only, each of which IEEE
//! 754 defines to the bit. Nothing is fused, and no sum depends on the number of lanes. Of two
//! surfaces at the same distance the one with the lower instance number is seen.

mod cast;
mod draw;
mod light;
mod nearest;
mod observe;
mod scene;
mod shade;
mod view;

pub use draw::draw;
pub use light::Light;
pub use observe::{UnknownCamera, observe};
pub use scene::{Scene, instances};
pub use view::View;

/// What a camera sees. Pixels are in rows from the top, from left to right.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green and blue of each pixel, 0 to 255.
    pub rgb: Vec<u8>,
    /// Distance along the axis of view (m), from [`NEAR_M`] on; 0 where nothing is seen.
    pub depth_m: Vec<f32>,
    /// Number in [`instances`], from 1 on, of the visible body; 0 where nothing is visible.
    pub mask: Vec<u16>,
}

impl Picture {
    /// Hashes of colour, depth and mask (FNV-1a of 64 bits over their bytes, numbers in
    /// little-endian order).
    pub fn hashes(&self) -> [u64; 3] {
        let depth = self.depth_m.iter().flat_map(|depth| depth.to_le_bytes());
        let mask = self.mask.iter().flat_map(|number| number.to_le_bytes());
        [hash(self.rgb.iter().copied()), hash(depth), hash(mask)]
    }
}

fn hash(bytes: impl Iterator<Item = u8>) -> u64 {
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Nothing nearer to the eye is seen (m).
pub const NEAR_M: f32 = 0.02;

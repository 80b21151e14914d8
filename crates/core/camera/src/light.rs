//! The light of a picture.

use nalgebra::Vector3;

/// One distant light, and the light that comes from everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Towards the distant light, of length 1, in the world frame.
    pub direction: Vector3<f64>,
    /// On a surface that faces it, 0 to 1.
    pub direct: f32,
    /// On every surface that faces up, 0 to 1.
    pub from_above: f32,
    /// On every surface that faces down, 0 to 1.
    pub from_below: f32,
    /// Colour where nothing is seen: red, green, blue, 0 to 1.
    pub background: [f32; 3],
}

impl Default for Light {
    fn default() -> Self {
        Self {
            direction: Vector3::new(0.35, -0.45, 1.0).normalize(),
            direct: 0.55,
            from_above: 0.52,
            from_below: 0.30,
            background: [0.90, 0.92, 0.95],
        }
    }
}

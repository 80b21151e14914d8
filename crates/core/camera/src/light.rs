//! The light of a picture.

use cell_model::cells::file::LightTable;
use nalgebra::Vector3;

use crate::cast::single;

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

impl Light {
    /// The light of a cell.
    pub fn of(light: &LightTable) -> Self {
        Self {
            direction: Vector3::new(light.from_x, light.from_y, 1.0).normalize(),
            direct: single(light.direct),
            from_above: single(light.from_above),
            from_below: single(light.from_below),
            background: [0.90, 0.92, 0.95],
        }
    }
}

impl Default for Light {
    fn default() -> Self {
        Self::of(&LightTable::default())
    }
}

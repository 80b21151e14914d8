//! A fixture of a cell.

use nalgebra::Isometry3;

use super::pose::oriented;
use crate::cells::file::FixtureTable;
use crate::shape::Shape;

/// A fixture.
#[derive(Clone, Debug, PartialEq)]
pub struct FixtureSpec {
    /// Name in the cell.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Pose in the world frame.
    pub pose: Isometry3<f64>,
    /// Friction coefficient.
    pub friction: f64,
    /// Whether it exists in physics; otherwise it only guides motions.
    pub solid: bool,
    /// Whether motion policies avoid it.
    pub obstacle: bool,
    /// Red, green, blue from 0 to 1.
    pub colour: [f64; 3],
}

/// The fixture of a table.
pub(super) fn fixture(table: &FixtureTable) -> FixtureSpec {
    FixtureSpec {
        name: table.name.clone(),
        shape: table.shape.clone(),
        pose: oriented(table.position_m, table.yaw_rad, table.orientation_wxyz),
        friction: table.friction,
        solid: table.solid,
        obstacle: table.obstacle,
        colour: table.colour,
    }
}

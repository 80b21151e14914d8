//! A fixture of a cell.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use super::pose::turn_about_z;
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
        pose: Isometry3::from_parts(
            Translation3::from(table.position_m),
            table
                .orientation_wxyz
                .map_or_else(|| turn_about_z(table.yaw_rad), unit),
        ),
        friction: table.friction,
        solid: table.solid,
        obstacle: table.obstacle,
        colour: table.colour,
    }
}

/// The rotation of a quaternion w x y z, whose norm was checked to be 1.
fn unit([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z))
}

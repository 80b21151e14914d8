//! A movable object of the cell.

use cell_model::{ObjectSpec, Shape};

/// A movable object of the cell.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectSetup {
    /// Its name in the cell file.
    pub name: String,
    /// Half of its height when it is upright (m).
    pub half_height_m: f64,
    /// Its narrowest side (m).
    pub narrowest_m: f64,
    /// Bit of [`ipc_types::ArmGoal::object_mask`], for one that is an obstacle.
    pub obstacle_bit: Option<u32>,
}

impl ObjectSetup {
    /// The setup of `spec`.
    pub fn of(spec: &ObjectSpec) -> Self {
        let half_height_m = match spec.shape {
            Shape::Box { size_m } | Shape::Bin { size_m, .. } => 0.5 * size_m[2],
            Shape::Sphere { radius_m } => radius_m,
            Shape::Cylinder { height_m, .. } => 0.5 * height_m,
            Shape::Capsule { radius_m, height_m } => radius_m + 0.5 * height_m,
        };
        Self {
            name: spec.name.clone(),
            half_height_m,
            narrowest_m: narrowest(&spec.shape),
            obstacle_bit: None,
        }
    }
}

/// The narrowest side of a shape (m).
fn narrowest(shape: &Shape) -> f64 {
    match *shape {
        Shape::Box { size_m } | Shape::Bin { size_m, .. } => {
            size_m.into_iter().fold(f64::INFINITY, f64::min)
        }
        Shape::Sphere { radius_m } | Shape::Capsule { radius_m, .. } => 2.0 * radius_m,
        Shape::Cylinder { radius_m, height_m } => height_m.min(2.0 * radius_m),
    }
}

//! When a waypoint counts as reached.

use ipc_types::Pose;
use nalgebra::Vector3;

use super::pose;

/// What may be left between the cup and a waypoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precision {
    /// Distance (m).
    pub position_m: f64,
    /// Norm of the difference of the two y axes, and of the two z axes, each.
    pub axis: f64,
}

/// The five rows of the source, finest first.
pub const ROWS: [Precision; 5] = [
    row(0.0005, 0.0025),
    row(0.0005, 0.005),
    row(0.05, 0.2),
    row(0.08, 0.4),
    row(0.18, 0.6),
];

/// Row of a waypoint that is passed by on the way to others.
pub const PASSING: usize = 4;

const fn row(position_m: f64, axis: f64) -> Precision {
    Precision { position_m, axis }
}

impl Precision {
    /// A row by its number; the coarsest for one that does not exist.
    pub fn of_row(row: usize) -> Self {
        let [.., coarsest] = ROWS;
        ROWS.get(row).copied().unwrap_or(coarsest)
    }

    /// Whether `measured` is at `target`. The x axes are not compared, as in the
    /// source: with y and z they are given.
    pub fn reached(&self, target: &Pose, measured: &Pose) -> bool {
        let offset = Vector3::from(target.position) - Vector3::from(measured.position);
        let (wanted, is) = (
            pose::rotation(target.orientation_wxyz),
            pose::rotation(measured.orientation_wxyz),
        );
        let error = |axis: Vector3<f64>| (wanted * axis - is * axis).norm();
        offset.norm() < self.position_m
            && error(Vector3::y()) < self.axis
            && error(Vector3::z()) < self.axis
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ur10::pose::straight_down;

    fn at(x: f64, yaw: f64) -> Pose {
        Pose {
            position: [x, 0.0, 0.0],
            orientation_wxyz: straight_down(yaw),
        }
    }

    #[test]
    fn each_row_has_its_distance_and_its_angle() {
        let distances = [0.0005, 0.0005, 0.05, 0.08, 0.18];
        let axes = [0.0025, 0.005, 0.2, 0.4, 0.6];
        for (row, (distance, axis)) in distances.into_iter().zip(axes).enumerate() {
            let precision = Precision::of_row(row);
            let reached = |x, yaw| precision.reached(&at(0.0, 0.0), &at(x, yaw));
            // The chord of a small angle is nearly the angle.
            assert!(reached(0.99 * distance, 0.99 * axis), "row {row}");
            assert!(!reached(1.01 * distance, 0.0), "row {row}");
            assert!(!reached(0.0, 1.05 * axis), "row {row}");
        }
        assert_eq!(Precision::of_row(99), ROWS[PASSING]);
    }
}

//! The condition for a waypoint to be reached.

use ipc_types::Pose;
use nalgebra::Vector3;

use crate::geometry::rotation;

/// The largest difference between the TCP and a reached waypoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precision {
    /// Distance (m).
    pub position_m: f64,
    /// Norm of the difference of the two y axes, and the same for the two z axes.
    pub axis: f64,
}

impl Precision {
    /// A precision of a distance (m), and of axes that differ by less than `axis`.
    pub const fn new(position_m: f64, axis: f64) -> Self {
        Self { position_m, axis }
    }

    /// Whether `measured` is at `target`. The x axes are not compared: they follow from y and
    /// z.
    pub fn reached(&self, target: &Pose, measured: &Pose) -> bool {
        let offset = Vector3::from(target.position) - Vector3::from(measured.position);
        let (wanted, is) = (
            rotation(target.orientation_wxyz),
            rotation(measured.orientation_wxyz),
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
    use crate::geometry::straight_down_by_x as straight_down;

    fn at(x: f64, yaw: f64) -> Pose {
        Pose {
            position: [x, 0.0, 0.0],
            orientation_wxyz: straight_down(yaw),
        }
    }

    #[test]
    fn distance_and_angle_both_count() {
        for (distance, axis) in [(0.0005, 0.0025), (0.05, 0.2), (0.18, 0.6)] {
            let precision = Precision::new(distance, axis);
            let reached = |x, yaw| precision.reached(&at(0.0, 0.0), &at(x, yaw));
            // The chord of a small angle is nearly the angle.
            assert!(reached(0.99 * distance, 0.99 * axis), "{distance}");
            assert!(!reached(1.01 * distance, 0.0), "{distance}");
            assert!(!reached(0.0, 1.05 * axis), "{axis}");
        }
    }
}

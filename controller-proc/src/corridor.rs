//! Approach corridors: the tool reaches a target from one side.

use nalgebra::{UnitQuaternion, Vector3};

/// A preferred direction of approach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corridor {
    /// Direction of the last part of the motion, scaled by its length (m).
    pub direction: Vector3<f64>,
    /// Distance from the axis at which the target is shifted back (m).
    pub std_dev: f64,
}

impl Corridor {
    /// The point that attracts the tool: the target itself on the corridor's axis, up to a
    /// corridor's length before it away from the axis. `tool` is the pose of the controller's
    /// integrated state: the measured one would feed the tracking error back into the motion.
    ///
    /// The formula is that of Cortex (approach parameters): a Gaussian in the
    /// distance from the axis plus half a third of the orientation error.
    pub fn shift(
        &self,
        target: (Vector3<f64>, Option<UnitQuaternion<f64>>),
        tool: (Vector3<f64>, UnitQuaternion<f64>),
    ) -> Vector3<f64> {
        let length = self.direction.norm();
        // Written so that a length or deviation that is not a number gives the plain target.
        if !(length > 0.0 && self.std_dev > 0.0) {
            return target.0;
        }
        let axis = self.direction / length;
        let offset = tool.0 - target.0;
        let sideways = (offset - axis * offset.dot(&axis)).norm();
        let turned = target.1.map_or(0.0, |orientation| {
            let difference = orientation.to_rotation_matrix().into_inner()
                - tool.1.to_rotation_matrix().into_inner();
            0.5 * difference.norm() / 3.0
        });
        let distance = sideways + turned;
        let alpha = 1.0 - libm::exp(-distance * distance / (2.0 * self.std_dev * self.std_dev));
        target.0 - self.direction * alpha
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beside_the_axis_the_target_steps_back_on_it_it_does_not() {
        let corridor = Corridor {
            direction: Vector3::new(0.0, 0.0, -0.1),
            std_dev: 0.01,
        };
        let target = (Vector3::new(0.5, 0.0, 0.02), None);
        let at = |x, z| (Vector3::new(x, 0.0, z), UnitQuaternion::identity());
        assert_eq!(corridor.shift(target, at(0.5, 0.3)), target.0);
        let beside = corridor.shift(target, at(0.6, 0.02));
        assert!(
            (beside - Vector3::new(0.5, 0.0, 0.12)).norm() < 1.0e-9,
            "{beside}"
        );
    }

    #[test]
    fn no_direction_means_straight_on() {
        let corridor = Corridor {
            direction: Vector3::zeros(),
            std_dev: 0.01,
        };
        let target = (Vector3::new(0.5, 0.0, 0.02), None);
        let far = (Vector3::new(0.0, 1.0, 1.0), UnitQuaternion::identity());
        assert_eq!(corridor.shift(target, far), target.0);
    }
}

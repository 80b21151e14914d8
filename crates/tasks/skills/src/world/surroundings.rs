//! The surroundings of an object: other objects on top of it, and other arms.

use nalgebra::Vector3;

use super::World;

/// An object nearer than this many heights in the plane, and higher, is on top of another.
const ON_TOP_HEIGHTS: f64 = 0.9;
/// Its centre is between these many heights above the other's.
const ABOVE_HEIGHTS: std::ops::Range<f64> = 0.3..1.5;

impl World<'_> {
    /// Whether another object is on top of `object`; held ones do not count.
    pub fn is_covered(&self, object: usize) -> bool {
        let (Some(position), Some(setup)) = (self.position(object), self.object_setup(object))
        else {
            return false;
        };
        let height = 2.0 * setup.half_height_m;
        let mut others = (0..self.setup.objects.len()).filter(|other| *other != object);
        others.any(|other| {
            self.position(other).is_some_and(|its| {
                let off = (its - position) / height;
                off.xy().norm() < ON_TOP_HEIGHTS && ABOVE_HEIGHTS.contains(&off.z)
            }) && !self.is_held(other)
        })
    }

    /// Whether an arm other than this one reaches a point (m).
    pub fn is_reached_by_another(&self, point: Vector3<f64>) -> bool {
        let mut arms = self.setup.arms.iter().enumerate();
        arms.any(|(arm, setup)| arm != self.arm && setup.reaches(point))
    }

    /// Whether the TCP of an arm other than this one is nearer to a point than
    /// `distance_m` (m).
    pub fn is_another_near(&self, point: Vector3<f64>, distance_m: f64) -> bool {
        let mut others = (0..self.setup.arms.len()).filter(|arm| *arm != self.arm);
        others.any(|arm| {
            let tcp = self.observation.tcp(arm);
            tcp.is_some_and(|tcp| (Vector3::from(tcp.position) - point).norm() < distance_m)
        })
    }
}

//! The surroundings of an object: other objects on top of it, and other arms.

use nalgebra::Vector3;

use super::World;

/// An object nearer than this many heights in the plane, and higher, is on top of another.
const ON_TOP_HEIGHTS: f64 = 0.9;
/// Its centre is between these many heights above the other's.
const ABOVE_HEIGHTS: std::ops::Range<f64> = 0.3..1.5;

/// Clearance of a carried object to the sides and to the top of a body that it passes (m).
const PASSING_M: f64 = 0.02;
/// A body that is higher than this above a carried object is passed at the side, by the controller
/// (m).
const PASSED_ABOVE_M: f64 = 0.3;

impl World<'_> {
    /// The height (m) that the lowest point of `object` needs on a straight way between two
    /// points, with its centre there: above all that it passes.
    pub(crate) fn passing_height(
        &self,
        object: usize,
        from: Vector3<f64>,
        to: Vector3<f64>,
    ) -> f64 {
        let scene = self.setup.grasping.scene(self.arm, self.observation);
        let Some(scene) = scene else {
            return f64::NEG_INFINITY;
        };
        let half = self
            .object_setup(object)
            .map_or(0.0, |of| 0.5 * of.longest_m);
        let highest = from.z.max(to.z) + PASSED_ABOVE_M;
        let others = scene.objects.iter().enumerate();
        let others = others.filter(|(other, _)| *other != object && !self.is_held(*other));
        let bodies = others.map(|(_, body)| body).chain(&scene.fixtures);
        let tops = bodies.filter_map(|body| {
            let pose = body.pose?;
            let [x, y, z] =
                [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| body.extent(&pose, &axis));
            let sides = [x, y].map(|(low, high)| (low - half - PASSING_M, high + half + PASSING_M));
            (z.1 < highest && crosses(from.xy().into(), to.xy().into(), sides)).then_some(z.1)
        });
        tops.fold(f64::NEG_INFINITY, f64::max) + PASSING_M
    }

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

/// Whether the line between two points crosses a rectangle, given by its least and largest
/// coordinate on each axis.
fn crosses(from: [f64; 2], to: [f64; 2], sides: [(f64, f64); 2]) -> bool {
    let (mut begin, mut end) = (0.0_f64, 1.0_f64);
    for ((from, to), (low, high)) in from.into_iter().zip(to).zip(sides) {
        let way = to - from;
        if way.abs() < 1.0e-9 {
            if from < low || from > high {
                return false;
            }
            continue;
        }
        let (a, b) = ((low - from) / way, (high - from) / way);
        begin = begin.max(a.min(b));
        end = end.min(a.max(b));
    }
    begin <= end
}

//! The object on the suction gripper, as spheres that move with the tool: it keeps away from
//! obstacles as the arm does.

use cell_model::{Cell, Shape};
use ipc_types::{ArmState, WorldState};
use nalgebra::{Isometry3, Point3, Vector3};
use rmp::{MAX_CARRIED, RmpFlow, TargetId};

use crate::checkpoint::{CheckpointError, Codec};
use crate::convert::isometry;

/// Radius of the spheres of an object that is large enough (m).
const RADIUS_M: f64 = 0.03;
/// Distance of the spheres from the surface of their object, inwards (m): a gripped object may
/// rest on an obstacle, and must not jump away from it.
const INSET_M: f64 = 0.01;
/// An edge longer than this has a sphere in its middle (m).
const LONG_EDGE_M: f64 = 0.18;

/// Spheres nearer to the middle than this are replaced by one in the middle (m).
const MIN_REACH_M: f64 = 1.0e-3;

/// A sphere in the frame of its object: centre and radius (m).
type Ball = (Vector3<f64>, f64);

/// The held object and its pose in the tool frame.
pub struct HeldObject {
    /// By object of the cell; empty for an arm without suction.
    spheres: Vec<Vec<Ball>>,
    /// Index of the held object.
    object: Option<usize>,
    /// Its pose in the tool frame, measured when it was attached.
    pose: Isometry3<f64>,
    /// Its spheres in the tool frame.
    in_tool: Vec<Ball>,
}

impl HeldObject {
    /// No object is held yet by arm `arm` of `cell`.
    pub fn new(cell: &Cell, arm: usize) -> Self {
        let suction = cell
            .arms
            .get(arm)
            .is_some_and(|a| a.robot.suction.is_some());
        let objects = cell.objects.iter().filter(|_| suction);
        Self {
            spheres: objects.map(|object| spheres(&object.shape)).collect(),
            object: None,
            pose: Isometry3::identity(),
            in_tool: Vec::with_capacity(MAX_CARRIED),
        }
    }

    /// Index of the held object.
    pub fn object(&self) -> Option<usize> {
        self.object
    }

    /// Spheres of the held object: centre in the tool frame and radius (m).
    pub fn balls(&self) -> &[(Vector3<f64>, f64)] {
        &self.in_tool
    }

    /// Takes the object that `arm` holds in `state`; the `tool` of `flow` carries its spheres.
    /// Allocates nothing.
    pub fn observe(
        &mut self,
        state: &WorldState,
        arm: &ArmState,
        flow: &mut RmpFlow,
        tool: TargetId,
    ) {
        let held = attached(arm);
        // The pose is taken once, at the change: afterwards the object moves with the tool,
        // and its measured pose would carry the tracking error into the motion.
        if held == self.object {
            return;
        }
        self.object = held;
        let object = held.and_then(|index| state.objects().get(index));
        self.pose = object.map_or(Isometry3::identity(), |object| {
            isometry(&arm.tcp).inverse() * isometry(&object.pose)
        });
        self.carry(flow, tool);
    }

    /// Writes or reads the held object and its pose; the spheres of `flow` are set by them.
    pub(crate) fn checkpoint(
        &mut self,
        codec: &mut Codec<'_>,
        flow: &mut RmpFlow,
        tool: TargetId,
    ) -> Result<(), CheckpointError> {
        codec.option("held object", &mut self.object, |codec, index| {
            codec.index("held object", index, ipc_types::MAX_OBJECTS)
        })?;
        codec.pose(&mut self.pose)?;
        if codec.reads() {
            self.carry(flow, tool);
        }
        Ok(())
    }

    fn carry(&mut self, flow: &mut RmpFlow, tool: TargetId) {
        flow.drop_carried();
        self.in_tool.clear();
        let Some(spheres) = self.object.and_then(|index| self.spheres.get(index)) else {
            return;
        };
        let place = |(center, radius): &Ball| ((self.pose * Point3::from(*center)).coords, *radius);
        self.in_tool.extend(spheres.iter().map(place));
        // A pose that is not finite is refused; the tool then carries no spheres.
        let _carried = flow.carry(tool, &self.in_tool).is_ok();
    }
}

/// The object held by suction.
fn attached(arm: &ArmState) -> Option<usize> {
    let gripper = &arm.gripper;
    let index = (gripper.held_object as usize).checked_sub(1)?;
    (gripper.attached == 1).then_some(index)
}

/// Spheres that cover a shape: at its corners, in the middle of long edges, and on the floor
/// of a bin. At most [`MAX_CARRIED`].
fn spheres(shape: &Shape) -> Vec<Ball> {
    let (half, floor) = match *shape {
        Shape::Box { size_m } => (Vector3::from(size_m) * 0.5, false),
        Shape::Bin { size_m, .. } => (Vector3::from(size_m) * 0.5, true),
        Shape::Sphere { radius_m } => (Vector3::repeat(radius_m), false),
        Shape::Cylinder { radius_m, height_m } => {
            (Vector3::new(radius_m, radius_m, 0.5 * height_m), false)
        }
        Shape::Capsule { radius_m, height_m } => (
            Vector3::new(radius_m, radius_m, 0.5 * height_m + radius_m),
            false,
        ),
    };
    // Both are bounded by the shape: a small part has small spheres, not ones outside of it.
    let inset = INSET_M.min(0.25 * half.min());
    let radius = RADIUS_M.min(half.min() - inset);
    let reach = half.add_scalar(-(radius + inset));
    let mut balls = Vec::with_capacity(MAX_CARRIED);
    for x in places(reach.x) {
        for y in places(reach.y) {
            for z in places(reach.z) {
                // Only corners and edges: a sphere inside would never be nearest.
                let middles = [(x, reach.x), (y, reach.y), (z, reach.z)]
                    .iter()
                    .filter(|(at, reach)| *at == 0.0 && *reach > MIN_REACH_M)
                    .count();
                if middles <= 1 {
                    balls.push((Vector3::new(x, y, z), radius));
                }
            }
        }
    }
    if floor {
        balls.push((Vector3::new(0.0, 0.0, -reach.z), radius));
    }
    balls
}

/// Positions of spheres along an axis: the middle of a short one, both ends of a longer one,
/// and also the middle where the gap would be wide.
fn places(reach: f64) -> impl Iterator<Item = f64> {
    let ends = reach > MIN_REACH_M;
    let middle = !ends || 2.0 * reach > LONG_EDGE_M;
    [(ends, -reach), (middle, 0.0), (ends, reach)]
        .into_iter()
        .filter_map(|(there, at)| there.then_some(at))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_stay_within_the_object_and_come_near_all_its_corners() {
        let bin = Shape::Bin {
            size_m: [0.3, 0.2, 0.147],
            wall_m: 0.005,
        };
        let balls = spheres(&bin);
        assert_eq!(balls.len(), 13);
        let half = Vector3::new(0.15, 0.1, 0.0735);
        for (center, radius) in &balls {
            let reach = center.abs().add_scalar(*radius);
            assert!((half - reach).min() > 0.5 * INSET_M, "{center}");
        }
        for corner in [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]] {
            let corner: Vector3<f64> = half.component_mul(&Vector3::from(corner));
            let near = balls.iter().map(|(c, r): &Ball| (corner - c).norm() - r);
            assert!(near.fold(f64::INFINITY, f64::min) < 0.05);
        }
    }

    #[test]
    fn every_shape_of_any_size_fits() {
        for size in [0.004, 0.05, 0.3, 2.0] {
            let shapes = [
                Shape::Box {
                    size_m: [size, 0.1, 0.02],
                },
                Shape::Sphere { radius_m: size },
                Shape::Cylinder {
                    radius_m: 0.03,
                    height_m: size,
                },
                Shape::Capsule {
                    radius_m: 0.01,
                    height_m: size,
                },
                Shape::Bin {
                    size_m: [size; 3],
                    wall_m: 0.001,
                },
            ];
            for shape in shapes {
                let count = spheres(&shape).len();
                assert!((1..=MAX_CARRIED).contains(&count), "{shape:?}: {count}");
                assert!(spheres(&shape).iter().all(|(_, radius)| *radius > 0.0));
            }
        }
    }
}

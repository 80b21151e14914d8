//! The eye of a picture.

use cell_model::Cell;
use cell_model::cells::cell::CameraSpec;
use ipc_types::WorldState;
use nalgebra::{Isometry3, Vector3};

use crate::cast::single;
use crate::scene::frame_poses;

/// Pose and lens of a camera at one moment.
#[derive(Clone, Debug)]
pub struct View {
    /// Pose in the world (m): x to the right of the picture, y down, z ahead.
    pub pose: Isometry3<f64>,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    focal: f64,
}

impl View {
    /// A camera with a vertical field of view of `field_of_view` (rad, 0 to pi).
    pub fn new(pose: Isometry3<f64>, field_of_view: f64, width: u32, height: u32) -> Self {
        // `libm`, not `f64::tan`, which may differ in its last bit between systems.
        let focal = 0.5 * f64::from(height) / libm::tan(0.5 * field_of_view);
        Self {
            pose,
            width,
            height,
            focal,
        }
    }

    /// The camera of a cell in a state.
    pub fn of(cell: &Cell, state: &WorldState, camera: &CameraSpec) -> Self {
        let mounted = camera.mount.and_then(|mount| {
            let (arm, seen) = (cell.arms.get(mount.arm)?, state.arms().get(mount.arm)?);
            let frame = arm.robot.chain.frames().get(mount.frame)?;
            let links = frame_poses(arm, seen);
            let link = links.get(frame.joint.map_or(0, |joint| joint + 1))?;
            Some(link * frame.pose * camera.pose)
        });
        let pose = mounted.unwrap_or(camera.pose);
        Self::new(pose, camera.field_of_view, camera.width, camera.height)
    }

    /// Pixels at distance 1: the offset of a pixel from the middle by this is the slope of its ray.
    pub fn focal(&self) -> f64 {
        self.focal
    }

    /// A vector of the picture in another frame, whose pose in the world is `frame`.
    pub(crate) fn axes_in(&self, frame: &Isometry3<f64>) -> [Vector3<f64>; 3] {
        let turn = frame.rotation.inverse() * self.pose.rotation;
        [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| turn * axis)
    }

    /// Slopes of the rays of all columns, and of all rows: offset by distance.
    pub(crate) fn slopes(&self) -> [Vec<f32>; 2] {
        [self.width, self.height].map(|count| {
            let middle = 0.5 * f64::from(count);
            let slope = |at| (f64::from(at) + 0.5 - middle) / self.focal;
            (0..count).map(|at| single(slope(at))).collect()
        })
    }
}

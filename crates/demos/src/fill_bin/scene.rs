//! What the job sees in one observation.

use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{GripperState, Pose};
use nalgebra::{Isometry3, Vector3};

use super::setup::FillBinSetup;
use robocell_skills::pose;
use robocell_skills::setup::ARM;
use robocell_task::observation::Observation;

/// A bin slower than this lies still (m/s, rad/s).
const STILL_M_S: f64 = 0.02;
const STILL_RAD_S: f64 = 0.2;

/// The arm, its cup, and the bin.
#[derive(Clone, Copy)]
pub(super) struct View<'s, 'o> {
    pub(super) setup: &'s FillBinSetup,
    pub(super) observation: &'s Observation<'o>,
    pub(super) tcp: Pose,
    pub(super) gripper: &'o GripperState,
    pub(super) bin: Isometry3<f64>,
    /// The bin is in the cell.
    pub(super) bin_here: bool,
    /// It does not move.
    pub(super) bin_still: bool,
}

impl<'s, 'o> View<'s, 'o> {
    /// `None` until the arm and the bin are observed.
    pub(super) fn read(setup: &'s FillBinSetup, observation: &'s Observation<'o>) -> Option<Self> {
        let arm = observation.arm(ARM)?;
        let bin = observation.object(setup.bin)?;
        let speed = Vector3::from(bin.twist.linear).norm();
        let turning = Vector3::from(bin.twist.angular).norm();
        Some(Self {
            setup,
            observation,
            tcp: arm.tcp,
            gripper: &arm.gripper,
            bin: pose::isometry(&bin.pose),
            bin_here: bin.flags & OBJECT_ENABLED != 0,
            bin_still: speed < STILL_M_S && turning < STILL_RAD_S,
        })
    }

    /// Whether the cup holds the bin, and not something else.
    pub(super) fn holds_bin(&self) -> bool {
        self.gripper.attached == 1 && self.observation.held_object(ARM) == Some(self.setup.bin)
    }

    /// Parts that are in the cell: centre in the world frame (m) and radius (m).
    pub(super) fn parts(&self) -> impl Iterator<Item = (Vector3<f64>, f64)> {
        self.setup.parts.iter().filter_map(|(index, radius)| {
            let part = self.observation.object(*index)?;
            let here = part.flags & OBJECT_ENABLED != 0;
            here.then(|| (Vector3::from(part.pose.position), *radius))
        })
    }

    /// Which way the bin opens, world frame.
    pub(super) fn up(&self) -> Vector3<f64> {
        self.bin.rotation * Vector3::z()
    }
}

//! Where the TCP shall be in a phase, and which way the fingers point.

use ipc_types::Pose;
use nalgebra::Vector3;

use super::phase::Phase;
use super::setup::StackSetup;
use robocell_task::job::Placement;

pub use robocell_skills::geometry::{
    angle_between, nearest_quarter, plane_distance, straight_down, tool_yaw, yaw,
};

/// The pose of the TCP in `phase`: above `place` by the clearance while it
/// travels, at it otherwise, always by the grasp offset of the cell file. The
/// demos' offset of -0.03 m along the tool's y belongs to another tool frame.
pub fn tcp_target(setup: &StackSetup, phase: Phase, place: Placement) -> Pose {
    let height = match phase {
        Phase::PreGrasp | Phase::Lift | Phase::Transport | Phase::Retract => setup.spec.clearance_m,
        Phase::Approach | Phase::Grasp | Phase::Lower | Phase::Release => 0.0,
    };
    let centre = Vector3::from(place.position) + Vector3::from(setup.spec.grasp_offset_m);
    Pose {
        position: (centre + Vector3::z() * height).into(),
        orientation_wxyz: straight_down(place.yaw),
    }
}

/// A destination nearer than this in the plane is beside the pick-up (m).
const BESIDE_M: f64 = 0.2;

/// What LIFT rises above: the pick-up, as in the demos, or the height of a
/// higher destination right beside it, since a cube that lies at the foot of
/// the stack would knock it over on a slanted way up.
pub fn lift_place(pickup: Placement, destination: Placement) -> Placement {
    let beside = plane_distance(pickup.position.into(), destination.position.into()) < BESIDE_M;
    let [x, y, z] = pickup.position;
    let height = if beside {
        z.max(destination.position[2])
    } else {
        z
    };
    Placement {
        position: [x, y, height],
        ..pickup
    }
}

/// How near the TCP has to come (m). The demos know one tolerance, 0.08 m,
/// wider than a cube; where the fingers meet a cube ours is finer.
pub fn tolerance(setup: &StackSetup, phase: Phase) -> f64 {
    match phase {
        Phase::Approach | Phase::Grasp | Phase::Lower | Phase::Release => {
            setup.spec.precise_tolerance_m
        }
        Phase::PreGrasp | Phase::Lift | Phase::Transport | Phase::Retract => {
            setup.spec.travel_tolerance_m
        }
    }
}

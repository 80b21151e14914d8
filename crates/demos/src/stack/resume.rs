//! Finding out what is in the hand when memory and world may differ.

use super::geometry::nearest_quarter;
use super::phase::Phase;
use super::recovery::dropped;
use super::scene::View;
use super::setup::StackSetup;
use nalgebra::Vector3;
use robocell_task::job::{Job, Placement};

/// A cube found in the hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InHand {
    /// Its place in the order.
    pub cube: usize,
    /// Where it goes.
    pub destination: Placement,
    /// It goes back.
    pub aborted: bool,
    /// Where it would have been picked up to hang where it hangs.
    pub pickup: Placement,
    /// What comes next: LIFT, or LOWER where it is at its goal already.
    pub phase: Phase,
}

/// The cube in the hand: what physics says about the fingers' contacts, else what the checkpoint says, if the cube is near
/// the TCP. A checkpoint that agrees also says where the cube goes.
pub fn in_hand(setup: &StackSetup, scene: &View, job: &Job) -> Option<InHand> {
    let remembered = job.held.and_then(|object| setup.cube_of_object(object));
    let cube = scene.held.or(remembered)?;
    let spec = setup.cube(cube)?;
    if dropped(setup, scene, cube) {
        return None;
    }
    let (destination, aborted) = match job.destination {
        Some(destination) if remembered == Some(cube) => (destination, job.aborted),
        _ => (spec.goal, false),
    };
    let mut pickup = scene.cube(cube).place();
    // The fingers are around the cube already, whichever way they came.
    pickup.yaw = nearest_quarter(pickup.yaw, scene.tcp_yaw);
    // Lifting aims above the pick-up by the clearance, so a cube that is up
    // already is held at its height.
    pickup.position[2] =
        (pickup.position[2] - setup.spec.clearance_m).max(setup.spec.base_height_m);
    Some(InHand {
        cube,
        destination,
        aborted,
        pickup,
        phase: if is_there(setup, scene, cube, destination) {
            Phase::Lower
        } else {
            Phase::Lift
        },
    })
}

/// Whether a cube is where it is being carried, so that there is nothing to
/// lift it over any more.
pub fn is_there(setup: &StackSetup, scene: &View, cube: usize, destination: Placement) -> bool {
    let offset = scene.cube(cube).position - Vector3::from(destination.position);
    offset.norm() < setup.spec.goal_tolerance_m
}

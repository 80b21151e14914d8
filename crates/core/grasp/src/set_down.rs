//! Whether an object fits where it is set down, and the hand around it.

use nalgebra::{Isometry3, Translation3};

use crate::candidate::Exclusion;
use crate::gripper::Gripper;
use crate::scene::{Body, Scene};
use crate::{cup, fingers};

/// The object is checked this far above its place (m): at the place itself it touches its support.
const LIFT_M: f64 = 0.001;
/// Nearer than this it touches (m).
const TOUCHES_M: f64 = 0.0005;

/// An object in the gripper, and where it is set down; poses in the world frame.
#[derive(Clone, Copy, Debug)]
pub struct SetDown<'s> {
    /// Index of the object in the scene.
    pub object: usize,
    /// Width of the hand that holds it (m); of a cup any.
    pub width_m: f64,
    /// Distance to which its fingers open then (m).
    pub opening_m: f64,
    /// Pose of the object.
    pub goal: &'s Isometry3<f64>,
    /// Pose of the TCP.
    pub tcp: &'s Isometry3<f64>,
}

/// What prevents `gripper` from bringing an object there, opening, and moving back. The object at
/// its present pose is not in the way.
pub fn set_down(gripper: &Gripper, scene: &Scene, of: &SetDown<'_>) -> Option<Exclusion> {
    let SetDown {
        object,
        width_m,
        opening_m,
        goal,
        tcp,
    } = *of;
    let body = scene.objects.get(object)?;
    does_not_fit(scene, body, goal).or_else(|| match gripper {
        // With the object on the way there, open on the way back.
        Gripper::Fingers(hand) => [width_m, opening_m]
            .into_iter()
            .find_map(|width_m| fingers::blocked_on_way(hand, scene, body, (tcp, width_m))),
        Gripper::Cup(cup) => cup::blocked(cup, scene, body, tcp),
    })
}

/// Whether a body set down at `at` touches `other` (poses in the world frame).
pub fn touches(
    (body, at): (&Body, &Isometry3<f64>),
    (other, other_at): (&Body, &Isometry3<f64>),
) -> bool {
    let lifted = Translation3::new(0.0, 0.0, LIFT_M) * at;
    body.solid
        .is_near(&lifted, &other.solid, other_at, TOUCHES_M)
}

/// Another arm of the scene that is nearer to the open `gripper` with its TCP at `tcp` (world
/// frame) than `margin` (m).
pub fn arm_in_the_way(
    gripper: &Gripper,
    scene: &Scene,
    tcp: &Isometry3<f64>,
    margin: f64,
) -> Option<Exclusion> {
    let found = scene.arms.iter().find(|body| match gripper {
        Gripper::Fingers(hand) => fingers::is_near(hand, (tcp, hand.open_width_m), body, margin),
        Gripper::Cup(cup) => body.is_near(&cup.body, tcp, margin),
    });
    found.map(|body| Exclusion::Arm(body.name.clone()))
}

/// The body that blocks an object at `goal`.
fn does_not_fit(scene: &Scene, object: &Body, goal: &Isometry3<f64>) -> Option<Exclusion> {
    let at = Translation3::new(0.0, 0.0, LIFT_M) * goal;
    scene.touched(object, (TOUCHES_M, TOUCHES_M, TOUCHES_M), |body, margin| {
        body.is_near(&object.solid, &at, margin)
    })
}

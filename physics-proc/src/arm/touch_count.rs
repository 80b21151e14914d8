//! Counts how often an arm touched obstacles, and itself.
//!
//! The engine computes no contacts between the links of one arm: those are counted by the
//! self-collision spheres of the robot, at its measured joint positions.

use cell_model::{Cell, SelfDistance};
use rapier3d_f64::prelude::*;
use serde::{Deserialize, Serialize};

use crate::arm::measured::Measured;
use crate::arm::multibody::Arm;
use crate::engine::tag::Tag;

/// Interval at which the self-collision spheres are compared (ticks).
// Pairs of spheres are compared, so not in each tick; a shorter contact may be missed.
const SELF_TICKS: u64 = 10;

/// Counts of one arm: part of every snapshot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct TouchCount {
    /// Times an obstacle began to be touched.
    pub(super) obstacles: u64,
    /// Times two parts of the arm began to overlap.
    pub(super) own_parts: u64,
    touches_obstacle: bool,
    touches_itself: bool,
}

impl TouchCount {
    /// Counts continue over a reset of the scene.
    pub(super) fn carry_over(&mut self, before: &Self) {
        (self.obstacles, self.own_parts) = (before.obstacles, before.own_parts);
    }

    fn note_obstacle(&mut self, touches: bool) {
        self.obstacles += u64::from(touches && !self.touches_obstacle);
        self.touches_obstacle = touches;
    }

    fn note_own_parts(&mut self, touches: bool) {
        self.own_parts += u64::from(touches && !self.touches_itself);
        self.touches_itself = touches;
    }
}

/// Obstacles of the cell, and the spheres of each arm.
pub(crate) struct TouchCounter {
    /// By fixture and by object of the cell.
    fixtures: Vec<bool>,
    objects: Vec<bool>,
    distances: Vec<SelfDistance>,
}

impl TouchCounter {
    pub(crate) fn new(cell: &Cell) -> Self {
        Self {
            fixtures: cell
                .fixtures
                .iter()
                .map(|fixture| fixture.obstacle)
                .collect(),
            objects: cell.objects.iter().map(|object| object.obstacle).collect(),
            distances: cell
                .arms
                .iter()
                .map(|arm| SelfDistance::new(&arm.robot))
                .collect(),
        }
    }

    /// Counts for arm `index`, which holds the object `held`, after the step to `tick`.
    pub(super) fn count(
        &mut self,
        world: &PhysicsWorld,
        (index, arm): (usize, &Arm),
        measured: &Measured,
        (tick, held): (u64, Option<usize>),
        count: &mut TouchCount,
    ) {
        let mut links = arm.bodies.iter().enumerate().skip(1);
        count.note_obstacle(links.any(|(link, body)| {
            let colliders = world
                .bodies
                .get(*body)
                .map_or(&[][..], RigidBody::colliders);
            // Fingers touch objects to grip them; other links have no reason to.
            let may_grip = is_hand(arm, link);
            colliders
                .iter()
                .any(|own| self.touches_obstacle(world, index, *own, (may_grip, held)))
        }));
        // Computed from the spheres, since the engine has no contacts within an arm.
        if tick.is_multiple_of(SELF_TICKS)
            && let Some(distance) = self.distances.get_mut(index)
        {
            let nearest = distance.nearest(&arm.robot, &measured.positions, 0.0);
            count.note_own_parts(nearest < 0.0);
        }
    }

    fn touches_obstacle(
        &self,
        world: &PhysicsWorld,
        arm: usize,
        own: ColliderHandle,
        (may_grip, held): (bool, Option<usize>),
    ) -> bool {
        let pairs = world.narrow_phase.contact_pairs_with(own);
        // The engine prepares contacts 2 mm before the shapes meet; only an impulse is a
        // contact.
        let mut pressed = pairs.filter(|pair| pair.total_impulse_magnitude() > 0.0);
        pressed.any(|pair| {
            let other = if pair.collider1 == own {
                pair.collider2
            } else {
                pair.collider1
            };
            match world.colliders.get(other).map(|c| Tag::decode(c.user_data)) {
                None => false,
                Some(Tag::Link { arm: other, .. }) => other != arm,
                Some(Tag::Fixture(index)) => self.fixtures.get(index) == Some(&true),
                Some(Tag::Object(index)) => {
                    !may_grip && held != Some(index) && self.objects.get(index) == Some(&true)
                }
            }
        })
    }
}

/// Whether the link is a finger, or carries the cup: it touches objects to grip them.
fn is_hand(arm: &Arm, link: usize) -> bool {
    let is_finger = |joint: &usize| joint + 1 == link;
    let gripper = arm.robot.gripper.as_ref();
    gripper.is_some_and(|gripper| gripper.finger_joints.iter().any(is_finger))
        || (arm.robot.suction.is_some() && link + 1 == arm.bodies.len())
}

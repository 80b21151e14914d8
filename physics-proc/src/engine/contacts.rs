//! Contacts of arms and objects, read from the engine after a tick.

use rapier3d_f64::prelude::*;

use crate::arm::multibody::Arm;
use crate::engine::settings::TICK_S;
use crate::engine::tag::Tag;

/// An object is held when both fingers press it with more than this (N).
// Small, so that a weak grip counts; zero would count an object that merely touches both pads.
const HELD_N: f64 = 0.05;
/// Contacts whose normal is farther from the closing direction do not press (cosine of 60
/// degrees): fingers that rest on an object hold nothing.
const PRESSES: f64 = 0.5;

/// Contacts of one tick.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contacts {
    /// By object: touched by a link of any arm.
    pub(crate) touched: Vec<bool>,
    /// By arm.
    pub(crate) grips: Vec<Grip>,
    /// By arm and object: force of the two fingers (N).
    pressed: Vec<Vec<[f64; 2]>>,
}

/// Measurement of a gripper.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Grip {
    /// Smaller contact force of the two fingers (N).
    pub(crate) force: f64,
    /// The object between them.
    pub(crate) held: Option<usize>,
}

impl Contacts {
    /// Room for `arms` and `objects`.
    pub(crate) fn new(arms: usize, objects: usize) -> Self {
        Self {
            touched: vec![false; objects],
            grips: vec![Grip::default(); arms],
            pressed: vec![vec![[0.0; 2]; objects]; arms],
        }
    }

    /// Reads the contacts of the last step.
    pub(crate) fn read(&mut self, world: &PhysicsWorld, arms: &[Arm]) {
        self.touched.fill(false);
        for (index, arm) in arms.iter().enumerate() {
            self.pressed[index].fill([0.0; 2]);
            let axis = closing_axis(world, arm);
            for (link, body) in arm.bodies().iter().enumerate() {
                let side = finger_of(arm, link).zip(axis);
                for collider in world
                    .bodies
                    .get(*body)
                    .map_or(&[][..], RigidBody::colliders)
                {
                    self.read_collider(world, *collider, index, side);
                }
            }
            self.grips[index] = grip(&self.pressed[index]);
        }
    }

    /// An attached object counts as touched.
    pub(crate) fn attach(&mut self, object: Option<usize>) {
        if let Some(touched) = object.and_then(|object| self.touched.get_mut(object)) {
            *touched = true;
        }
    }

    fn read_collider(
        &mut self,
        world: &PhysicsWorld,
        collider: ColliderHandle,
        arm: usize,
        side: Option<(usize, Vector)>,
    ) {
        for pair in world
            .narrow_phase
            .contact_pairs_with(collider)
            .filter(|pair| pair.has_any_active_contact())
        {
            let other = partner(pair, collider);
            // Contacts with fixtures and arms neither hold an object nor keep it awake.
            let Some(Tag::Object(object)) =
                world.colliders.get(other).map(|c| Tag::decode(c.user_data))
            else {
                continue;
            };
            if let Some(touched) = self.touched.get_mut(object) {
                *touched = true;
            }
            if let Some((side, axis)) = side
                && let Some(force) = self.pressed[arm]
                    .get_mut(object)
                    .and_then(|both| both.get_mut(side))
            {
                // Several colliders of a finger may press one object: their forces add up.
                *force += pressing_impulse(pair, axis) / TICK_S;
            }
        }
    }
}

/// The other collider of a pair of `collider`.
pub(crate) fn partner(pair: &ContactPair, collider: ColliderHandle) -> ColliderHandle {
    if pair.collider1 == collider {
        pair.collider2
    } else {
        pair.collider1
    }
}

/// Impulse of the contacts along `axis` (N s).
fn pressing_impulse(pair: &ContactPair, axis: Vector) -> f64 {
    let manifolds = pair.manifolds().iter();
    let pressing = manifolds.filter(|of| of.data.normal.dot(axis).abs() > PRESSES);
    pressing
        .flat_map(|of| &of.points)
        .map(|point| point.data.impulse)
        .sum()
}

/// The direction in which the fingers close; `None` where they meet, and without fingers.
fn closing_axis(world: &PhysicsWorld, arm: &Arm) -> Option<Vector> {
    let [first, second] = arm.robot().gripper.as_ref()?.finger_joints;
    let at = |joint: usize| {
        let body = world.bodies.get(*arm.bodies().get(joint + 1)?)?;
        Some(body.translation())
    };
    let off = at(second)? - at(first)?;
    let length = off.length();
    (length > 1.0e-6).then(|| off / length)
}

/// Which finger a link is.
fn finger_of(arm: &Arm, link: usize) -> Option<usize> {
    let gripper = arm.robot().gripper.as_ref()?;
    gripper
        .finger_joints
        .iter()
        .position(|joint| joint + 1 == link)
}

fn grip(pressed: &[[f64; 2]]) -> Grip {
    let mut best = Grip::default();
    for (object, [left, right]) in pressed.iter().enumerate() {
        // The smaller of the two: an object that leans on one finger is not held.
        let force = left.min(*right);
        if force > HELD_N && force > best.force {
            best = Grip {
                force,
                held: Some(object),
            };
        }
    }
    best
}

/// Deepest penetration of any contact pair (m).
pub(crate) fn deepest(world: &PhysicsWorld) -> f64 {
    let points = world
        .contact_pairs()
        .flat_map(ContactPair::manifolds)
        .flat_map(|manifold| &manifold.points);
    points.fold(0.0, |deepest, point| deepest.max(-point.dist))
}

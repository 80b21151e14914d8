//! A movable object of a cell, and its placement by the seed.

use nalgebra::{Isometry3, Translation3, Vector3};

use super::pose::{oriented, turn_about_z};
use crate::cells::file::{ObjectTable, SpawnArea, numbered};
use crate::random::Random;
use crate::shape::Shape;

/// A movable object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectSpec {
    /// Name in the cell.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Mass (kg).
    pub mass: f64,
    /// Friction coefficient for this seed.
    pub friction: f64,
    /// Pose at the start for this seed, world frame.
    pub pose: Isometry3<f64>,
    /// Pose without the seed's variation, world frame.
    pub nominal: Isometry3<f64>,
    /// Largest deviation by which a seed may move it.
    pub spawn: SpawnArea,
    /// `name` of its table, which all objects of a series share.
    pub kind: String,
    /// Whether it is not in the simulation until the conveyor or the dispenser brings it.
    pub parked: bool,
    /// Whether motion policies can avoid it.
    pub obstacle: bool,
    /// Whether it may fall asleep while it still trembles.
    pub sleeps: bool,
    /// Damping of its turning (1/s).
    pub angular_damping: f64,
    /// Red, green, blue from 0 to 1.
    pub colour: [f64; 3],
}

impl ObjectSpec {
    /// Whether it is a bin.
    pub fn is_bin(&self) -> bool {
        matches!(self.shape, Shape::Bin { .. })
    }

    /// Draws another pose within the spawn area.
    pub fn respawn(&mut self, random: &mut Random) {
        self.pose = vary(&self.nominal, self.spawn, random);
    }
}

/// An object of a table at its place for this seed. Four numbers are drawn for every object,
/// used or not: x, y, yaw, friction; a fifth if it can have several shapes. So a spread of 0
/// does not move the objects after it.
pub(super) fn place(object: &ObjectTable, index: u32, random: &mut Random) -> ObjectSpec {
    let mut nominal = oriented(object.position_m, object.yaw_rad, object.orientation_wxyz);
    nominal.translation.vector += Vector3::from(object.pitch_m) * f64::from(index);
    let varied = vary(&nominal, object.spawn, random);
    let friction = object.friction + random.around_zero(object.friction_spread);
    let shape = match random_index(object.other_shapes.len() + 1, random) {
        0 => &object.shape,
        other => object.other_shapes.get(other - 1).unwrap_or(&object.shape),
    };
    ObjectSpec {
        name: numbered(object, index),
        shape: shape.clone(),
        mass: object.mass_kg,
        friction,
        kind: object.name.clone(),
        parked: object.parked,
        obstacle: object.obstacle,
        sleeps: object.sleeps,
        angular_damping: object.angular_damping,
        pose: varied,
        nominal,
        spawn: object.spawn,
        colour: object.colour,
    }
}

/// A number below `count`, each as likely; draws nothing if there is no choice.
fn random_index(count: usize, random: &mut Random) -> usize {
    if count < 2 {
        return 0;
    }
    usize::try_from(random.bits() % count as u64).unwrap_or(0)
}

fn vary(nominal: &Isometry3<f64>, spawn: SpawnArea, random: &mut Random) -> Isometry3<f64> {
    let (x, y) = (random.around_zero(spawn.x_m), random.around_zero(spawn.y_m));
    let turn = turn_about_z(random.around_zero(spawn.yaw_rad));
    Isometry3::from_parts(
        Translation3::new(x, y, 0.0) * nominal.translation,
        turn * nominal.rotation,
    )
}

//! Joints as measured.

use cell_model::Robot;
use rapier3d_f64::prelude::PhysicsWorld;

use crate::arm::Arm;

/// Joints of one arm, by joint of the chain. Always finite: a state the engine
/// lost keeps its last good values.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    /// rad or m.
    pub(crate) positions: Vec<f64>,
    /// rad/s or m/s.
    pub(crate) velocities: Vec<f64>,
    scratch: (Vec<f64>, Vec<f64>),
}

impl Measured {
    /// At home.
    pub(crate) fn new(robot: &Robot) -> Self {
        let home: Vec<f64> = robot.joints.iter().map(|spec| spec.home).collect();
        let zeros = vec![0.0; home.len()];
        Self {
            positions: home,
            velocities: zeros.clone(),
            scratch: (zeros.clone(), zeros),
        }
    }

    /// Reads the joints from the engine.
    pub(crate) fn read(&mut self, arm: &Arm, world: &PhysicsWorld) {
        let (positions, velocities) = &mut self.scratch;
        arm.measure(world, positions, velocities);
        if positions
            .iter()
            .chain(velocities.iter())
            .all(|x| x.is_finite())
        {
            self.positions.copy_from_slice(positions);
            self.velocities.copy_from_slice(velocities);
        }
    }
}

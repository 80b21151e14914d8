//! Nothing may start inside something else.

use cell_model::{ArmSpec, Cell};

use crate::engine::shapes::overlap;
use crate::error::WorldError;

/// Objects resting on a table touch it; this much is still resting (m).
pub(crate) const RESTING_M: f64 = 1.0e-3;

/// Shapes of links are rounder than the robot; this much is no overlap (m).
const ROUGH_M: f64 = 20.0e-3;

/// Checks that the links of arms that move are not deep inside of a solid obstacle: the engine
/// cannot take them apart. A fixture that is no obstacle may be reached into, such as the
/// floor by the legs of a robot.
fn check_arm(cell: &Cell, arm: &ArmSpec) -> Result<(), WorldError> {
    let poses = arm
        .robot
        .link_poses(&arm.robot.with_arm_positions(&arm.home));
    let moving = arm.robot.links.iter().zip(&poses).skip(1);
    let solid = cell.fixtures.iter().filter(|f| f.solid && f.obstacle);
    for ((link, pose), fixture) in
        moving.flat_map(|link| solid.clone().map(move |fixture| (link, fixture)))
    {
        for part in &link.shapes {
            let at = arm.base * pose * part.pose;
            let depth = overlap(&part.shape, &at, &fixture.shape, &fixture.pose);
            if depth > ROUGH_M {
                return Err(WorldError::ArmOverlap {
                    arm: arm.name.clone(),
                    link: link.name.clone(),
                    fixture: fixture.name.clone(),
                    depth,
                });
            }
        }
    }
    Ok(())
}

/// Checks that no object of the cell overlaps another or a fixture; what is not
/// in the cell yet, or not solid, blocks nothing. Nor may an arm be within an obstacle.
pub(crate) fn check(cell: &Cell) -> Result<(), WorldError> {
    cell.arms.iter().try_for_each(|arm| check_arm(cell, arm))?;
    let objects = cell.objects.iter().enumerate();
    for (index, object) in objects.filter(|(_, object)| !object.parked) {
        let earlier = cell
            .objects
            .iter()
            .take(index)
            .filter(|other| !other.parked)
            .map(|other| (&other.name, &other.shape, &other.pose));
        let fixtures = cell
            .fixtures
            .iter()
            .filter(|fixture| fixture.solid)
            .map(|other| (&other.name, &other.shape, &other.pose));
        for (name, shape, pose) in earlier.chain(fixtures) {
            let depth = overlap(&object.shape, &object.pose, shape, pose);
            if depth > RESTING_M {
                return Err(WorldError::Overlap {
                    object: object.name.clone(),
                    other: name.clone(),
                    depth,
                });
            }
        }
    }
    Ok(())
}

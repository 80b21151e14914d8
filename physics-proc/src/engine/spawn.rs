//! Refuses cells in which shapes start inside each other.

use cell_model::{ArmSpec, Cell};

use crate::engine::shapes::overlap;
use crate::error::WorldError;

/// Depth up to which an object rests on another shape (m).
// Shapes at rest sink in by less than 0.1 mm; more than this is a mistake of the cell file.
pub(crate) const RESTING_M: f64 = 1.0e-3;

/// Depth up to which a link does not overlap: shapes of links are rounder than the robot (m).
const ROUGH_M: f64 = 20.0e-3;

/// Checks that the moving links of an arm are not deep inside a solid obstacle, from which the
/// engine cannot part them. A fixture that is not an obstacle may contain links, such as a
/// floor the legs of a robot.
fn check_arm(cell: &Cell, arm: &ArmSpec) -> Result<(), WorldError> {
    let poses = arm
        .robot
        .link_poses(&arm.robot.with_arm_positions(&arm.home));
    // The base is skipped: it is mounted on something and cannot be pushed out of it.
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

/// Checks that no object of the cell overlaps another one or a fixture, and no arm an
/// obstacle. Parked objects and fixtures that are not solid block nothing.
pub(crate) fn check(cell: &Cell) -> Result<(), WorldError> {
    cell.arms.iter().try_for_each(|arm| check_arm(cell, arm))?;
    let objects = cell.objects.iter().enumerate();
    for (index, object) in objects.filter(|(_, object)| !object.parked) {
        // Each pair once: an object is compared with those before it, and with the fixtures.
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

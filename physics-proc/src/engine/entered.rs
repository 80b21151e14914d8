//! Links of arms that start inside a fixture that is not an obstacle, such as the legs of a
//! robot in the floor below its base. The engine cannot part them: the arm would be faulty
//! from the first ticks, or be held by the contact. They pass through each other instead.

use std::collections::BTreeMap;

use cell_model::{ArmSpec, Cell};
use rapier3d_f64::prelude::*;

use crate::arm::multibody::Arm;
use crate::engine::objects::Fixtures;
use crate::engine::shapes::overlap;
use crate::engine::spawn::RESTING_M;

/// Fixtures that some link starts inside of.
const ENTERED: Group = Group::GROUP_2;
/// Links that a warning names.
// A robot with many links in the floor would fill the log.
const NAMED: usize = 4;

/// A link of an arm inside a fixture, or that such a link carries: it may be beyond the fixture.
struct Entered {
    link: usize,
    fixture: usize,
    /// Depth (m); 0 if the link is beyond the fixture.
    depth: f64,
}

fn entered(cell: &Cell, arm: &ArmSpec) -> Vec<Entered> {
    let home = arm.robot.with_arm_positions(&arm.home);
    let poses = arm.robot.link_poses(&home);
    let mut found: Vec<Entered> = Vec::new();
    // The base does not move, so its contacts have no effect.
    for (link, (body, pose)) in arm.robot.links.iter().zip(&poses).enumerate().skip(1) {
        let fixtures = cell.fixtures.iter().enumerate();
        for (fixture, spec) in fixtures.filter(|(_, spec)| spec.solid && !spec.obstacle) {
            let depths = body.shapes.iter().map(|part| {
                let at = arm.base * pose * part.pose;
                overlap(&part.shape, &at, &spec.shape, &spec.pose)
            });
            let depth = depths.fold(0.0, f64::max);
            // A link behind one inside may be beyond the fixture: it would meet its other
            // side.
            let carrier = arm.robot.chain.joints()[link - 1].parent;
            let is_carried = carrier.is_some_and(|joint| {
                let mut known = found.iter();
                known.any(|one| one.link == joint + 1 && one.fixture == fixture)
            });
            if depth > RESTING_M || is_carried {
                found.push(Entered {
                    link,
                    fixture,
                    depth,
                });
            }
        }
    }
    found
}

/// Makes the links pass through the fixtures that they start inside of.
pub(crate) fn let_through(
    world: &mut PhysicsWorld,
    cell: &Cell,
    fixtures: &Fixtures,
    arms: &[Arm],
) {
    for (spec, arm) in cell.arms.iter().zip(arms) {
        // A link leaves out the whole group, so it also passes through fixtures that other
        // links start inside of; all else meets these fixtures as before.
        for Entered { link, fixture, .. } in entered(cell, spec) {
            let fixed = fixtures.colliders.get(fixture).copied().flatten();
            if let Some(collider) = fixed.and_then(|handle| world.colliders.get_mut(handle)) {
                let groups = InteractionGroups::all().with_memberships(ENTERED);
                collider.set_collision_groups(groups);
            }
            let body = arm
                .bodies
                .get(link)
                .and_then(|body| world.bodies.get(*body));
            for handle in body.map_or(&[][..], |body| body.colliders()) {
                if let Some(collider) = world.colliders.get_mut(*handle) {
                    let groups = InteractionGroups::all().with_filter(!ENTERED);
                    collider.set_collision_groups(groups);
                }
            }
        }
    }
}

/// Links and fixtures that pass through each other, a line for each arm and fixture.
pub(crate) fn warnings(cell: &Cell) -> Vec<String> {
    cell.arms.iter().flat_map(|arm| of_arm(cell, arm)).collect()
}

fn of_arm(cell: &Cell, arm: &ArmSpec) -> Vec<String> {
    let mut by_fixture: BTreeMap<usize, Vec<Entered>> = BTreeMap::new();
    // One sentence for each fixture, not for each link: a robot in the floor has many.
    for found in entered(cell, arm) {
        by_fixture.entry(found.fixture).or_default().push(found);
    }
    let words = |(fixture, links): (usize, Vec<Entered>)| {
        let deepest = links.iter().map(|found| found.depth).fold(0.0, f64::max);
        let names = links.iter().take(NAMED);
        let names: Vec<&str> = names
            .map(|found| arm.robot.links[found.link].name.as_str())
            .collect();
        let more = match links.len() - names.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        format!(
            "arm '{}' starts up to {:.0} mm inside fixture '{}' with {}{more}: they pass through \
             each other; raise the base of the arm where they have to touch",
            arm.name,
            1.0e3 * deepest,
            cell.fixtures[fixture].name,
            names.join(", "),
        )
    };
    by_fixture.into_iter().map(words).collect()
}

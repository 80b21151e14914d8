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

/// Most fixtures with a group of their own: the engine has 32 groups. Further ones share the
/// last group, and a link that starts inside of one of them passes through all of them.
const OWN_GROUPS: usize = 31;
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

/// The group of a fixture by its place among those that links start inside of.
fn group(place: usize) -> Group {
    Group::from_bits_retain(2 << place.min(OWN_GROUPS - 1))
}

/// Makes the links pass through the fixtures that they start inside of.
pub(crate) fn let_through(
    world: &mut PhysicsWorld,
    cell: &Cell,
    fixtures: &Fixtures,
    arms: &[Arm],
) {
    let mut known: Vec<usize> = Vec::new();
    for (spec, arm) in cell.arms.iter().zip(arms) {
        // A link leaves out the groups of its fixtures; all else, which is in all groups, meets
        // these fixtures as before.
        for Entered { link, fixture, .. } in entered(cell, spec) {
            let place = known.iter().position(|one| *one == fixture);
            let group = group(place.unwrap_or(known.len()));
            if place.is_none() {
                known.push(fixture);
            }
            let fixed = fixtures.colliders.get(fixture).copied().flatten();
            if let Some(collider) = fixed.and_then(|handle| world.colliders.get_mut(handle)) {
                let groups = InteractionGroups::all().with_memberships(group);
                collider.set_collision_groups(groups);
            }
            let body = arm
                .bodies()
                .get(link)
                .and_then(|body| world.bodies.get(*body));
            for handle in body.map_or(&[][..], |body| body.colliders()) {
                if let Some(collider) = world.colliders.get_mut(*handle) {
                    let filter = collider.collision_groups().filter & !group;
                    collider.set_collision_groups(InteractionGroups::all().with_filter(filter));
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
    let sentence = |(fixture, links): (usize, Vec<Entered>)| {
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
    by_fixture.into_iter().map(sentence).collect()
}

#[cfg(test)]
mod tests {
    use cell_model::{Data, FixtureSpec, Shape};

    use super::*;
    use crate::engine::{objects, settings};

    /// A link of each arm of the cell.
    const LINK: usize = 3;

    /// A block in the place of that link at the start.
    fn block(arm: &ArmSpec) -> FixtureSpec {
        let home = arm.robot.with_arm_positions(&arm.home);
        FixtureSpec {
            name: format!("block of {}", arm.name),
            shape: Shape::Box { size_m: [0.1; 3] },
            pose: arm.base * arm.robot.link_poses(&home)[LINK],
            friction: 0.5,
            solid: true,
            obstacle: false,
            colour: [0.5; 3],
        }
    }

    #[test]
    fn a_link_passes_through_the_fixture_it_starts_in_and_through_no_other() {
        let mut cell = Cell::load(&Data::checkout(), "franka-pyramid", 1, None).unwrap();
        let first = cell.fixtures.len();
        let blocks: Vec<FixtureSpec> = cell.arms.iter().map(block).collect();
        cell.fixtures.extend(blocks);
        let mut world = settings::empty_world();
        let fixtures = objects::insert_fixtures(&mut world, &cell);
        let arms = cell.arms.iter().enumerate();
        let arms: Vec<Arm> = arms
            .map(|(index, spec)| Arm::insert(&mut world, index, spec))
            .collect();
        let_through(&mut world, &cell, &fixtures, &arms);
        for (arm, inserted) in arms.iter().enumerate() {
            let link = world.bodies[inserted.bodies()[LINK]].colliders()[0];
            for fixture in 0..cell.fixtures.len() {
                let Some(fixed) = fixtures.colliders[fixture] else {
                    continue;
                };
                let groups = |handle: ColliderHandle| world.colliders[handle].collision_groups();
                let meets = groups(link).test(groups(fixed));
                let name = &cell.fixtures[fixture].name;
                assert_eq!(meets, fixture != first + arm, "arm {arm}, {name}");
            }
        }
    }
}

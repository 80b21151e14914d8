//! The observed cubes, and the places for them.

use behavior::value::Set;
use nalgebra::Vector3;
use robocell_skills::World;
use robocell_skills::fingers::Ways;
use robocell_task::job::Placement;

use super::setup::Pyramid;

/// Two cubes of one layer whose centres are nearer than this many cube edges leave no room for
/// fingers between them.
const CROWDED_EDGES: f64 = 1.6;
/// A place with no cube nearer than this many cube edges is clear.
const CLEAR_EDGES: f64 = 2.2;
/// A cube nearer to a TCP than the start of a pick-up and this many cube edges may be about to
/// be gripped.
const AT_GRIPPER_EDGES: f64 = 0.4;
/// Candidates for a clear place, relative to the stack (cube edges): there has to be more room
/// in the direction in which the fingers close than across it.
const BESIDE_EDGES: [[f64; 2]; 8] = [
    [2.8, 0.0],
    [0.0, -2.4],
    [0.0, 2.4],
    [-2.4, 0.0],
    [2.8, -2.4],
    [2.8, 2.4],
    [-2.4, -2.4],
    [-2.4, 2.4],
];
/// Nearer to its base than this the arm folds up and gets stuck (m).
const TOO_NEAR_M: f64 = 0.32;

/// The cell as one arm sees it in one decision.
#[derive(Clone, Copy)]
pub(super) struct Look<'a, 'w> {
    pub(super) job: &'a Pyramid,
    pub(super) world: &'a World<'w>,
}

/// Where a cube will be placed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Goal {
    /// Its centre, and the turn of the arm's tool (rad).
    pub(super) place: Placement,
    /// Whether it is put out of the way.
    pub(super) aside: bool,
}

impl Look<'_, '_> {
    fn edge(&self) -> f64 {
        self.job.task.layer_height_m
    }

    /// Observed cubes other than `but`, with their centres (m).
    fn others(&self, but: usize) -> impl Iterator<Item = (usize, Vector3<f64>)> {
        let others = self.job.cubes.iter().filter(move |cube| **cube != but);
        others.filter_map(|cube| Some((*cube, self.world.position(*cube)?)))
    }

    /// The two grasps across a cube.
    pub(super) fn ways(&self, cube: usize) -> Option<Ways> {
        let seen = self.world.placement(cube)?;
        let yaw = self.goal(cube, 0)?.yaw;
        Some(Ways::around(cube, seen, yaw, self.world))
    }

    /// Whether fingers meet no neighbours in one of the grasps of a cube.
    pub(super) fn is_free_around(&self, cube: usize) -> bool {
        self.ways(cube).is_some_and(|ways| ways.is_free())
    }

    /// Whether the gripper of another arm is at a point (m): an arm that stopped in the middle
    /// of a pick-up may still close it.
    pub(super) fn is_at_another_gripper(&self, point: Vector3<f64>) -> bool {
        let near = self.job.task.approach_m + AT_GRIPPER_EDGES * self.edge();
        self.world.is_another_near(point, near)
    }

    /// The pose of a cube in a layer of the arm's stack.
    pub(super) fn goal(&self, cube: usize, layer: usize) -> Option<Placement> {
        self.world.goal(cube, self.world.arm, layer)
    }

    /// Whether a cube that is not part of `stack` is at the place of the arm's stack, or so
    /// near that the fingers would meet it.
    pub(super) fn is_in_the_way(&self, stack: Set, cube: usize) -> bool {
        let (Some(position), Some(goal)) = (self.world.position(cube), self.goal(cube, 0)) else {
            return false;
        };
        let off = position - Vector3::from(goal.position);
        !stack.contains(self.job.item(cube))
            && off.xy().norm() < CROWDED_EDGES * self.edge()
            // A cube in a gripper is on its way, and will not stay there.
            && !self.world.is_held(cube)
    }

    /// The cubes of `among` in the arm's stack, from the table up without a gap.
    pub(super) fn stack(&self, among: Set) -> Set {
        let (arm, tolerance) = (self.world.arm, self.job.task.goal_tolerance_m);
        let in_layer = |layer| {
            let mut cubes = self.job.items();
            let found = cubes.find(|(item, cube)| {
                among.contains(*item) && self.world.slot_of(*cube, arm, tolerance) == Some(layer)
            });
            found.map(|(item, _)| item)
        };
        (0..self.job.cubes.len())
            // Ends at the first gap: a cube above it does not rest on the stack.
            .map_while(in_layer)
            .fold(Set::default(), Set::with)
    }

    /// The goal of `cube`: onto the arm's `stack`, or, while other cubes are in the way of
    /// that, a clear place beside it.
    pub(super) fn goal_of(&self, stack: Set, cube: usize) -> Option<Goal> {
        let on_stack = Goal {
            place: self.goal(cube, stack.len() as usize)?,
            aside: false,
        };
        let mut others = self.others(cube);
        if !others.any(|(other, _)| self.is_in_the_way(stack, other)) {
            return Some(on_stack);
        }
        let table = self.goal(cube, 0)?;
        let beside = |[dx, dy]: &[f64; 2]| {
            let [x, y, z] = table.position;
            Vector3::new(x + dx * self.edge(), y + dy * self.edge(), z)
        };
        // A place that other arms reach, too, is preferred: they may need the cube.
        let places = || {
            BESIDE_EDGES
                .iter()
                .map(beside)
                .filter(|p| self.is_clear(*p, cube))
        };
        let place = places()
            .find(|place| self.world.is_reached_by_another(*place))
            .or_else(|| places().next());
        // Without a clear place the cube goes onto the stack after all; keeping it would stop
        // both arms.
        Some(place.map_or(on_stack, |place| Goal {
            place: Placement {
                position: place.into(),
                ..table
            },
            aside: true,
        }))
    }

    /// Whether a place on the table is within reach and without a cube near it.
    fn is_clear(&self, place: Vector3<f64>, but: usize) -> bool {
        let room = CLEAR_EDGES * self.edge();
        let base = self.world.arm_setup().map_or(place, |arm| arm.base);
        self.others(but)
            .all(|(_, its)| (its - place).xy().norm() > room)
            && self.world.reaches(place)
            && (place - base).xy().norm() > TOO_NEAR_M
    }
}

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
/// Share of the tolerance within which a cube is in place that carries another one.
const CARRYING_SHARE: f64 = 0.5;
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

    /// Whether the arm can fetch a cube at a position (m).
    pub(super) fn reaches(&self, position: Vector3<f64>) -> bool {
        self.is_fetched_by(self.world.arm, position)
    }

    /// Whether an arm can fetch a cube at a position (m): one within its reach, or one that no
    /// other arm has in reach and that it gets to when it is stretched.
    fn is_fetched_by(&self, arm: usize, position: Vector3<f64>) -> bool {
        let arms = || self.world.setup.arms.iter().enumerate();
        let Some((_, setup)) = arms().find(|(index, _)| *index == arm) else {
            return false;
        };
        let task = &self.job.task;
        let stretched = task.stretched_reach_m.unwrap_or(task.reach_m);
        let mut others = arms().filter(|(index, _)| *index != arm);
        setup.reaches(position)
            || setup.is_within(position, stretched)
                && !others.any(|(_, other)| other.reaches(position))
    }

    /// Whether the arm's stack is whole, so that it fetches cubes for others only.
    pub(super) fn is_whole(&self) -> bool {
        self.is_whole_without(None)
    }

    /// The same, as if `cube` were elsewhere.
    fn is_whole_without(&self, cube: Option<usize>) -> bool {
        self.layers(self.world.arm, cube) == self.job.task.required_count as usize
    }

    /// Whether the arm has to bring a cube for another arm, now that its own stack is whole: one
    /// that it has to fetch, or that is in its gripper.
    pub(super) fn helps(&self) -> bool {
        let cubes = &self.job.cubes;
        let holds = self.world.held().is_some_and(|held| cubes.contains(&held));
        self.is_whole() && (holds || cubes.iter().any(|cube| self.is_for_another(*cube)))
    }

    /// Whether only this arm can fetch a cube, and another arm needs it: it can fetch fewer free
    /// cubes than its stack lacks. There has to be a place where this arm can hand it over.
    pub(super) fn is_for_another(&self, cube: usize) -> bool {
        let is_mine = |position: &Vector3<f64>| self.reaches(*position);
        let Some(position) = self.loose_at(cube).filter(is_mine) else {
            return false;
        };
        let needs = |arm: usize| {
            let loose = self
                .job
                .cubes
                .iter()
                .filter_map(|cube| self.loose_at(*cube));
            let fetched = loose.filter(|position| self.is_fetched_by(arm, *position));
            let lacks = self.job.task.required_count as usize - self.layers(arm, None);
            !self.is_fetched_by(arm, position) && fetched.count() < lacks
        };
        let arms = self.world.setup.arms.iter().enumerate();
        let mut others = arms.filter(|(index, arm)| *index != self.world.arm && !arm.is_absent);
        others.any(|(arm, _)| needs(arm)) && self.handover_place(cube).is_some()
    }

    /// The position of a cube that is in no stack and in no gripper (m).
    fn loose_at(&self, cube: usize) -> Option<Vector3<f64>> {
        let is_loose = self.is_loose(cube) && !self.world.is_held(cube);
        self.world.position(cube).filter(|_| is_loose)
    }

    /// A clear place beside the arm's own stack that another arm reaches, too (m): the zone of the
    /// centre is not needed to put a cube there.
    fn handover_place(&self, cube: usize) -> Option<Vector3<f64>> {
        let stack = self.goal(cube, 0)?.position.into();
        let is_shared = |place: &Vector3<f64>| self.world.is_reached_by_another(*place);
        let mut places = self.beside(stack).filter(|p| self.is_clear(*p, cube));
        places.find(is_shared)
    }

    /// Places around a stack (m).
    fn beside(&self, stack: Vector3<f64>) -> impl Iterator<Item = Vector3<f64>> {
        let edge = self.edge();
        BESIDE_EDGES
            .iter()
            .map(move |[dx, dy]| stack + Vector3::new(dx * edge, dy * edge, 0.0))
    }

    /// Whether a cube is in no stack.
    fn is_loose(&self, cube: usize) -> bool {
        let mut arms = 0..self.world.setup.arms.len();
        !arms.any(|arm| self.layer_of(cube, arm).is_some())
    }

    /// The layer of an arm's stack that a cube is in. Below another layer it has to be nearer to
    /// its goal: one that is half an edge off does not carry the next cube.
    fn layer_of(&self, cube: usize, arm: usize) -> Option<usize> {
        let slot_within = |tolerance| self.world.slot_of(cube, arm, tolerance);
        let layer = slot_within(self.job.task.goal_tolerance_m)?;
        slot_within(self.tolerance(layer))
    }

    /// A cube nearer than this to its goal in a layer is in place (m).
    pub(super) fn tolerance(&self, layer: usize) -> f64 {
        let task = &self.job.task;
        let carries = layer + 1 < task.required_count as usize;
        task.goal_tolerance_m * if carries { CARRYING_SHARE } else { 1.0 }
    }

    /// Layers of an arm's stack without a cube, from the table up without a gap, and no more than
    /// it needs.
    fn layers(&self, arm: usize, without: Option<usize>) -> usize {
        let is_filled = |layer: &usize| {
            let mut cubes = self.job.cubes.iter().filter(|cube| Some(**cube) != without);
            cubes.any(|cube| self.layer_of(*cube, arm) == Some(*layer))
        };
        let needed = 0..self.job.task.required_count as usize;
        needed.take_while(is_filled).count()
    }

    /// The highest cube of the arm's `stack`, while it covers a cube beside the stack that is in the
    /// way of the next one.
    pub(super) fn top_over_obstacle(&self, stack: Set) -> Option<usize> {
        let top = stack.len().checked_sub(1)? as usize;
        let is_top = |cube: &usize| {
            stack.contains(self.job.item(*cube))
                && self.layer_of(*cube, self.world.arm) == Some(top)
        };
        let top = self.job.cubes.iter().copied().find(is_top)?;
        let above = self.world.position(top)?;
        let is_blocked = |cube: &usize| {
            let off = self.world.position(*cube).map(|position| position - above);
            let is_below = off.is_some_and(|off| off.z < 0.0 && off.xy().amax() < self.edge());
            is_below && self.is_in_the_way(stack, *cube) && self.world.is_covered(*cube)
        };
        self.job.cubes.iter().any(is_blocked).then_some(top)
    }

    /// The cubes of `among` in the arm's stack, from the table up without a gap.
    pub(super) fn stack(&self, among: Set) -> Set {
        let in_layer = |layer| {
            let mut cubes = self.job.items();
            let found = cubes.find(|(item, cube)| {
                among.contains(*item) && self.layer_of(*cube, self.world.arm) == Some(layer)
            });
            found.map(|(item, _)| item)
        };
        (0..self.job.cubes.len())
            // Ends at the first gap: a cube above it does not rest on the stack.
            .map_while(in_layer)
            .fold(Set::default(), Set::with)
    }

    /// The goal of `cube`: onto the arm's `stack`, or, while other cubes are in the way of
    /// that or the stack is whole, a clear place beside it.
    pub(super) fn goal_of(&self, stack: Set, cube: usize) -> Option<Goal> {
        let on_stack = Goal {
            place: self.goal(cube, stack.len() as usize)?,
            aside: false,
        };
        let mut others = self.others(cube);
        let is_blocked = others.any(|(other, _)| self.is_in_the_way(stack, other));
        let table = self.goal(cube, 0)?;
        let aside = |place: Vector3<f64>| Goal {
            place: Placement {
                position: place.into(),
                ..table
            },
            aside: true,
        };
        if self.is_whole_without(Some(cube)) {
            // A cube in the gripper has to be put down anywhere.
            let stack = Vector3::from(table.position);
            let clear = || self.beside(stack).find(|place| self.is_clear(*place, cube));
            return self.handover_place(cube).or_else(clear).map(aside);
        }
        if !is_blocked {
            return Some(on_stack);
        }
        // A place that other arms reach, too, is preferred: they may need the cube.
        let places = || {
            self.beside(table.position.into())
                .filter(|place| self.is_clear(*place, cube))
        };
        let place = places()
            .find(|place| self.world.is_reached_by_another(*place))
            .or_else(|| places().next());
        // Without a clear place the cube goes onto the stack after all; keeping it would stop
        // both arms.
        Some(place.map_or(on_stack, aside))
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

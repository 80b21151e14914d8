//! What the arms believe about the cubes, and what is seen of them.

use behavior::Str;
use behavior::board::{Access, Fault, Out};
use behavior::tree::{BindError, Binder};
use behavior::value::Set;
use nalgebra::Vector3;

use super::host::{Context, World};
use super::keys;
use super::setup::{ArmSetup, PyramidSetup};

/// Of a cube nobody works at.
const AVAILABLE: &str = "available";
/// Two cubes of one layer with centres nearer than this many cube edges leave
/// no room for fingers between them.
const CROWDED_EDGES: f64 = 1.6;
/// A place with no cube nearer than this many cube edges is clear.
const CLEAR_EDGES: f64 = 2.2;
/// A cube nearer to a TCP than the start of a pick-up and this many cube edges
/// may be about to be taken.
const AT_HAND_EDGES: f64 = 0.4;
/// A cube nearer than this many edges in the plane, and higher, lies on another.
const ON_TOP_EDGES: f64 = 0.9;

/// A node's hold of the keys about cubes: what happens to each, which are
/// placed, and which is the tree's own.
#[derive(Clone, Debug)]
pub(super) struct Cubes {
    me: Str,
    available: Str,
    reserved: Str,
    carried: Str,
    placed_word: Str,
    states: Vec<Out<Str>>,
    placed: Out<Set>,
    current: Out<Str>,
}

/// What this arm has to do with a cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CubeState {
    Available,
    Reserved,
    Carried,
    Placed,
    /// It is another arm's.
    Others,
}

impl Cubes {
    pub(super) fn bind(setup: &PyramidSetup, binder: &mut Binder<'_>) -> Result<Self, BindError> {
        let me = keys::robot(binder)?;
        let word = |word: &str| Str::new(&format!("{word}:{me}")).unwrap_or_default();
        let available = Str::new(AVAILABLE).unwrap_or_default();
        let mut states = Vec::new();
        for cube in &setup.cubes {
            let key = keys::cube_state(cube.name.as_str());
            states.push(keys::shared(binder, &key, available, Access::Write)?);
        }
        Ok(Self {
            me,
            available,
            reserved: word("reserved"),
            carried: word("carried"),
            placed_word: word("placed"),
            states,
            placed: keys::placed_set(binder)?,
            current: keys::local(binder, keys::CURRENT_CUBE, Some(Str::EMPTY), Access::Write)?,
        })
    }

    /// Name of the arm.
    pub(super) fn me(&self) -> Str {
        self.me
    }

    /// The cube the tree works at.
    pub(super) fn current(&self, cx: &Context<'_, '_>) -> Result<Option<usize>, Fault> {
        let name = cx.read(&self.current)?;
        Ok(cx.world.setup.cube_named(name.as_str()))
    }

    pub(super) fn set_current(
        &self,
        cx: &mut Context<'_, '_>,
        cube: Option<usize>,
    ) -> Result<(), Fault> {
        let name = cube.map_or(Str::EMPTY, |c| cx.world.setup.cube_name(c));
        cx.set(&self.current, name)
    }

    pub(super) fn state(&self, cx: &Context<'_, '_>, cube: usize) -> Result<CubeState, Fault> {
        let Some(key) = self.states.get(cube) else {
            return Ok(CubeState::Others);
        };
        let word = cx.read(key)?;
        Ok(if word == self.available {
            CubeState::Available
        } else if word == self.reserved {
            CubeState::Reserved
        } else if word == self.carried {
            CubeState::Carried
        } else if word == self.placed_word {
            CubeState::Placed
        } else {
            CubeState::Others
        })
    }

    pub(super) fn set_state(
        &self,
        cx: &mut Context<'_, '_>,
        cube: usize,
        state: CubeState,
    ) -> Result<(), Fault> {
        let word = match state {
            CubeState::Available => self.available,
            CubeState::Reserved => self.reserved,
            CubeState::Carried => self.carried,
            CubeState::Placed => self.placed_word,
            CubeState::Others => return Ok(()),
        };
        match self.states.get(cube) {
            Some(key) => cx.set(key, word),
            None => Ok(()),
        }
    }

    /// The arm's placed cubes as last compared.
    pub(super) fn placed(&self, cx: &Context<'_, '_>) -> Result<Set, Fault> {
        cx.read(&self.placed)
    }

    /// Adds a cube to the arm's stack; once more changes nothing.
    pub(super) fn mark_placed(&self, cx: &mut Context<'_, '_>, cube: usize) -> Result<Set, Fault> {
        let set = self.placed(cx)?.with(number(cube));
        cx.set(&self.placed, set)?;
        self.set_state(cx, cube, CubeState::Placed)?;
        Ok(set)
    }

    /// Compares the arm's stack with what is seen: cubes that left it are there
    /// to be taken again, cubes that stand in it and are nobody's are part of
    /// it. Gives the stack.
    pub(super) fn compare(&self, cx: &mut Context<'_, '_>) -> Result<Set, Fault> {
        let before = self.placed(cx)?;
        let mut mine = Set::default();
        for cube in 0..self.states.len() {
            let state = self.state(cx, cube)?;
            if matches!(state, CubeState::Placed | CubeState::Available) {
                mine = mine.with(number(cube));
            }
        }
        let seen = match cx.world.arm_setup() {
            Some(arm) => stack(cx.world, arm, mine),
            None => before,
        };
        for cube in 0..self.states.len() {
            let (was, is) = (before.contains(number(cube)), seen.contains(number(cube)));
            let state = if is {
                CubeState::Placed
            } else {
                CubeState::Available
            };
            if was != is {
                self.set_state(cx, cube, state)?;
                let (arm, name) = (cx.world.name(), cx.world.setup.cube_name(cube));
                let verb = if is { "stands in" } else { "left" };
                cx.world
                    .out
                    .log(format_args!("[stack] {arm}: {name} {verb} the stack"));
            }
        }
        cx.set(&self.placed, seen)?;
        Ok(seen)
    }
}

/// The cubes of `among` that stand in the stack of `arm`, from the table up
/// without a gap.
pub(super) fn stack(world: &World<'_>, arm: &ArmSetup, among: Set) -> Set {
    let mut found = Set::default();
    for layer in 0..number(world.setup.cubes.len()) {
        let goal = world.setup.goal(arm, layer);
        let stands = |cube: &u32| {
            let index = *cube as usize;
            !world.is_held(index) && is_at(world, index, goal)
        };
        match among.items().find(stands) {
            Some(cube) => found = found.with(cube),
            None => break,
        }
    }
    found
}

/// Whether a cube is at `goal`, in its own layer (m).
pub(super) fn is_at(world: &World<'_>, cube: usize, goal: Vector3<f64>) -> bool {
    let numbers = &world.setup.numbers;
    world.cube_position(cube).is_some_and(|position| {
        let offset = position - goal;
        offset.xy().norm() < numbers.goal_tolerance_m
            && offset.z.abs() < 0.5 * numbers.layer_height_m
    })
}

/// Whether nothing lies on a cube.
pub(super) fn is_free_on_top(world: &World<'_>, cube: usize) -> bool {
    let edge = world.setup.numbers.layer_height_m;
    let Some(position) = world.cube_position(cube) else {
        return false;
    };
    let lies_on_it = |other: usize| {
        let offset = world.cube_position(other).map(|p| p - position);
        offset.is_some_and(|o| {
            o.z > 0.3 * edge && o.z < 1.5 * edge && o.xy().norm() < ON_TOP_EDGES * edge
        })
    };
    (0..world.setup.cubes.len())
        .filter(|other| *other != cube && !world.is_held(*other))
        .all(|other| !lies_on_it(other))
}

/// Whether the arm reaches a place (m).
pub(super) fn is_reachable(world: &World<'_>, position: Vector3<f64>) -> bool {
    let reach = world.setup.numbers.reach_m;
    world
        .arm_setup()
        .is_some_and(|arm| (position.xy() - arm.base).norm() <= reach)
}

/// Whether the hand of another arm is at a place (m): an arm that stopped in
/// the middle of a pick-up may still close it.
pub(super) fn is_at_another_hand(world: &World<'_>, position: Vector3<f64>) -> bool {
    let numbers = &world.setup.numbers;
    let near = numbers.approach_m + AT_HAND_EDGES * numbers.layer_height_m;
    (0..world.setup.arms.len())
        .filter(|arm| *arm != world.arm)
        .filter_map(|arm| world.observation.tcp(arm))
        .any(|tcp| (Vector3::from(tcp.position) - position).norm() < near)
}

/// Whether an arm other than this one reaches a place (m).
pub(super) fn is_reachable_by_others(world: &World<'_>, position: Vector3<f64>) -> bool {
    let reach = world.setup.numbers.reach_m;
    let arms = world.setup.arms.iter().enumerate();
    arms.filter(|(arm, _)| *arm != world.arm)
        .any(|(_, arm)| (position.xy() - arm.base).norm() <= reach)
}

/// Whether a cube that is not part of `stack` stands where the stack of `arm`
/// goes on, or so near that the fingers would meet it.
pub(super) fn is_in_the_way(world: &World<'_>, arm: &ArmSetup, stack: Set, cube: usize) -> bool {
    let room = CROWDED_EDGES * world.setup.numbers.layer_height_m;
    !stack.contains(number(cube))
        && !world.is_held(cube)
        && world
            .cube_position(cube)
            .is_some_and(|p| (p.xy() - arm.goal).norm() < room)
}

/// Whether nothing is near a place on the table.
pub(super) fn is_clear(world: &World<'_>, place: Vector3<f64>, but: usize) -> bool {
    let room = CLEAR_EDGES * world.setup.numbers.layer_height_m;
    (0..world.setup.cubes.len())
        .filter(|cube| *cube != but)
        .filter_map(|cube| world.cube_position(cube))
        .all(|position| (position.xy() - place.xy()).norm() > room)
}

/// A cube as an item of a set.
pub(super) fn number(cube: usize) -> u32 {
    u32::try_from(cube).unwrap_or(u32::MAX)
}

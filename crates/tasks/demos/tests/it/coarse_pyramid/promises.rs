//! Promises that have to hold after every decision.

use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::{ArmGoal, Decision, GripperGoal};

use super::choice::ARMS;
use super::spy::{Seen, Word};
use super::world::{CUBE_M, World};

/// Stacks of the cell file (m).
const GOALS: [[f64; 2]; ARMS] = [[0.46, -0.28], [0.46, 0.28]];
/// The centre (m): half of its size around the pyramid.
const CENTER: [f64; 2] = [0.46, 0.0];
const CENTER_HALF: [f64; 2] = [0.10, 0.12];
/// A lease (ticks).
const LEASE_TICKS: u64 = 500;

/// One decision, with the situation before it.
pub(crate) struct Moment<'a> {
    pub(crate) world: &'a World,
    pub(crate) before: &'a Decision,
    pub(crate) decision: &'a Decision,
    pub(crate) seen: &'a Seen,
    /// Name of the leaf each arm is at.
    pub(crate) leaf: [&'a str; ARMS],
}

impl Moment<'_> {
    /// The broken promise, if there is one.
    pub(crate) fn wrong(&self) -> Option<String> {
        (0..ARMS)
            .find_map(|arm| self.lets_go(arm).or_else(|| self.meets(arm)))
            .or_else(|| self.is_blocked())
            .or_else(|| self.disagrees())
    }

    fn goal(&self, arm: usize) -> &ArmGoal {
        &self.decision.goals[arm]
    }

    /// A held cube is released on purpose only.
    fn lets_go(&self, arm: usize) -> Option<String> {
        let cube = self.world.held[arm]?;
        if self.goal(arm).gripper != GripperGoal::Open.code() {
            return None;
        }
        let on_purpose = match self.leaf[arm] {
            "release" => self.is_over_goal(arm, cube),
            // Where it rests nothing falls: the other arm may give it up in the same decision.
            "recover" => self.is_others(arm, cube) || self.rests(cube),
            _ if self.is_operators() => true,
            _ => self.decision.drops > self.before.drops,
        };
        (!on_purpose).then(|| format!("arm {arm} opens its hand around cube {cube}"))
    }

    fn is_operators(&self) -> bool {
        self.decision.outcome == Outcome::Paused.code()
    }

    /// On the board a cube belongs to the other arm.
    fn is_others(&self, arm: usize, cube: usize) -> bool {
        match self.seen.words[cube] {
            Word::Reserved(a) | Word::Carried(a) | Word::Placed(a) => a != arm,
            Word::Available => false,
        }
    }

    /// A cube that is held on the table.
    fn rests(&self, cube: usize) -> bool {
        let [_, _, z] = self.world.position(cube);
        (z - 0.5 * CUBE_M).abs() < 1.0e-3
    }

    /// It goes into the stack, or beside it, out of the way. Its support may have been pulled
    /// away in the last moment: then it falls by one layer.
    fn is_over_goal(&self, arm: usize, cube: usize) -> bool {
        let [x, y, _] = self.world.position(cube);
        let away = (x - GOALS[arm][0]).hypot(y - GOALS[arm][1]);
        away < 0.025 || (0.1..0.2).contains(&away)
    }

    /// An arm is sent into the centre while it is the other's.
    fn meets(&self, arm: usize) -> Option<String> {
        let other = 1 - arm;
        let barred = self.seen.owner == Some(other) && self.leads_into_center(arm);
        let both = self.leads_into_center(arm) && self.leads_into_center(other);
        (barred || both).then(|| format!("arm {arm} is sent into the centre, both: {both}"))
    }

    fn leads_into_center(&self, arm: usize) -> bool {
        let goal = self.goal(arm);
        let place = goal.target.position;
        goal.kind == GoalKind::Pose.code()
            && (0..2).all(|axis| (place[axis] - CENTER[axis]).abs() < CENTER_HALF[axis])
    }

    /// The dead own nothing.
    fn is_blocked(&self) -> Option<String> {
        let owner = self.seen.owner?;
        (self.world.silence[owner] >= LEASE_TICKS)
            .then(|| format!("arm {owner} is silent and owns the centre"))
    }

    /// Each cube belongs to one arm, and its keys on the board agree.
    fn disagrees(&self) -> Option<String> {
        let seen = self.seen;
        if seen.placed[0] & seen.placed[1] != 0 {
            return Some("a cube is in both stacks".to_owned());
        }
        for arm in 0..ARMS {
            let works =
                |word: &&Word| matches!(word, Word::Reserved(a) | Word::Carried(a) if *a == arm);
            if seen.words.iter().filter(works).count() > 1 {
                return Some(format!("arm {arm} has two cubes"));
            }
            // A cube that fell between closing fingers is released again.
            let lets_go = matches!(self.leaf[arm], "grasp" | "recover");
            if self.world.held[arm].is_some_and(|cube| self.is_others(arm, cube)) && !lets_go {
                return Some(format!("arm {arm} holds the other's cube"));
            }
            let placed = |cube: usize| seen.placed[arm] & (1 << cube) != 0;
            let said = |cube: usize| seen.words[cube] == Word::Placed(arm);
            if (0..seen.words.len()).any(|cube| placed(cube) != said(cube)) {
                return Some(format!("the stack of arm {arm} is not what its cubes say"));
            }
        }
        None
    }
}

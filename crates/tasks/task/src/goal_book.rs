//! The goals of the previous decision: new feedback is graded against them, and the
//! number of the next goal continues from them.

use ipc_types::{ArmGoal, GripperGoal, MAX_ARMS, Pose, decision::GoalKind};
use serde::{Deserialize, Serialize};

/// The identity of a goal: its kind, and a key that its author chose.
type Identity = (u32, u64);

/// Upper limit of a goal number in a checkpoint that is accepted.
// One new goal per decision reaches it after more than a billion years, so a larger number
// is damage; and adding 1 to it cannot overflow.
const MOST_GOALS: u64 = 1 << 62;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Entry {
    goal_id: u64,
    identity: Option<Identity>,
    position: [f64; 3],
    orientation_wxyz: [f64; 4],
    gripper: u32,
    open_width: f64,
}

/// The goals of all arms as published with the previous decision.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GoalBook {
    entries: [Entry; MAX_ARMS],
}

/// One arm's goal of the previous decision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviousGoal {
    /// Its number.
    pub goal_id: u64,
    /// The key its author gave it.
    pub key: u64,
    /// What the goal commanded.
    pub kind: GoalKind,
    /// TCP target in the world frame.
    pub target: Pose,
    /// The gripper command that was sent with it.
    pub gripper: GripperGoal,
    /// Distance of the fingers when they opened last (m); 0 for as far as they open.
    pub open_width: f64,
}

impl Default for GoalBook {
    fn default() -> Self {
        let pose = Pose::IDENTITY;
        let entry = Entry {
            goal_id: 0,
            identity: None,
            position: pose.position,
            orientation_wxyz: pose.orientation_wxyz,
            gripper: GripperGoal::Keep.code(),
            open_width: 0.0,
        };
        Self {
            entries: [entry.clone(), entry],
        }
    }
}

impl GoalBook {
    /// The goal `arm` was given with the previous decision; `None` before the
    /// first one and after `forget`.
    pub fn previous(&self, arm: usize) -> Option<PreviousGoal> {
        // `None` after a restart of the scene: feedback about a goal of the scene before must
        // not grade a goal of this one.
        let entry = self.entries.get(arm)?;
        let (kind, key) = entry.identity?;
        Some(PreviousGoal {
            goal_id: entry.goal_id,
            key,
            kind: GoalKind::from_code(kind)?,
            target: Pose {
                position: entry.position,
                orientation_wxyz: entry.orientation_wxyz,
            },
            gripper: GripperGoal::from_code(entry.gripper)?,
            open_width: entry.open_width,
        })
    }

    /// Numbers `goal`: a new kind or `key` is a new goal, the same ones are the
    /// same goal, with its target moved at most.
    pub(crate) fn publish(&mut self, arm: usize, key: u64, goal: &mut ArmGoal) {
        let Some(entry) = self.entries.get_mut(arm) else {
            return;
        };
        // The kind is part of the identity: a pose and a joint goal with the same key are
        // different motions, and the controller has to leave the first one.
        let identity = Some((goal.kind, key));
        if entry.identity != identity {
            entry.identity = identity;
            entry.goal_id += 1;
        }
        entry.position = goal.target.position;
        entry.orientation_wxyz = goal.target.orientation_wxyz;
        entry.gripper = goal.gripper;
        if goal.gripper != GripperGoal::Keep.code() {
            entry.open_width = goal.open_width;
        }
        goal.goal_id = entry.goal_id;
    }

    /// Whether a restored book can continue counting.
    pub(crate) fn is_sound(&self) -> bool {
        self.entries.iter().all(|entry| entry.goal_id < MOST_GOALS)
    }

    /// Makes the next goal of every arm a new one; numbers continue counting.
    pub(crate) fn forget(&mut self) {
        // Only the identity is cleared. With numbers from 1 again, a controller could take a
        // new goal for the one that it has latched.
        for entry in &mut self.entries {
            entry.identity = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

    fn published(book: &mut GoalBook, kind: GoalKind, key: u64) -> u64 {
        let mut goal = ArmGoal {
            kind: kind.code(),
            target: Pose::IDENTITY,
            ..ArmGoal::zeroed()
        };
        book.publish(0, key, &mut goal);
        goal.goal_id
    }

    #[test]
    fn a_goal_keeps_its_number_until_its_kind_or_key_changes() {
        let mut book = GoalBook::default();
        assert_eq!(book.previous(0), None);
        assert_eq!(published(&mut book, GoalKind::Pose, 7), 1);
        assert_eq!(published(&mut book, GoalKind::Pose, 7), 1);
        assert_eq!(published(&mut book, GoalKind::Pose, 8), 2);
        assert_eq!(published(&mut book, GoalKind::Hold, 8), 3);
        book.forget();
        assert_eq!(book.previous(0), None);
        assert_eq!(published(&mut book, GoalKind::Hold, 8), 4);
    }
}

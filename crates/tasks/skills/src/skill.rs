//! The interface of a skill, and a skill as a leaf of a tree.

use behavior::Status;
use behavior::board::Fault;
use behavior::tree::{Cx, Host, Leaf};

use crate::condition::Condition;
use crate::progress::Progress;
use crate::world::World;

/// An ability of an arm. Its whole memory is a [`Progress`].
pub trait Skill: Send + 'static {
    /// One decision of work. It starts with `Progress::default()`.
    fn step(&self, progress: &mut Progress, world: &mut World<'_>) -> Status;
}

/// The host of trees whose leaves are skills.
pub struct Station;

impl Host for Station {
    type World<'w> = World<'w>;
}

/// A skill as a leaf of a tree in code.
pub struct SkillLeaf<S>(pub S);

impl<S: Skill> Leaf<Station> for SkillLeaf<S> {
    type State = Progress;

    fn start(&self, state: &mut Progress, _cx: &mut Cx<'_, '_, Station>) -> Result<(), Fault> {
        state.reset();
        Ok(())
    }

    fn tick(&self, state: &mut Progress, cx: &mut Cx<'_, '_, Station>) -> Result<Status, Fault> {
        Ok(self.0.step(state, cx.world))
    }
}

impl Leaf<Station> for Condition {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Cx<'_, '_, Station>) -> Result<Status, Fault> {
        Ok(if self.holds(cx.world) {
            Status::Success
        } else {
            Status::Failure
        })
    }
}

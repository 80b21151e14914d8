//! The tree: 27 nodes, recovery to the left of the normal flow.

use std::collections::BTreeMap;

use behavior::board::Board;
use behavior::tree::{BindError, Binder, Leaf, Memory, Node};

use super::keys::{self, Keys};
use super::leaves::{
    AllStacked, ClearHolding, CubeDropped, MarkHolding, SelectNextCube, StackBelowBroken,
};
use super::phase_leaf::{Flavour, PhaseLeaf};
use super::world::StackHost;
use crate::stack::Phase;

type Part = Node<StackHost>;
type Branch = Result<Part, BindError>;

/// Builds the tree on a board of its own.
///
/// # Errors
/// [`BindError`] where a leaf uses a key it may not, which is a mistake in here.
pub fn tree(holds_until_retracted: bool) -> Result<(Part, Board), BindError> {
    let board = keys::board().map_err(|source| BindError::Board {
        port: "blackboard".to_owned(),
        source: Box::new(source),
    })?;
    let mut planter = Planter {
        local: board,
        shared: Board::new(),
        holds_until_retracted,
    };
    let root = planter.root()?;
    Ok((root, planter.local))
}

struct Planter {
    local: Board,
    shared: Board,
    holds_until_retracted: bool,
}

impl Planter {
    fn root(&mut self) -> Branch {
        let branches = vec![
            self.leaf("AllStacked", AllStacked::new)?,
            self.drop_recovery()?,
            self.stack_recovery()?,
            self.normal()?,
        ];
        Ok(Node::selector("Root", Memory::No, branches))
    }

    fn drop_recovery(&mut self) -> Branch {
        let steps = vec![
            self.leaf("CubeDropped", CubeDropped::new)?,
            self.leaf("ClearDropped", ClearHolding::dropped)?,
        ];
        Ok(Node::sequence("DropRecovery", Memory::Yes, steps))
    }

    fn stack_recovery(&mut self) -> Branch {
        let back = Flavour {
            spawn: true,
            ..Flavour::default()
        };
        let mut steps = vec![self.leaf("StackBelowBroken", StackBelowBroken::new)?];
        steps.extend(self.set_down(back)?);
        steps.push(self.leaf("ClearReturned", ClearHolding::new)?);
        Ok(Node::sequence("StackRecovery", Memory::Yes, steps))
    }

    fn normal(&mut self) -> Branch {
        let steps = vec![
            self.leaf("SelectNextCube", SelectNextCube::new)?,
            self.pickup()?,
            self.phase("Grasp", Phase::Grasp, Flavour::default())?,
            self.leaf("MarkHolding", MarkHolding::new)?,
            self.place()?,
        ];
        Ok(Node::sequence("Normal", Memory::Yes, steps))
    }

    fn pickup(&mut self) -> Branch {
        let drift = Flavour {
            drift: true,
            ..Flavour::default()
        };
        let steps = vec![
            self.phase("PreGrasp", Phase::PreGrasp, Flavour::default())?,
            self.phase("Approach", Phase::Approach, drift)?,
        ];
        Ok(Node::sequence("Pickup", Memory::Yes, steps))
    }

    fn place(&mut self) -> Branch {
        let mut steps = self.set_down(Flavour::default())?;
        steps.push(self.leaf("ClearHolding", ClearHolding::new)?);
        Ok(Node::sequence("Place", Memory::Yes, steps))
    }

    /// The five phases from the pick-up to the free hand.
    fn set_down(&mut self, flavour: Flavour) -> Result<Vec<Part>, BindError> {
        let names = if flavour.spawn {
            [
                "LiftBack",
                "TransportBack",
                "LowerBack",
                "ReleaseBack",
                "RetractBack",
            ]
        } else {
            ["Lift", "Transport", "Lower", "Release", "Retract"]
        };
        let phases = Phase::RING.into_iter().skip(Phase::Lift as usize);
        let steps = names.into_iter().zip(phases);
        steps
            .map(|(n, phase)| self.phase(n, phase, flavour))
            .collect()
    }

    fn phase(&mut self, name: &'static str, phase: Phase, flavour: Flavour) -> Branch {
        let flavour = Flavour {
            holds_until_retracted: self.holds_until_retracted,
            ..flavour
        };
        let mut node = self.leaf(name, |keys| PhaseLeaf::new(name, phase, flavour, keys))?;
        phase.name().clone_into(&mut node.detail);
        Ok(node)
    }

    fn leaf<L: Leaf<StackHost>>(
        &mut self,
        id: &'static str,
        make: impl FnOnce(Keys<'_>) -> Result<L, BindError>,
    ) -> Branch {
        let nothing = BTreeMap::new();
        let constants = BTreeMap::new();
        let leaf = make(Keys::new(Binder {
            node: id,
            bindings: &nothing,
            constants: &constants,
            local: &mut self.local,
            shared: &mut self.shared,
        }))?;
        Ok(Node::leaf(id, "action", leaf))
    }
}

//! Probable mistakes in a tree that loads and runs.

mod answers;
mod keys;
mod shapes;
mod times;

use std::collections::BTreeSet;

use super::spec::{Abort, Kind, Memory, Modifier, Node};
use super::{Host, Library};
use crate::board::Board;
use crate::finding::Finding;
use answers::{Answers, after, inner};

/// The keyword by which a registered type declares that it is a condition: it
/// returns success or failure, never running.
pub const CONDITION: &str = "condition";

/// Checks a tree before it is made ready to run. `library` defines which
/// leaves are conditions, see [`CONDITION`]; a leaf of an unknown type may return
/// any status.
pub fn check<H: Host>(
    root: &Node<H>,
    local: &Board,
    shared: &Board,
    library: &Library<H>,
) -> Vec<Finding> {
    let conditions = library.types().iter();
    let conditions = conditions.filter(|t| t.keywords.contains(&CONDITION));
    let mut look = Ability {
        conditions: conditions.map(|t| t.name).collect(),
        findings: Vec::new(),
    };
    look.node(root, false);
    shapes::check(root, library, &mut look.findings);
    times::check(root, &mut look.findings);
    keys::check(local, shared, &mut look.findings);
    look.findings
}

/// The possible results of a node.
struct Results {
    answers: Answers,
    /// Without its checks of keys, which fail where they do not hold.
    ungated: Answers,
}

struct Ability {
    conditions: BTreeSet<&'static str>,
    findings: Vec<Finding>,
}

impl Ability {
    fn find(&mut self, rule: &'static str, place: &str, message: String) {
        self.findings.push(Finding {
            rule,
            place: place.to_owned(),
            message,
        });
    }

    /// Checks a node and returns its possible results. `followed`: another node runs after
    /// it when it succeeds.
    fn node<H: Host>(&mut self, node: &Node<H>, followed: bool) -> Results {
        let count = node.children.len();
        // Only a sequence passes its success on to a next child; in other composites the
        // success of a child is followed by what follows the composite itself.
        let in_sequence = matches!(node.kind, Kind::Sequence(_) | Kind::SequenceWithMemory);
        let children: Vec<Results> = node
            .children
            .iter()
            .enumerate()
            .map(|(index, child)| {
                let later = index + 1 < count;
                let followed = if in_sequence {
                    later || followed
                } else {
                    followed
                };
                self.node(child, followed)
            })
            .collect();
        // Both forms are needed: a check of a key makes a branch of a selector fail although
        // the branch itself never does.
        let ungated: Vec<Answers> = children.iter().map(|c| c.ungated).collect();
        let children: Vec<Answers> = children.iter().map(|c| c.answers).collect();
        match &node.kind {
            Kind::Sequence(memory) => {
                self.unreached(node, &children, |a| !a.success, "succeeds");
                self.sequence(node, *memory, &children);
            }
            Kind::Selector(_) => {
                self.unreached(node, &children, |a| !a.failure, "fails");
                self.recovery(node, &ungated, followed);
            }
            _ => {}
        }
        let own = match &node.kind {
            Kind::Leaf(_) if node.condition => Answers::FINAL,
            Kind::Leaf(_) => self.leaf(&node.type_name),
            kind => inner(kind, &children),
        };
        // The checks of keys are removed from `ungated` alone, all other modifiers change the
        // result.
        let gate = |m: &&Modifier| !matches!(m, Modifier::CheckBlackboard { .. });
        Results {
            answers: after(node.modifiers.iter(), own),
            ungated: after(node.modifiers.iter().filter(gate), own),
        }
    }

    fn leaf(&self, type_name: &str) -> Answers {
        match type_name {
            "SetBlackboard" => Answers::SUCCESS,
            "CheckBlackboard" => Answers::FINAL,
            name if self.conditions.contains(name) => Answers::FINAL,
            // An unknown type may return anything, so no warning is made of it.
            _ => Answers::ALL,
        }
    }

    /// Finds a child behind one that never lets it run.
    fn unreached<H: Host>(
        &mut self,
        node: &Node<H>,
        answers: &[Answers],
        blocks: impl Fn(&Answers) -> bool,
        way: &str,
    ) {
        // The first one that blocks is reported; those behind it are unreachable for the same
        // reason.
        let Some(index) = answers.iter().position(blocks) else {
            return;
        };
        let (Some(last), Some(next)) = (node.children.get(index), node.children.get(index + 1))
        else {
            return;
        };
        let message = format!(
            "can never run: '{}' before it in '{}' never {way}; reorder or remove it",
            last.id, node.id
        );
        self.find("never_runs", &next.id, message);
    }

    fn sequence<H: Host>(&mut self, node: &Node<H>, memory: Memory, answers: &[Answers]) {
        let runners: Vec<&str> = node
            .children
            .iter()
            .zip(answers)
            .filter(|(_, answers)| answers.running)
            .map(|(child, _)| child.id.as_str())
            .collect();
        // All children, since one action among them makes the memory meaningful.
        let conditions = answers.iter().all(|a| a.failure && !a.running);
        if memory == Memory::Yes && conditions && node.children.len() > 1 {
            let message = "has memory, but its children are conditions, which are never running; \
                           take the memory away, it does nothing here";
            self.find("memory_of_conditions", &node.id, message.to_owned());
        }
        if memory == Memory::No && runners.len() > 1 {
            let message = format!(
                "is asked from the first child again at every tick, and several of its children \
                 may be running ({}), so that those before start over; give it memory, or give \
                 the types of conditions the keyword '{CONDITION}'",
                runners.join(", ")
            );
            self.find("reactive_runners", &node.id, message);
        }
    }

    /// Finds a branch of a selector that takes over by its check and then never
    /// fails: the selector succeeds, and the next node continues as if the
    /// last branch, the normal one, had succeeded.
    fn recovery<H: Host>(&mut self, node: &Node<H>, answers: &[Answers], followed: bool) {
        let branches = node.children.iter().zip(answers);
        // The last branch is the normal one and may succeed.
        let last = node.children.len().saturating_sub(1);
        for (child, answers) in branches.take(last) {
            let succeeds = answers.success && !answers.failure;
            if followed && succeeds && takes_over(&child.modifiers) {
                let message = format!(
                    "takes over in '{}' and ends in success, so what follows '{}' continues as if \
                     its last child had succeeded; let it end in failure to fall through to that",
                    node.id, node.id
                );
                self.find("recovery_succeeds", &child.id, message);
            }
        }
    }
}

fn takes_over(modifiers: &[Modifier]) -> bool {
    modifiers.iter().any(|modifier| {
        let Modifier::CheckBlackboard { abort, .. } = modifier else {
            return false;
        };
        matches!(abort, Abort::LowerPriority | Abort::Both)
    })
}

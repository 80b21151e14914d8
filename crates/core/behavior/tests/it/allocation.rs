//! No tick, reset or save uses the heap, for any kind of node.

use std::time::Duration;

use behavior::board::{Access, Board, Fault, In, Out, Scope, Slot};
use behavior::status::{ResetReason, Status};
use behavior::tree::{
    Abort, Binder, Cx, Halt, Host, Kind, Leaf, Memory, Modifier, Node, OneShotPolicy,
    ParallelPolicy, Test, Tree, any,
};
use behavior::value::{Value, ValueType};
use cell_rt::alloc::count;

struct Numbers;

impl Host for Numbers {
    type World<'w> = u64;
}

/// Answers by the parity of the world and of itself, writes a key, and takes
/// two calls to halt.
struct Busy {
    salt: u64,
    out: Out<f64>,
}

impl Leaf<Numbers> for Busy {
    type State = (u64, f64, bool);

    fn tick(&self, state: &mut Self::State, cx: &mut Cx<'_, '_, Numbers>) -> Result<Status, Fault> {
        *cx.world += 1;
        state.0 += 1;
        cx.set(&self.out, state.0 as f64)?;
        match (state.0 * 7 + self.salt) % 5 {
            0 => Ok(Status::Success),
            1 => Ok(Status::Failure),
            2 if self.salt == 3 => Err(Fault::Node("on purpose")),
            _ => Ok(Status::Running),
        }
    }

    fn halt(&self, state: &mut Self::State, _: &mut Cx<'_, '_, Numbers>, _: ResetReason) -> Halt {
        state.2 = !state.2;
        if state.2 { Halt::NotYet } else { Halt::Done }
    }
}

struct Garden {
    local: Board,
    shared: Board,
    leaves: u64,
}

impl Garden {
    fn busy(&mut self) -> Busy {
        self.leaves += 1;
        let (bindings, constants) = Default::default();
        let mut binder = Binder {
            node: "busy",
            bindings: &bindings,
            constants: &constants,
            local: &mut self.local,
            shared: &mut self.shared,
            findings: &mut Vec::new(),
        };
        let out = binder
            .writes(Scope::Local, "x", Some(0.0), Access::Write)
            .unwrap();
        Busy {
            salt: self.leaves,
            out,
        }
    }

    fn leaf(&mut self) -> Node<Numbers> {
        let leaf = self.busy();
        Node::leaf(&format!("leaf {}", self.leaves), "Busy", leaf)
    }

    fn around(&mut self, name: &str, kind: Kind<Numbers>) -> Node<Numbers> {
        let child = self.leaf();
        Node::new(name, name, kind, vec![child])
    }

    fn composite(&mut self, name: &str, kind: Kind<Numbers>) -> Node<Numbers> {
        let children = (0..3).map(|_| self.leaf()).collect();
        Node::new(name, name, kind, children)
    }

    fn children(&mut self) -> Vec<Node<Numbers>> {
        let guard = any(self.busy());
        let selected = ParallelPolicy::Selected {
            children: vec![0, 2],
            synchronise: true,
        };
        let convert = Kind::Converter {
            from: Status::Failure,
            to: Status::Running,
        };
        let half = In::Literal(0.005);
        vec![
            self.composite("sequence", Kind::Sequence(Memory::Yes)),
            self.composite("reactive sequence", Kind::Sequence(Memory::No)),
            self.composite("selector", Kind::Selector(Memory::Yes)),
            self.composite("reactive selector", Kind::Selector(Memory::No)),
            self.composite(
                "all",
                Kind::Parallel(ParallelPolicy::All { synchronise: false }),
            ),
            self.composite("one", Kind::Parallel(ParallelPolicy::One)),
            self.composite("selected", Kind::Parallel(selected)),
            self.around("inverter", Kind::Inverter),
            self.around("converter", convert),
            self.around("pass through", Kind::PassThrough),
            self.around("repeat", Kind::Repeat { count: Some(2) }),
            self.around("retry", Kind::Retry { count: Some(2) }),
            self.around("one shot", Kind::OneShot(OneShotPolicy::OnSuccess)),
            self.around("condition", Kind::Condition(Status::Success)),
            self.around("guard", Kind::EternalGuard(guard)),
            self.around("count", Kind::Count),
            self.around("timeout", Kind::Timeout(half)),
            Node::new("wait", "Wait", Kind::Wait(half), Vec::new()),
            self.modified(half),
        ]
    }

    fn modified(&mut self, half: In<f64>) -> Node<Numbers> {
        let index = self
            .local
            .declare("x", ValueType::Number, Some(Value::Number(0.0)));
        let slot = Slot {
            scope: Scope::Local,
            index: index.unwrap(),
        };
        let check = Modifier::CheckBlackboard {
            slot,
            test: Test::Below(6.0),
            abort: Abort::Both,
        };
        let retry = Modifier::Retry {
            max: 2,
            reset_on_success: true,
        };
        let repeat = Modifier::Repeat {
            count: 2,
            break_on_failure: false,
        };
        let force = Modifier::ForceStatus(Status::Failure);
        let all = [
            check,
            Modifier::Timeout(half),
            Modifier::Delay(half),
            retry,
            repeat,
            force,
        ];
        let mut node = self.leaf().with(Modifier::InvertStatus);
        for modifier in all {
            node = node.with(modifier);
        }
        node
    }
}

fn garden() -> (Tree<Numbers>, Board) {
    let mut garden = Garden {
        local: Board::new(),
        shared: Board::new(),
        leaves: 0,
    };
    // Every child is kept apart from the failures of the others.
    let children = garden.children().into_iter().map(|child| {
        let id = format!("{} again", child.id);
        let running = Kind::Converter {
            from: Status::Failure,
            to: Status::Success,
        };
        Node::new(&id, "converter", running, vec![child])
    });
    let children = children.collect();
    let all = Kind::Parallel(ParallelPolicy::All { synchronise: false });
    let root = Node::new("root", "parallel", all, children);
    let Garden { local, shared, .. } = garden;
    (Tree::new("garden", root, local).unwrap(), shared)
}

#[test]
fn ticks_resets_and_records_use_no_heap() {
    let (mut tree, mut shared) = garden();
    let (mut world, mut record, mut statuses) = (0, Vec::new(), Vec::new());
    tree.save(&mut record);
    tree.statuses(&mut statuses);
    let mut ran = vec![false; statuses.len()];
    let before = count();
    for tick in 0..5000 {
        let now = Duration::from_millis(tick);
        if tick % 500 == 499 {
            tree.reset(ResetReason::Explicit, now, &mut shared, &mut world);
        } else {
            tree.tick(now, &mut shared, &mut world);
        }
        record.clear();
        tree.save(&mut record);
        tree.statuses(&mut statuses);
        for (ran, status) in ran.iter_mut().zip(&statuses) {
            *ran |= status.answer().is_some();
        }
    }
    assert_eq!(count(), before);
    assert!(ran.iter().all(|ran| *ran), "every node ran");
    assert!(world > 5000);
}

#[test]
fn the_allocator_of_this_test_counts() {
    let before = count();
    drop(std::hint::black_box(vec![1_u8; 100]));
    assert!(count() > before);
}

//! Random trees: imported, ticked, killed after every tick, and compared with the reference.

use crate::reference::{Answer, Around, Kind, Node, World};
use crate::support::Running;

/// Trees that are made; those with a node that has no counterpart are refused.
const TREES: u64 = 1_500;
/// Of them at least so many have to be accepted.
const ACCEPTED: usize = 600;
const TICKS: usize = 12;

struct Random(u64);

impl Random {
    fn below(&mut self, count: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 33) % count
    }

    fn index(&mut self, count: u64) -> usize {
        usize::try_from(self.below(count)).unwrap()
    }
}

#[allow(clippy::too_many_lines, reason = "a list of kinds")]
fn node(random: &mut Random, depth: u64, leaves: &mut usize) -> Node {
    let leaf = depth == 0 || random.below(4) == 0;
    let kind = if leaf {
        match random.below(5) {
            0 => Kind::Set(random.below(2) == 0),
            1 => Kind::Ask,
            _ => {
                *leaves += 1;
                Kind::Leaf(format!("L{leaves}"))
            }
        }
    } else {
        match random.below(18) {
            0 | 14 => Kind::Sequence,
            1 | 15 => Kind::Fallback,
            2 | 16 => Kind::ReactiveSequence,
            3 | 17 => Kind::ReactiveFallback,
            4 => Kind::SequenceWithMemory,
            5 => Kind::Parallel {
                successes: 0,
                failures: 0,
            },
            6 => Kind::ParallelAll { failures: 0 },
            7 => Kind::IfThenElse,
            8 => Kind::Inverter,
            9 => Kind::ForceSuccess,
            10 => Kind::ForceFailure,
            11 => Kind::Repeat(1 + random.index(3)),
            12 => Kind::Retry(1 + random.index(3)),
            _ => match random.below(3) {
                0 => Kind::KeepRunning,
                1 => Kind::RunOnce { then_skip: true },
                _ => Kind::RunOnce { then_skip: false },
            },
        }
    };
    let count = match &kind {
        Kind::Leaf(_) | Kind::Set(_) | Kind::Ask => 0,
        Kind::IfThenElse => 2 + random.index(2),
        Kind::Sequence
        | Kind::Fallback
        | Kind::ReactiveSequence
        | Kind::ReactiveFallback
        | Kind::SequenceWithMemory
        | Kind::Parallel { .. }
        | Kind::ParallelAll { .. } => 1 + random.index(3),
        _ => 1,
    };
    let children = (0..count)
        .map(|_| node(random, depth - 1, leaves))
        .collect();
    let most = count.max(1) as u64;
    let kind = match kind {
        Kind::Parallel { .. } => Kind::Parallel {
            successes: 1 + random.index(most),
            failures: 1 + random.index(most),
        },
        Kind::ParallelAll { .. } => Kind::ParallelAll {
            failures: 1 + random.index(most),
        },
        kind => kind,
    };
    let mut node = Node::new(kind, children);
    if random.below(6) == 0 {
        let around = match random.below(4) {
            0 => Around::SkipIf,
            1 => Around::SuccessIf,
            2 => Around::FailureIf,
            _ => Around::While,
        };
        node.around = Some((around, random.below(2) == 0));
    }
    node
}

fn xml(node: &Node) -> String {
    let around = node.around.map_or(String::new(), |(around, wanted)| {
        let name = match around {
            Around::SkipIf => "_skipIf",
            Around::SuccessIf => "_successIf",
            Around::FailureIf => "_failureIf",
            Around::While => "_while",
        };
        format!(" {name}=\"on == {wanted}\"")
    });
    let (tag, ports) = match &node.kind {
        Kind::Leaf(name) => (name.clone(), String::new()),
        Kind::Set(value) => ("Script".into(), format!(" code=\"on := {value}\"")),
        Kind::Ask => ("ScriptCondition".into(), " code=\"on\"".into()),
        Kind::Parallel {
            successes,
            failures,
        } => (
            "Parallel".into(),
            format!(" success_count=\"{successes}\" failure_count=\"{failures}\""),
        ),
        Kind::ParallelAll { failures } => (
            "ParallelAll".into(),
            format!(" max_failures=\"{failures}\""),
        ),
        Kind::Repeat(count) => ("Repeat".into(), format!(" num_cycles=\"{count}\"")),
        Kind::Retry(count) => (
            "RetryUntilSuccessful".into(),
            format!(" num_attempts=\"{count}\""),
        ),
        Kind::KeepRunning => ("KeepRunningUntilFailure".into(), String::new()),
        Kind::RunOnce { then_skip } => ("RunOnce".into(), format!(" then_skip=\"{then_skip}\"")),
        kind => (format!("{kind:?}"), String::new()),
    };
    let children: String = node.children.iter().map(xml).collect();
    format!("<{tag}{ports}{around}>{children}</{tag}>")
}

fn letter(answer: Answer) -> char {
    match answer {
        Answer::Running => 'R',
        Answer::Success => 'S',
        Answer::Failure => 'F',
        Answer::Skipped => '-',
    }
}

/// `on` has a value before the tree reads it.
fn file(root: &Node) -> String {
    format!(
        "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\">\
         <SubTree ID=\"Inner\" on=\"false\"/></BehaviorTree><BehaviorTree ID=\"Inner\">\
         <Sequence><RunOnce then_skip=\"false\"><Script code=\"on := false\"/></RunOnce>{}\
         </Sequence></BehaviorTree></root>",
        xml(root)
    )
}

#[test]
fn random_trees_answer_as_the_reference_and_resume_after_every_tick() {
    let mut random = Random(7);
    let mut accepted = 0;
    for _ in 0..TREES {
        let mut leaves = 0;
        let root = node(&mut random, 3, &mut leaves);
        let file = file(&root);
        let scripts: Vec<(String, String)> = (1..=leaves)
            .map(|leaf| {
                let letters = (0..8).map(|_| ['R', 'S', 'F'][random.index(3)]);
                (format!("L{leaf}"), letters.collect())
            })
            .collect();
        let Ok(imported) = tree_import::import("t.xml", &file, &|_| None, None, None) else {
            continue;
        };
        accepted += 1;
        compare(&imported.json, &file, root, &scripts);
    }
    assert!(accepted >= ACCEPTED, "{accepted}");
}

fn compare(json: &str, file: &str, root: Node, scripts: &[(String, String)]) {
    let given: Vec<(&str, &str)> = scripts
        .iter()
        .map(|(n, s)| (n.as_str(), s.as_str()))
        .collect();
    let mut running = Running::of_json(json.to_owned(), &given);
    let mut world = World::default();
    let given = scripts
        .iter()
        .map(|(name, script)| (name.clone(), (script.clone(), 0)));
    world.scripts.extend(given);
    let set = Node::new(
        Kind::RunOnce { then_skip: false },
        vec![Node::new(Kind::Set(false), Vec::new())],
    );
    let mut reference = Node::new(Kind::Sequence, vec![set, root]);
    for tick in 0..TICKS {
        (world.ticked, world.halted) = (Vec::new(), Vec::new());
        let wanted = letter(reference.execute(&mut world));
        let (answer, log) = running.tick();
        running.kill();
        let (halted, ticked): (Vec<String>, Vec<String>) =
            log.into_iter().partition(|line| line.starts_with('!'));
        let mut halted: Vec<&str> = halted.iter().map(|line| &line[1..]).collect();
        world.halted.sort();
        halted.sort_unstable();
        let found = (
            answer,
            ticked,
            halted.iter().map(|name| (*name).to_owned()).collect(),
        );
        let expected = (wanted, world.ticked.clone(), world.halted.clone());
        assert_eq!(
            found, expected,
            "tick {tick} of {file}\n{scripts:?}\n{json}"
        );
    }
}

//! A tree case: ticked and compared with the reference; then once more, with the tree
//! discarded after every tick and made again from its checkpoint.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use behavior::board::{Board, Fault};
use behavior::status::{NodeStatus, Status};
use behavior::tree::{
    Cx, Host, Kind, Leaf, Memory, Node, OneShotPolicy, ParallelPolicy, Tree, any,
};
use serde_json::Value;

/// A host without a world.
pub(crate) struct Scripts;

impl Host for Scripts {
    type World<'w> = ();
}

/// Number of starts, ticks and invalidations of a leaf.
#[derive(Default)]
struct Calls([AtomicU64; 3]);

impl Calls {
    fn count(&self, which: usize) {
        if let Some(count) = self.0.get(which) {
            count.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// Results from a script, letter by letter; the last one repeats for ever.
struct Script {
    letters: String,
    calls: Arc<Calls>,
}

impl Leaf<Scripts> for Script {
    /// Number of results it has returned.
    type State = usize;

    fn start(&self, _: &mut usize, _: &mut Cx<'_, '_, Scripts>) -> Result<(), Fault> {
        self.calls.count(0);
        Ok(())
    }

    fn tick(&self, given: &mut usize, _: &mut Cx<'_, '_, Scripts>) -> Result<Status, Fault> {
        self.calls.count(1);
        let mut letters = self.letters.chars();
        let letter = letters.nth(*given).or(self.letters.chars().last());
        *given += 1;
        match letter {
            Some('T') => Ok(Status::Success),
            letter => letter.and_then(status).ok_or(Fault::Node("no such answer")),
        }
    }

    fn invalidated(&self, _: &mut usize) {
        self.calls.count(2);
    }
}

type Book = BTreeMap<String, Arc<Calls>>;

/// Runs a case.
///
/// # Errors
/// The difference, or the missing part of the case.
pub(crate) fn run(case: &Value) -> Result<(), String> {
    play(case, false).map_err(|error| named(case, &error))?;
    play(case, true).map_err(|error| named(case, &format!("restored every tick: {error}")))
}

fn named(case: &Value, error: &str) -> String {
    format!("{}: {error}", text(case, "id").unwrap_or("a tree"))
}

fn play(case: &Value, restored: bool) -> Result<(), String> {
    let mut book = Book::new();
    let mut tree = make(case, &mut book)?;
    let graph = tree.graph();
    let (mut shared, mut statuses, mut record) = (Board::new(), Vec::new(), Vec::new());
    for (now, expected) in (0..).zip(list(case, "ticks")?) {
        tree.tick(Duration::from_millis(now), &mut shared, &mut ());
        tree.statuses(&mut statuses);
        compare(now, "root", tree.status(), expected.get("root"))?;
        let leaves = expected.get("leaves");
        for (node, found) in graph.nodes.iter().zip(&statuses) {
            if node.kind == "leaf" {
                compare(now, &node.id, *found, leaves.and_then(|l| l.get(&node.id)))?;
            }
        }
        if restored {
            record.clear();
            tree.save(&mut record);
            // A new tree, so that state outside of the record shows as a difference.
            tree = make(case, &mut book)?;
            let carried = tree.restore(&record).map_err(|error| error.to_string())?;
            if carried.lost > 0 {
                return Err(format!("tick {now}: {carried:?}"));
            }
        }
    }
    count(case, &book)
}

fn make(case: &Value, book: &mut Book) -> Result<Tree<Scripts>, String> {
    let root = build(case.get("tree").ok_or("no tree")?, "n", book)?;
    Tree::new("case", root, Board::new()).map_err(|error| error.to_string())
}

fn count(case: &Value, book: &Book) -> Result<(), String> {
    for (leaf, calls) in book {
        let expected = case.get("counts").and_then(|counts| counts.get(leaf));
        for (key, found) in ["initialise", "update", "stopped"].iter().zip(&calls.0) {
            let found = found.load(Ordering::Relaxed);
            let wanted = expected.and_then(|e| e.get(key)).and_then(Value::as_u64);
            if wanted != Some(found) {
                return Err(format!("{leaf}: {key} {found} times, not {wanted:?}"));
            }
        }
    }
    Ok(())
}

fn compare(
    tick: u64,
    what: &str,
    found: NodeStatus,
    expected: Option<&Value>,
) -> Result<(), String> {
    let wanted = expected.and_then(Value::as_str).unwrap_or("nothing");
    let found = found.letter().to_string();
    if found == wanted {
        return Ok(());
    }
    Err(format!("tick {tick}: {what} is {found}, not {wanted}"))
}

/// The node of a NODE; `id` for nodes without a name.
fn build(node: &Value, id: &str, book: &mut Book) -> Result<Node<Scripts>, String> {
    let kind = text(node, "type")?;
    if kind == "leaf" {
        let name = text(node, "name")?;
        return Ok(Node::leaf(
            name,
            "leaf",
            script(node, "script", name, book)?,
        ));
    }
    let mut children = Vec::new();
    let written = node.get("child").into_iter();
    let written = written.chain(
        node.get("children")
            .and_then(Value::as_array)
            .into_iter()
            .flatten(),
    );
    for (number, child) in written.enumerate() {
        children.push(build(child, &format!("{id}.{number}"), book)?);
    }
    let built = match kind {
        "sequence" => Kind::Sequence(memory(node)),
        "selector" => Kind::Selector(memory(node)),
        "parallel" => Kind::Parallel(policy(node)?),
        "eternal_guard" => {
            // The case does not count the calls of the guard.
            let guard = script(node, "condition", "", &mut Book::new())?;
            Kind::EternalGuard(any(guard))
        }
        _ => decorator(node, kind)?,
    };
    Ok(Node::new(id, kind, built, children))
}

fn decorator(node: &Value, kind: &str) -> Result<Kind<Scripts>, String> {
    let count = node.get("count").and_then(Value::as_u64);
    let count = count.and_then(|count| u32::try_from(count).ok());
    let convert = |from, to| Kind::Converter { from, to };
    Ok(match kind {
        "inverter" => Kind::Inverter,
        "failure_is_success" => convert(Status::Failure, Status::Success),
        "failure_is_running" => convert(Status::Failure, Status::Running),
        "running_is_failure" => convert(Status::Running, Status::Failure),
        "running_is_success" => convert(Status::Running, Status::Success),
        "success_is_failure" => convert(Status::Success, Status::Failure),
        "success_is_running" => convert(Status::Success, Status::Running),
        "repeat" => Kind::Repeat { count },
        "retry" => Kind::Retry { count },
        "one_shot" if text(node, "policy")? == "on_success" => {
            Kind::OneShot(OneShotPolicy::OnSuccess)
        }
        "one_shot" => Kind::OneShot(OneShotPolicy::OnCompletion),
        "condition" => {
            let wanted = text(node, "status")?.chars().next().and_then(status);
            Kind::Condition(wanted.ok_or("no such status")?)
        }
        other => return Err(format!("no such type of node: {other}")),
    })
}

fn policy(node: &Value) -> Result<ParallelPolicy, String> {
    let synchronise = node.get("synchronise").and_then(Value::as_bool) == Some(true);
    Ok(match text(node, "policy")? {
        "success_on_all" => ParallelPolicy::All { synchronise },
        "success_on_one" => ParallelPolicy::One,
        _ => {
            let selected = list(node, "selected")?.iter().filter_map(Value::as_u64);
            let children = selected.filter_map(|index| usize::try_from(index).ok());
            ParallelPolicy::Selected {
                children: children.collect(),
                synchronise,
            }
        }
    })
}

fn script(node: &Value, key: &str, name: &str, book: &mut Book) -> Result<Script, String> {
    Ok(Script {
        letters: text(node, key)?.to_owned(),
        calls: book.entry(name.to_owned()).or_default().clone(),
    })
}

fn memory(node: &Value) -> Memory {
    match node.get("memory").and_then(Value::as_bool) {
        Some(true) => Memory::Yes,
        _ => Memory::No,
    }
}

fn status(letter: char) -> Option<Status> {
    NodeStatus::from_letter(letter)?.answer()
}

fn text<'v>(value: &'v Value, key: &str) -> Result<&'v str, String> {
    let found = value.get(key).and_then(Value::as_str);
    found.ok_or_else(|| format!("no text '{key}'"))
}

fn list<'v>(value: &'v Value, key: &str) -> Result<&'v Vec<Value>, String> {
    let found = value.get(key).and_then(Value::as_array);
    found.ok_or_else(|| format!("no list '{key}'"))
}

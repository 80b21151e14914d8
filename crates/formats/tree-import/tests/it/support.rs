//! Imports a tree, and ticks it with leaves that answer from scripts.

use std::collections::BTreeMap;
use std::time::Duration;

use behavior::board::{Board, Fault};
use behavior::descriptor::{self, Source};
use behavior::status::{NodeStatus, ResetReason};
use behavior::tree::{AnyLeaf, BindError, Cx, DeclaredLeaf, Halt, Host, Leaf, Library, Tree, any};
use behavior::{Status, Str, Value};

/// The world is a list of what the leaves did.
pub(crate) struct Bench;

impl Host for Bench {
    type World<'w> = Vec<String>;
}

/// Answers letter by letter, the last for ever. The port `text` is told; the port `out` gets
/// the name of the node.
struct Scripted {
    name: String,
    script: String,
    leaf: DeclaredLeaf,
}

impl Leaf<Bench> for Scripted {
    type State = u32;

    fn tick(&self, given: &mut u32, cx: &mut Cx<'_, '_, Bench>) -> Result<Status, Fault> {
        let mut said = self.name.clone();
        for port in &self.leaf.ports {
            if port.name == "out" {
                port.set(cx, Value::Text(Str::new(&self.name).unwrap()))?;
            } else {
                let value = port.get(cx);
                let value = value.map_or("nothing".to_owned(), |value| value.to_string());
                said = format!("{said} {}={value}", port.name);
            }
        }
        cx.world.push(said);
        let letter = self.script.chars().nth(*given as usize);
        let letter = letter.or(self.script.chars().last()).unwrap_or('S');
        *given += 1;
        Ok(NodeStatus::from_letter(letter)
            .and_then(NodeStatus::answer)
            .unwrap())
    }

    fn halt(&self, _: &mut u32, cx: &mut Cx<'_, '_, Bench>, _: ResetReason) -> Halt {
        cx.world.push(format!("!{}", self.name));
        Halt::Done
    }
}

pub(crate) type Scripts = BTreeMap<String, String>;

pub(crate) fn library(scripts: &Scripts) -> Library<Bench> {
    let scripts = scripts.clone();
    Library::default().with_declared(move |leaf| -> Result<Box<dyn AnyLeaf<Bench>>, BindError> {
        let name = leaf.node.rsplit('/').next().unwrap_or_default().to_owned();
        let script = scripts.get(&name).or(scripts.get(&leaf.type_name));
        Ok(any(Scripted {
            name,
            script: script.cloned().unwrap_or_else(|| "S".to_owned()),
            leaf,
        }))
    })
}

/// The tree file of an XML.
pub(crate) fn json(xml: &str) -> String {
    match tree_import::import("t.xml", xml, &|_| None, None, None) {
        Ok(imported) => imported.json,
        Err(errors) => panic!("refused:\n{errors}"),
    }
}

/// In `<root>` and one tree, unless it is a whole file.
pub(crate) fn whole(xml: &str) -> String {
    if xml.contains("<root") {
        return xml.to_owned();
    }
    format!("<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\">{xml}</BehaviorTree></root>")
}

/// A tree that runs.
pub(crate) struct Running {
    json: String,
    scripts: Scripts,
    tree: Tree<Bench>,
    now: u64,
}

impl Running {
    pub(crate) fn new(xml: &str, scripts: &[(&str, &str)]) -> Self {
        Self::of_json(json(&whole(xml)), scripts)
    }

    pub(crate) fn of_json(json: String, scripts: &[(&str, &str)]) -> Self {
        let scripts = scripts
            .iter()
            .map(|(name, script)| ((*name).to_owned(), (*script).to_owned()))
            .collect();
        let tree = tree_of(&json, &scripts);
        Self {
            json,
            scripts,
            tree,
            now: 0,
        }
    }

    /// The answer, and what the leaves did.
    pub(crate) fn tick(&mut self) -> (char, Vec<String>) {
        let mut log = Vec::new();
        let now = Duration::from_millis(self.now);
        let answer = self.tree.tick(now, &mut Board::new(), &mut log);
        self.now += 100;
        (answer.letter(), log)
    }

    /// Another process continues from the checkpoint.
    pub(crate) fn kill(&mut self) {
        let mut record = Vec::new();
        self.tree.save(&mut record);
        self.tree = tree_of(&self.json, &self.scripts);
        let carried = self.tree.restore(&record).unwrap();
        assert_eq!(carried.lost, 0);
    }
}

fn tree_of(json: &str, scripts: &Scripts) -> Tree<Bench> {
    let source = Source {
        file: "t.tree.json",
        text: json,
        include: &|_| Err(String::new()),
    };
    let constants = BTreeMap::new();
    descriptor::check(&source, &library(scripts), &constants, &Board::new())
        .unwrap_or_else(|errors| panic!("{errors}\n{json}"));
    descriptor::load(&source, &library(scripts), &constants, &mut Board::new())
        .unwrap_or_else(|errors| panic!("{errors}\n{json}"))
}

/// Ticks, one every 100 ms, as `R a, b, !c`. The process is killed after every tick in a
/// second run, which has to be the same.
pub(crate) fn ticks(xml: &str, scripts: &[(&str, &str)], count: usize) -> Vec<String> {
    let mut running = Running::new(xml, scripts);
    let mut killed = Running::new(xml, scripts);
    let mut lines = Vec::new();
    for tick in 0..count {
        let done = running.tick();
        assert_eq!(
            done,
            killed.tick(),
            "killed after each tick, in tick {tick}"
        );
        killed.kill();
        let (answer, log) = done;
        let line = format!("{answer} {}", log.join(", "));
        lines.push(line.trim_end().to_owned());
    }
    lines
}

//! The behaviours inside a machine or matrix file, ready to run.

use std::borrow::Cow;
use std::time::Duration;

use behavior::board::Board;
use behavior::descriptor::{self, Source};
use behavior::inline::Part;
use behavior::numbers::Numbers;
use behavior::tree::check::CONDITION;
use behavior::tree::{Library, Tree};
use behavior::{Finding, NodeStatus, ResetReason, Status};
use cell_model::{Cell, Data};
use robocell_task::SetupError;
use robocell_task::settings::behaviour_text;
use serde::de::Error as _;
use serde_bytes::ByteBuf;

use crate::skill::Station;
use crate::world::World;

/// Suffix of a tree file that a state names as its behaviour.
const TREE_FILE: &str = ".json";

/// Reads a file by its name.
type ReadFile<'c> = dyn Fn(&str) -> Result<String, SetupError> + 'c;

/// Loads the parts of one file.
pub(super) struct Loader<'c> {
    /// Reads a file in the same folder.
    read: Box<ReadFile<'c>>,
    file: String,
    library: Library<Station>,
    shared: Board,
}

impl<'c> Loader<'c> {
    /// A loader for `file`, beside the cell file; with its text. `library` has the node types of
    /// its steps.
    pub(super) fn new(
        cell: &'c Cell,
        library: Library<Station>,
        file: &str,
    ) -> Result<(Self, Cow<'static, str>), SetupError> {
        let text = behaviour_text(cell, file)?;
        let loader = Self {
            read: Box::new(|name| behaviour_text(cell, name).map(Cow::into_owned)),
            file: cell.name_of(file),
            library,
            shared: Board::new(),
        };
        Ok((loader, text))
    }

    /// A loader for `file`, which a node of another file runs; with its text.
    pub(super) fn nested(
        data: &'c Data,
        library: Library<Station>,
        file: &str,
    ) -> Result<(Self, String), SetupError> {
        let read = |name: &str| {
            let text = data.read(&format!("cells/{name}"));
            let text = text.map(Cow::into_owned);
            text.map_err(|error| SetupError::in_file(error.to_string()))
        };
        let text = read(file)?;
        let loader = Self {
            read: Box::new(read),
            file: data.name_of(&format!("cells/{file}")),
            library,
            shared: Board::new(),
        };
        Ok((loader, text))
    }

    /// A loader for a file that is checked without its cell: names of objects and places count
    /// as known.
    pub(super) fn alone(source: &Source<'c>, library: Library<Station>) -> Self {
        let (file, include) = (source.file.to_owned(), source.include);
        let missing = format!("{file}: a state runs a tree in a file that cannot be read");
        Self {
            read: Box::new(move |name| {
                include(name).map_err(|reason| Self::wrong(format!("{missing}: {name}: {reason}")))
            }),
            file,
            library,
            shared: Board::new(),
        }
    }

    /// Refuses numbers for code of a host: a file with steps has no such code.
    pub(super) fn refuse_numbers(&self, text: &str) -> Result<(), SetupError> {
        let numbers = Numbers::read(&self.file, text).map_err(Self::wrong)?;
        numbers.finish().map_err(Self::wrong)
    }

    /// Name of the file in messages.
    pub(super) fn file(&self) -> &str {
        &self.file
    }

    /// An error in the file.
    pub(super) fn wrong(problem: impl std::fmt::Display) -> SetupError {
        SetupError::in_file(problem.to_string())
    }

    /// The tree of a part.
    pub(super) fn tree(&mut self, part: &Part) -> Result<Tree<Station>, SetupError> {
        part.tree(&self.file, &self.library, &mut self.shared)
            .map_err(|errors| SetupError::in_file(errors.to_string()))
    }

    /// The tree of a condition. Only conditions are allowed in it: it may not move anything.
    pub(super) fn condition(&mut self, part: &Part) -> Result<Tree<Station>, SetupError> {
        // Evaluated in every decision, also of states in which it has no row: a skill in it
        // would move the arm behind the back of the steps that run.
        for (name, line, column) in part.types() {
            let known = self.library.find(name);
            if known.is_some_and(|known| !known.keywords.contains(&CONDITION)) {
                let conditions = self.library.types().iter();
                let conditions: Vec<&str> = conditions
                    .filter(|known| known.keywords.contains(&CONDITION))
                    .map(|known| known.name)
                    .collect();
                return Err(Self::wrong(format!(
                    "{}:{line}:{column}: '{}' asks '{name}', which is not a condition; conditions \
                     are {}",
                    self.file,
                    part.name,
                    conditions.join(", ")
                )));
            }
        }
        self.tree(part)
    }

    /// The trees of parts, in their order.
    pub(super) fn trees<'p>(
        &mut self,
        parts: impl IntoIterator<Item = &'p Part>,
    ) -> Result<Vec<Tree<Station>>, SetupError> {
        parts.into_iter().map(|part| self.tree(part)).collect()
    }

    /// The behaviour with the name `name` of a state: steps written in the file, or a tree in
    /// another file.
    pub(super) fn named(
        &mut self,
        name: &str,
        parts: &[Part],
    ) -> Result<Tree<Station>, SetupError> {
        // The file's own steps win over a file of the same name.
        if let Some(part) = parts.iter().find(|part| part.name == name) {
            return self.tree(part);
        }
        if !name.ends_with(TREE_FILE) {
            let file = &self.file;
            return Err(Self::wrong(format!(
                "{file}: a state runs '{name}', which is not here; write its 'steps', or name a \
                 tree in a file NAME.tree.json"
            )));
        }
        let text = (self.read)(name)?;
        let include = |name: &str| (self.read)(name).map_err(|error| error.to_string());
        let file = format!("cells/{name}");
        let source = Source {
            file: &file,
            text: &text,
            include: &include,
        };
        let constants = std::collections::BTreeMap::new();
        descriptor::load(&source, &self.library, &constants, &mut self.shared)
            .map_err(|errors| SetupError::in_file(errors.to_string()))
    }

    /// The blackboard that all these trees share.
    pub(super) fn into_board(self) -> Board {
        self.shared
    }
}

/// Findings about the nodes of trees, as their types noted them.
pub(super) fn noted<'t>(trees: impl IntoIterator<Item = &'t Tree<Station>>) -> Vec<Finding> {
    let trees = trees.into_iter();
    trees.flat_map(Tree::noted).cloned().collect()
}

/// The same findings as warnings at the start.
pub(super) fn warnings<'t>(trees: impl IntoIterator<Item = &'t Tree<Station>>) -> Vec<String> {
    let noted = noted(trees).into_iter();
    noted
        .map(|found| format!("node '{}': {}", found.place, found.message))
        .collect()
}

/// Ticks a tree.
pub(super) fn tick(tree: &mut Tree<Station>, shared: &mut Board, world: &mut World<'_>) -> Status {
    let now = Duration::from_millis(world.now().ticks());
    tree.tick(now, shared, world)
}

/// Stops a tree; skills stop at once.
pub(super) fn stop(tree: &mut Tree<Station>, shared: &mut Board, world: &mut World<'_>) {
    // A tree that is not running has nothing to stop; resetting it would trace a change.
    if tree.status() == NodeStatus::Running {
        let now = Duration::from_millis(world.now().ticks());
        tree.reset(ResetReason::Aborted, now, shared, world);
    }
}

/// Whether the condition of a tree holds.
pub(super) fn holds(tree: &mut Tree<Station>, shared: &mut Board, world: &mut World<'_>) -> bool {
    tick(tree, shared, world) == Status::Success
}

/// Trees, encoded.
pub(super) fn save(trees: &[Tree<Station>]) -> Vec<ByteBuf> {
    trees.iter().map(bytes).collect()
}

fn bytes(tree: &Tree<Station>) -> ByteBuf {
    let mut bytes = Vec::new();
    tree.save(&mut bytes);
    ByteBuf::from(bytes)
}

/// Conditions with their names, encoded: a modifier of a condition may remember, as `Delay`
/// does.
pub(super) fn save_named<'t>(
    conditions: impl Iterator<Item = (&'t str, &'t Tree<Station>)>,
) -> Vec<(String, ByteBuf)> {
    let named = conditions.map(|(name, tree)| (name.to_owned(), bytes(tree)));
    named.collect()
}

/// Restores the bytes of [`save_named`]. Conditions that were added to the file have none and
/// start.
pub(super) fn restore_named<'t>(
    conditions: impl Iterator<Item = (&'t str, &'t mut Tree<Station>)>,
    saved: &[(String, ByteBuf)],
) -> Result<(), bincode::Error> {
    for (name, tree) in conditions {
        if let Some((_, bytes)) = saved.iter().find(|(known, _)| known == name) {
            tree.restore(bytes).map_err(bincode::Error::custom)?;
        }
    }
    Ok(())
}

/// Restores the bytes of [`save`]. A tree that was edited keeps the state of the nodes whose
/// names it still has.
pub(super) fn restore(
    trees: &mut [Tree<Station>],
    saved: &[ByteBuf],
) -> Result<(), bincode::Error> {
    // Sequences have no names: with another number they cannot be matched.
    if trees.len() != saved.len() {
        return Err(bincode::Error::custom("another number of sequences"));
    }
    for (tree, bytes) in trees.iter_mut().zip(saved) {
        tree.restore(bytes).map_err(bincode::Error::custom)?;
    }
    Ok(())
}

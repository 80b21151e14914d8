//! Names of node types.

use super::advice;
use super::build::{Builder, NodeContext};
use super::counterparts;
use super::engine::{self, EngineType};
use super::files::get;
use super::json::{Entry, shortened};
use crate::tree::check::CONDITION;
use crate::tree::{Host, NodeType};

/// The meaning of a type name.
pub(super) enum Found<'a, H: Host> {
    Engine(&'static EngineType),
    Registered(&'a NodeType<H>),
    /// A leaf that the file declares; whether it is a condition.
    Declared(&'a str, bool),
}

impl<'a, H: Host> Found<'a, H> {
    pub(super) fn is_condition(&self) -> bool {
        match self {
            Self::Engine(_) => false,
            Self::Registered(node_type) => node_type.keywords.contains(&CONDITION),
            Self::Declared(_, condition) => *condition,
        }
    }

    pub(super) fn name(&self) -> &'a str {
        match self {
            Self::Engine(spec) => spec.name,
            Self::Registered(node_type) => node_type.name,
            Self::Declared(name, _) => name,
        }
    }
}

impl<'a, H: Host> Builder<'a, H> {
    pub(super) fn find(
        &mut self,
        context: &NodeContext<'a>,
        entries: &'a [Entry],
        name: &str,
    ) -> Option<Found<'a, H>> {
        // Engine, registered, declared: a library cannot change the meaning of an engine type.
        if let Some(spec) = engine::find(name) {
            return Some(Found::Engine(spec));
        }
        if let Some(node_type) = self.library.find(name) {
            return Some(Found::Registered(node_type));
        }
        if let Some((declared, leaf)) = self.leaves.get_key_value(name) {
            return Some(Found::Declared(declared, leaf.condition));
        }
        if let Some(value) = get(entries, "type") {
            let message = self.unknown_type(name);
            self.errors.push(context.file, value.place, message);
        }
        None
    }

    /// Searches names of another library first, then known names, then keywords.
    fn unknown_type(&self, name: &str) -> String {
        if let Some(ours) = counterparts::of(name) {
            return format!("unknown node type '{name}'; {ours}");
        }
        let registered = self.library.types().iter();
        let keywords = registered.map(|t| (t.name, t.keywords));
        let all: Vec<(&str, &[&str])> = keywords
            .chain(engine::NODES.iter().map(|t| (t.name, t.keywords)))
            .collect();
        let declared = self.leaves.keys().copied();
        let names = all.iter().map(|(name, _)| *name).chain(declared);
        let names: Vec<&str> = names.collect();
        let message = advice::unknown("node type", name, &names);
        if message.contains("did you mean") {
            return message;
        }
        let word = name.to_lowercase();
        let meant = all
            .iter()
            .find(|(_, keywords)| keywords.contains(&word.as_str()));
        match meant {
            Some((meant, _)) => format!(
                "unknown node type '{}'; did you mean '{meant}' ({word})?",
                shortened(name)
            ),
            None => message,
        }
    }
}

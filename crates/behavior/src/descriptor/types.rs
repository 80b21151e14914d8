//! Names of node types.

use super::advice;
use super::build::{Builder, Site};
use super::engine::{self, EngineType};
use super::files::get;
use super::json::{Entry, shortened};
use crate::tree::check::CONDITION;
use crate::tree::{Host, NodeType};

/// What the name of a type stands for.
pub(super) enum Found<'a, H: Host> {
    Engine(&'static EngineType),
    Registered(&'a NodeType<H>),
}

impl<H: Host> Found<'_, H> {
    pub(super) fn is_condition(&self) -> bool {
        match self {
            Self::Engine(_) => false,
            Self::Registered(node_type) => node_type.keywords.contains(&CONDITION),
        }
    }

    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Engine(spec) => spec.name,
            Self::Registered(node_type) => node_type.name,
        }
    }
}

impl<'a, H: Host> Builder<'a, H> {
    pub(super) fn find(
        &mut self,
        site: &Site<'a>,
        entries: &'a [Entry],
        name: &str,
    ) -> Option<Found<'a, H>> {
        if let Some(spec) = engine::find(name) {
            return Some(Found::Engine(spec));
        }
        if let Some(node_type) = self.library.find(name) {
            return Some(Found::Registered(node_type));
        }
        if let Some(value) = get(entries, "type") {
            let message = self.unknown_type(name);
            self.errors.push(site.file, value.place, message);
        }
        None
    }

    /// Looks among names first, then among keywords.
    fn unknown_type(&self, name: &str) -> String {
        let registered = self.library.types().iter();
        let keywords = registered.map(|t| (t.name, t.keywords));
        let all: Vec<(&str, &[&str])> = keywords
            .chain(engine::NODES.iter().map(|t| (t.name, t.keywords)))
            .collect();
        let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
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
                "there is no node type '{}'; did you mean '{meant}' ({word})?",
                shortened(name)
            ),
            None => message,
        }
    }
}

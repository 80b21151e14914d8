//! Guards of nodes.

use super::build::Builder;
use super::engine::{self, Children};
use super::files::{get, object};
use super::json::{Location, Value as Json};
use super::kinds::At;
use super::nodes::GUARD_KEYS;
use super::types::Found;
use crate::tree::{Host, Kind};

impl<'a, H: Host> Builder<'a, H> {
    /// A condition that is evaluated before each tick of the child.
    pub(super) fn guard(&mut self, at: At<'_, 'a>, json: &'a Json) -> Option<Kind<H>> {
        let file = at.context.file;
        let entries = object(&mut self.errors, file, json, "a guard", GUARD_KEYS)?;
        let name = self.type_name(at.context, json, entries)?;
        let place = get(entries, "type").map_or(json.place, |t| t.place);
        let at = At { place, ..at };
        let ports = get(entries, "ports");
        match self.find(at.context, entries, name)? {
            Found::Registered(node_type) => self.leaf(at, node_type, ports).map(Kind::EternalGuard),
            Found::Declared(name, _) => self.declared_leaf(at, name, ports).map(Kind::EternalGuard),
            // A guard is one leaf: composites would need a place in the tree, with ids and
            // statuses.
            Found::Engine(spec) if spec.children == Children::None && name != engine::SUBTREE => {
                match self.kind(at, spec, ports, &[])? {
                    Kind::Leaf(leaf) => Some(Kind::EternalGuard(leaf)),
                    _ => self.no_guard(file, place, name),
                }
            }
            Found::Engine(_) => self.no_guard(file, place, name),
        }
    }

    fn no_guard(&mut self, file: &str, place: Location, name: &str) -> Option<Kind<H>> {
        let message =
            format!("{name} cannot be a guard; use CheckBlackboard or a registered condition");
        self.errors.push(file, place, message);
        None
    }
}

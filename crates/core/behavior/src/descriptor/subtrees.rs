//! Uses of subtrees.

use std::collections::BTreeMap;

use super::advice;
use super::build::{Builder, NodeContext};
use super::files::get;
use super::json::{Entry, Value as Json, shortened};
use super::kinds::At;
use super::literal;
use super::nodes::Seat;
use crate::tree::{Binding, Host, Node};
use crate::value::ValueType;

impl<'a, H: Host> Builder<'a, H> {
    /// The root of the subtree that is used here.
    pub(super) fn subtree(
        &mut self,
        at: At<'_, 'a>,
        entries: &'a [Entry],
        depth: usize,
    ) -> Option<Node<H>> {
        let value = get(entries, "subtree")?;
        let file = at.context.file;
        let name = value.as_text().unwrap_or_default();
        let known: Vec<&'a str> = self.subtrees.keys().copied().collect();
        let Some(name) = known.iter().copied().find(|k| *k == name) else {
            let message = advice::unknown("subtree", name, &known);
            self.errors.push(file, value.place, message);
            return None;
        };
        // The number of nodes is limited as well, but the circle is the mistake to report.
        if self.open.contains(&name) {
            let circle = [self.open.join(" -> "), name.to_owned()].join(" -> ");
            let message = format!("a subtree is part of itself: {circle}; break the circle");
            self.errors.push(file, value.place, message);
            return None;
        }
        self.used_subtrees.insert(name);
        let ports = self.subtree_ports(at, name, get(entries, "ports"));
        let subtree = self.subtrees.get(name)?;
        let inner = NodeContext {
            file: subtree.file,
            // Ids of the subtree get the id of the use as prefix: it may be used several times.
            prefix: format!("{}/", at.id),
            ports: Some(ports?),
        };
        let root = subtree.root;
        self.open.push(name);
        let seat = Seat {
            depth: depth + 1,
            ..Seat::ROOT
        };
        // `open` has the subtree while its nodes are read, to find circles.
        let node = self.node(&inner, root, seat);
        self.open.pop();
        node
    }

    fn subtree_ports(
        &mut self,
        at: At<'_, 'a>,
        name: &'a str,
        given: Option<&'a Json>,
    ) -> Option<BTreeMap<&'a str, (ValueType, Binding)>> {
        let subtree = self.subtrees.get(name)?;
        let declaring = subtree.file;
        let declared = subtree.ports.iter();
        let declared: Vec<_> = declared
            .map(|p| (p.name, p.value_type, p.default))
            .collect();
        let known: Vec<&str> = declared.iter().map(|(name, ..)| *name).collect();
        let entries = self.port_entries(at.context, given, &known);
        let mut ports = Some(BTreeMap::new());
        for (port, value_type, default) in declared {
            let binding = match (get(entries, port), default) {
                (Some(json), _) => self.binding(at.context, json, Some(value_type)),
                // A default is read with the constants of the file that declares it, whose
                // place a mistake has.
                (None, Some(json)) => self
                    .literal(declaring, json, value_type)
                    .map(Binding::Literal),
                (None, None) => {
                    let message = format!(
                        "subtree '{name}' needs the port '{}', {}",
                        shortened(port),
                        literal::wanted(value_type)
                    );
                    self.errors.push(at.context.file, at.place, message);
                    None
                }
            };
            match (binding, &mut ports) {
                (Some(binding), Some(ports)) => drop(ports.insert(port, (value_type, binding))),
                _ => ports = None,
            }
        }
        ports
    }
}

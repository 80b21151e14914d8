//! Node types of the author: leaves that a program provides.

use std::collections::BTreeMap;

use behavior::descriptor::engine_types;

use crate::bind::{self, Value};
use crate::document::{Element, Model, PortModel};
use crate::out::{At, Bind};
use crate::translate::{Part, Translator};
use crate::types::{Holder, Type};

/// A type of leaf, as far as its uses and the model define it.
#[derive(Debug)]
pub(crate) struct LeafUse {
    pub condition: bool,
    pub ports: BTreeMap<String, PortUse>,
    pub place: String,
}

/// A port of a leaf.
#[derive(Debug, Default)]
pub(crate) struct PortUse {
    /// From the model: whether it is read, and written.
    pub model: Option<(bool, bool)>,
    /// It is bound to a key somewhere.
    pub keyed: bool,
    /// As text.
    pub default: Option<(String, At)>,
}

impl PortUse {
    /// The access to its key. An unknown port may write.
    pub(crate) fn access(&self) -> &'static str {
        match self.model {
            Some((true, false)) => "read",
            Some((false, true)) => "write",
            Some(_) => "both",
            None if self.keyed => "both",
            None => "read",
        }
    }
}

impl Translator<'_> {
    pub(crate) fn leaf(&mut self, element: &Element, depth: usize) -> Option<Part> {
        let name = element.node_type();
        let model = self.project.models.get(name);
        // Control nodes and decorators of the author have code that only the author knows.
        let is_own = matches!(element.tag.as_str(), "Control" | "Decorator");
        let is_modelled = model.is_some_and(|m| m.kind == "Control" || m.kind == "Decorator");
        if is_own || is_modelled || !element.children.is_empty() {
            let advice = match Self::known_node(name) {
                Some(near) => format!("did you mean '{near}'?"),
                None => "express it with those of BehaviorTree.CPP, or make its work a leaf".into(),
            };
            let why = format!(
                "{name} has no counterpart: it is a control node or decorator of its author; {advice}"
            );
            self.refuse(element, why);
            self.look_inside(element, depth);
            return None;
        }
        // A tree used like a node: version 4 needs SubTree, which creates its own board.
        if self.project.trees.iter().any(|(tree, _)| tree == name) {
            self.refuse(
                element,
                format!("write <SubTree ID=\"{name}\"/> for a tree"),
            );
            return None;
        }
        let own = name_of(name);
        let provided = self.provided;
        // A provided subtree replaces the leaf, so no program has to provide it.
        if let Some(signature) = provided.subtrees.get(&own) {
            return self.provided_leaf(element, (&own, signature), model);
        }
        self.known_leaf(&own, element, model);
        let mut out = self.out(element, &own, Vec::new());
        for (port, text) in &element.attributes {
            if port == "name" || port == "ID" || port.starts_with('_') {
                continue;
            }
            let bind = self.leaf_port(element, &own, port, text);
            out = out.bound(port, bind);
        }
        // A default that is a key is bound where no attribute binds the port.
        for port in model.map(|m| m.ports.as_slice()).unwrap_or_default() {
            let default = port
                .default
                .as_deref()
                .filter(|_| element.get(&port.name).is_none());
            if let Some(text) = default
                && matches!(bind::value(&port.name, text), Value::Key(_))
            {
                let bind = self.leaf_port(element, &own, &port.name, text);
                out = out.bound(&port.name, bind);
            }
        }
        Some(Part::of(out))
    }

    fn known_leaf(&mut self, name: &str, element: &Element, model: Option<&Model>) {
        // The first use declares the leaf, together with its model.
        if self.leaves.contains_key(name) {
            return;
        }
        let at = At::of(element);
        let place = format!("{}:{}", at.file, at.place.line);
        let is_condition = |kind: &str| kind == "Condition";
        let mut ports = BTreeMap::new();
        for port in model.map(|m| m.ports.as_slice()).unwrap_or_default() {
            ports.insert(port.name.clone(), self.modelled(name, port, &at));
        }
        let leaf = LeafUse {
            condition: is_condition(&element.tag) || model.is_some_and(|m| is_condition(&m.kind)),
            ports,
            place,
        };
        self.leaves.insert(name.to_owned(), leaf);
    }

    fn modelled(&mut self, leaf: &str, port: &PortModel, at: &At) -> PortUse {
        let holder = holder(leaf, &port.name);
        let found = port.type_name.as_deref().and_then(Type::of_cpp);
        if let Some(found) = found
            && let Err(before) = self.types.is(&holder, found)
        {
            self.mixed(at, &port.name, before, found);
        }
        let default = port.default.as_deref();
        let default =
            default.filter(|text| matches!(bind::value(&port.name, text), Value::Text(_)));
        // A literal fits a port or shows its type; a port with several types takes any.
        if let Some(text) = default {
            self.types.has_literal(&holder, text);
        }
        PortUse {
            model: Some((port.reads, port.writes)),
            keyed: false,
            default: default.map(|text| (text.to_owned(), at.clone())),
        }
    }

    fn leaf_port(&mut self, element: &Element, leaf: &str, port: &str, text: &str) -> Bind {
        let at = At::of(element);
        let holder = holder(leaf, port);
        let known = self.leaves.get_mut(leaf);
        let known = known.map(|known| known.ports.entry(port.to_owned()).or_default());
        match bind::value(port, text) {
            Value::Text(text) => {
                self.types.has_literal(&holder, text);
                Bind::Text(text.to_owned(), holder, at)
            }
            Value::Key(key) => {
                // Without a model a port may write its key: the subtree then cannot get a
                // literal for it.
                let mut writes = true;
                if let Some(known) = known {
                    known.keyed = true;
                    writes = known.model.is_none_or(|(_, writes)| writes);
                }
                let key = self.key(key, writes);
                let of_key = self.holder(&key);
                self.types.takes(&holder, &of_key);
                Bind::Key(key)
            }
        }
    }
}

pub(crate) fn holder(leaf: &str, port: &str) -> Holder {
    Holder::Port {
        leaf: leaf.to_owned(),
        port: port.to_owned(),
    }
}

/// The name of the leaf here, which must not be that of a node of the engine.
fn name_of(name: &str) -> String {
    if engine_types().any(|taken| taken == name) {
        return format!("{name}Leaf");
    }
    name.to_owned()
}

//! Node types of the author: leaves that a program, or a subtree of a file, provides.

use std::collections::BTreeMap;

use behavior::descriptor::{PortSignature, Signature, engine_types};
use behavior::suggest;

use crate::bind::{self, Value};
use crate::document::{Element, Model, PortModel};
use crate::out::{At, Bind, LeafUse, PortUse};
use crate::provided::{BoundKey, Target, named, type_of};
use crate::translate::{Part, Translator};
use crate::types::{Holder, Type};

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
        let holder = Holder::port(leaf, &port.name);
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
        let holder = Holder::port(leaf, port);
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

    /// A use of the subtree that provides a leaf.
    fn provided_leaf(
        &mut self,
        element: &Element,
        (name, signature): (&str, &Signature),
        model: Option<&Model>,
    ) -> Option<Part> {
        let own = named(name, signature);
        let mut out = self.out(element, "Subtree", Vec::new());
        out.subtree = Some(name.to_owned());
        let values = values(element, model);
        let ports: Vec<&str> = signature.ports.iter().map(|p| p.name.as_str()).collect();
        // Every port is tested before the use is refused, so that all mistakes are reported.
        let mut fits = true;
        for (port, text, access) in &values {
            let Some(declared) = signature.ports.iter().find(|p| p.name == *port) else {
                let advice = suggest::advice(port, &ports);
                self.refuse(element, format!("{own} has no port '{port}'; {advice}"));
                fits = false;
                continue;
            };
            match self.provided_port(element, (name, &own), declared, (text, *access)) {
                Some(bind) => out = out.bound(port, bind),
                None => fits = false,
            }
        }
        for port in signature.ports.iter().filter(|port| port.needed) {
            if !values.iter().any(|(name, ..)| *name == port.name) {
                self.refuse(element, format!("{own} needs the port '{}'", port.name));
                fits = false;
            }
        }
        fits.then(|| Part::of(out))
    }

    fn provided_port(
        &mut self,
        element: &Element,
        (name, own): (&str, &str),
        declared: &PortSignature,
        (text, access): (&str, Option<Access>),
    ) -> Option<Bind> {
        let port = declared.name.as_str();
        let target = Target {
            value_type: declared.value_type,
            port: format!("port '{port}' of {own}"),
        };
        let key = match bind::value(port, text) {
            // A literal has no place for the output of the leaf.
            Value::Text(_) if access.is_some_and(Access::is_output) => {
                let why = format!("{} is an output; bind it to a key, {{KEY}}", target.port);
                self.refuse(element, why);
                return None;
            }
            Value::Text(text) => match target.literal(text) {
                Ok(value) => return Some(Bind::Fixed(value)),
                Err(why) => {
                    self.refuse(element, why);
                    return None;
                }
            },
            // An unknown access may write.
            Value::Key(key) => self.key(key, access.is_none_or(|access| access.writes)),
        };
        let (of_port, of_key) = (Holder::port(name, port), self.holder(&key));
        // A difference is reported when all types are known.
        if let Some(value_type) = type_of(target.value_type)
            && self.types.is(&of_port, value_type).is_ok()
        {
            self.types.takes(&of_port, &of_key);
        }
        self.bound.push(BoundKey {
            at: At::of(element),
            key: of_key,
            name: key.clone(),
            target,
        });
        Some(Bind::Key(key))
    }
}

/// The access of a port in the model.
#[derive(Clone, Copy)]
struct Access {
    reads: bool,
    writes: bool,
}

impl Access {
    fn of(port: &PortModel) -> Self {
        Self {
            reads: port.reads,
            writes: port.writes,
        }
    }

    fn is_output(self) -> bool {
        self.writes && !self.reads
    }
}

/// The bound ports with their texts: attributes, and defaults of the model.
fn values<'e>(
    element: &'e Element,
    model: Option<&'e Model>,
) -> Vec<(&'e str, &'e str, Option<Access>)> {
    let modelled = model
        .map(|model| model.ports.as_slice())
        .unwrap_or_default();
    let access = |name: &str| {
        let port = modelled.iter().find(|port| port.name == name);
        port.map(Access::of)
    };
    let attributes = element.attributes.iter();
    let attributes =
        attributes.filter(|(name, _)| name != "name" && name != "ID" && !name.starts_with('_'));
    let given = attributes.map(|(name, text)| (name.as_str(), text.as_str(), access(name)));
    let defaults = modelled.iter().filter_map(|port| {
        // An empty default means that there is none.
        let text = port.default.as_deref().filter(|text| !text.is_empty())?;
        let is_given = element.get(&port.name).is_some();
        (!is_given).then_some((port.name.as_str(), text, Some(Access::of(port))))
    });
    given.chain(defaults).collect()
}

/// The name of the leaf here, which must not be that of a node of the engine.
fn name_of(name: &str) -> String {
    if engine_types().any(|taken| taken == name) {
        return format!("{name}Leaf");
    }
    name.to_owned()
}

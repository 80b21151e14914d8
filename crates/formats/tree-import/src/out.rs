//! Nodes of the tree that is written, before the types of its keys are known.

use std::collections::BTreeMap;

use behavior::descriptor::json::Location;
use serde_json::Value as Json;

use crate::document::Element;
use crate::types::Holder;

/// A place in the XML.
#[derive(Clone, Debug)]
pub(crate) struct At {
    pub file: String,
    pub place: Location,
    /// The name of the node in messages.
    pub node: String,
}

impl At {
    pub(crate) fn of(element: &Element) -> Self {
        let node = match (element.node_type(), element.get("name")) {
            ("SubTree", _) => format!("SubTree '{}'", element.get("ID").unwrap_or("")),
            (name, Some(own)) => format!("{name} '{own}'"),
            (name, None) => name.to_owned(),
        };
        Self {
            file: element.file.clone(),
            place: element.place,
            node,
        }
    }
}

/// The binding of a port.
#[derive(Clone, Debug)]
pub(crate) enum Bind {
    /// A fixed value.
    Fixed(Json),
    /// The text of an attribute, in the type of the holder.
    Text(String, Holder, At),
    /// A constant of a script, in the type of the holder.
    Constant(crate::script::Constant, Holder, At),
    /// A key of the tree with the port.
    Key(String),
    /// The test of a key for being true, in the type of the holder.
    True(Holder, At),
}

/// A node of the written tree.
#[derive(Clone, Debug)]
pub(crate) struct Out {
    pub id: String,
    pub kind: String,
    pub name: Option<String>,
    pub ports: Vec<(String, Bind)>,
    pub modifiers: Vec<Json>,
    pub subtree: Option<String>,
    pub children: Vec<Out>,
}

impl Out {
    pub(crate) fn new(id: String, kind: &str, children: Vec<Self>) -> Self {
        Self {
            id,
            kind: kind.to_owned(),
            name: None,
            ports: Vec::new(),
            modifiers: Vec::new(),
            subtree: None,
            children,
        }
    }

    pub(crate) fn port(mut self, name: &str, value: impl Into<Json>) -> Self {
        self.ports
            .push((name.to_owned(), Bind::Fixed(value.into())));
        self
    }

    pub(crate) fn bound(mut self, name: &str, bind: Bind) -> Self {
        self.ports.push((name.to_owned(), bind));
        self
    }
}

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

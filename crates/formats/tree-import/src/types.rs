//! Types of keys and ports: all holders of a value have one type.

use std::collections::{BTreeMap, BTreeSet};

use crate::script::Constant;

/// A type of values, with the names in files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Type {
    Bool,
    Number,
    Text,
}

impl Type {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Bool => "bool",
            Self::Number => "number",
            Self::Text => "text",
        }
    }

    /// The common type of two in a script, in which `true` is the number 1.
    fn joined(self, other: Self) -> Option<Self> {
        match (self, other) {
            (a, b) if a == b => Some(a),
            (Self::Text, _) | (_, Self::Text) => None,
            _ => Some(Self::Number),
        }
    }

    /// The type that the text of an attribute implies.
    pub(crate) fn of_text(text: &str) -> Self {
        match text.trim() {
            "true" | "false" => Self::Bool,
            text if text.parse::<f64>().is_ok_and(f64::is_finite) => Self::Number,
            _ => Self::Text,
        }
    }

    /// The type of a C++ type; classes are texts.
    pub(crate) fn of_cpp(name: &str) -> Option<Self> {
        let name = name.trim();
        Some(match name {
            "bool" => Self::Bool,
            "double" | "float" | "int" | "unsigned" | "unsigned int" | "long" | "short" => {
                Self::Number
            }
            name if name.starts_with("int") || name.starts_with("uint") || name == "size_t" => {
                Self::Number
            }
            // No type: the uses of the port determine it.
            "" | "auto" | "AnyTypeAllowed" | "BT::AnyTypeAllowed" | "Any" => return None,
            _ => Self::Text,
        })
    }

    pub(crate) fn of_constant(constant: &Constant) -> Self {
        match constant {
            Constant::Bool(_) => Self::Bool,
            Constant::Number(_) => Self::Number,
            Constant::Text(_) => Self::Text,
        }
    }
}

/// A key or a port with a type.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Holder {
    /// Key of a tree.
    Key { tree: String, key: String },
    /// Port of a leaf type.
    Port { leaf: String, port: String },
}

impl Holder {
    /// A port of a leaf type.
    pub(crate) fn port(leaf: &str, port: &str) -> Self {
        Self::Port {
            leaf: leaf.to_owned(),
            port: port.to_owned(),
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Known {
    parent: usize,
    /// Holders below it: the smaller set joins the larger one, so chains stay short.
    size: usize,
    /// The type in scripts and models.
    hard: Option<Type>,
    /// The type that attributes imply, which are texts in any case.
    soft: Option<Type>,
}

/// The types found so far.
#[derive(Debug, Default)]
pub(crate) struct Types {
    /// Ports with values of several types.
    any: BTreeSet<Holder>,
    /// Literals of ports, which have to fit the final type.
    literals: Vec<(Holder, String)>,
    indices: BTreeMap<Holder, usize>,
    known: Vec<Known>,
}

impl Types {
    fn index(&mut self, holder: &Holder) -> usize {
        if let Some(index) = self.indices.get(holder) {
            return *index;
        }
        let index = self.known.len();
        self.known.push(Known {
            parent: index,
            size: 1,
            hard: None,
            soft: None,
        });
        self.indices.insert(holder.clone(), index);
        index
    }

    fn root(&self, mut index: usize) -> usize {
        while let Some(known) = self.known.get(index).filter(|known| known.parent != index) {
            index = known.parent;
        }
        index
    }

    fn at(&mut self, holder: &Holder) -> Option<&mut Known> {
        let index = self.index(holder);
        let root = self.root(index);
        self.known.get_mut(root)
    }

    /// Adds the type in a script or a model. `Err` with the type that was known before.
    pub(crate) fn is(&mut self, holder: &Holder, found: Type) -> Result<(), Type> {
        let Some(known) = self.at(holder) else {
            return Ok(());
        };
        let before = known.hard.unwrap_or(found);
        known.hard = Some(before.joined(found).ok_or(before)?);
        Ok(())
    }

    /// Adds the text of an attribute.
    pub(crate) fn looks_like(&mut self, holder: &Holder, text: &str) {
        let found = Type::of_text(text);
        if let Some(known) = self.at(holder) {
            known.soft = match known.soft {
                // Two different forms are texts: nothing is lost, as an attribute is a text.
                Some(before) if before != found => Some(Type::Text),
                _ => Some(found),
            };
        }
    }

    /// Adds a literal of a port.
    pub(crate) fn has_literal(&mut self, port: &Holder, text: &str) {
        self.looks_like(port, text);
        self.literals.push((port.clone(), text.to_owned()));
    }

    /// Binds a port to a key; if their types differ, the port takes values of any type.
    pub(crate) fn takes(&mut self, port: &Holder, key: &Holder) {
        if self.same(key, port).is_err() {
            self.any.insert(port.clone());
        }
    }

    /// Whether a port takes values of several types; final after [`Types::finish`].
    pub(crate) fn is_any(&self, port: &Holder) -> bool {
        self.any.contains(port)
    }

    /// Compares literals with the types that were found.
    pub(crate) fn finish(&mut self) {
        // Only now: a model or script after the literal may have given the port its type.
        for (port, text) in std::mem::take(&mut self.literals) {
            let fits = match (self.of(&port), Type::of_text(&text)) {
                (Type::Text, _) | (Type::Number, Type::Bool) => true,
                (Type::Bool, Type::Number) => matches!(text.trim(), "0" | "1"),
                (wanted, found) => wanted == found,
            };
            if !fits {
                self.any.insert(port);
            }
        }
    }

    /// Makes two holders of one value have one type. `Err` with their types if these differ.
    pub(crate) fn same(&mut self, one: &Holder, other: &Holder) -> Result<(), (Type, Type)> {
        let (one, other) = (self.index(one), self.index(other));
        let (one, other) = (self.root(one), self.root(other));
        if one == other {
            return Ok(());
        }
        let both = (self.known.get(one).copied(), self.known.get(other).copied());
        let (Some(a), Some(b)) = both else {
            return Ok(());
        };
        // Checked before anything changes, so that a difference leaves both sets as they were.
        let hard = match (a.hard, b.hard) {
            (Some(a), Some(b)) => Some(a.joined(b).ok_or((a, b))?),
            (a, b) => a.or(b),
        };
        let soft = match (a.soft, b.soft) {
            (Some(a), Some(b)) if a != b => Some(Type::Text),
            (a, b) => a.or(b),
        };
        let (large, small) = if a.size >= b.size {
            (one, other)
        } else {
            (other, one)
        };
        if let Some(known) = self.known.get_mut(small) {
            known.parent = large;
        }
        if let Some(known) = self.known.get_mut(large) {
            (known.hard, known.soft, known.size) = (hard, soft, a.size + b.size);
        }
        Ok(())
    }

    /// The type; text if nothing is known.
    pub(crate) fn of(&self, holder: &Holder) -> Type {
        let index = self.indices.get(holder).map(|index| self.root(*index));
        let known = index.and_then(|index| self.known.get(index));
        known
            // What a script or a model says is certain; the form of an attribute is a guess.
            .and_then(|known| known.hard.or(known.soft))
            .unwrap_or(Type::Text)
    }
}

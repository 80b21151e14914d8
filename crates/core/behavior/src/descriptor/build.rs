//! The state of the loader while it makes the nodes of a file.

use std::collections::{BTreeMap, BTreeSet};

use super::advice;
use super::declared::{Declared, SCOPES, Subtree};
use super::error::Errors;
use super::foreign::LeafType;
use super::json::{Data, Location, Value as Json, shortened};
use super::limits::{MAX_NAME, MAX_TEXT};
use super::literal;
use crate::board::{Access, Board, Scope, Slot};
use crate::finding::Finding;
use crate::tree::{Binding, Host, Library};
use crate::value::{Value, ValueType};

/// The place of a node: its file, and the use of a subtree that it is part of.
pub(super) struct NodeContext<'a> {
    pub file: &'a str,
    /// Ids of the uses of subtrees around it, each with a `/`.
    pub prefix: String,
    /// Ports of the subtree that it is part of.
    pub ports: Option<BTreeMap<&'a str, (ValueType, Binding)>>,
}

/// The state of the loader while it makes the nodes of a file.
pub(super) struct Builder<'a, H: Host> {
    pub library: &'a Library<H>,
    pub constants: BTreeMap<String, Value>,
    pub declared_constants: Vec<Declared<'a>>,
    pub used_constants: BTreeSet<String>,
    pub declared_keys: Vec<(Scope, Declared<'a>)>,
    /// Keys with a wrong declaration; their uses are not reported in addition.
    pub broken_keys: BTreeSet<String>,
    pub subtrees: BTreeMap<&'a str, Subtree<'a>>,
    pub leaves: BTreeMap<&'a str, LeafType<'a>>,
    pub used_subtrees: BTreeSet<&'a str>,
    /// Subtrees around the node that is being made.
    pub open: Vec<&'a str>,
    /// Suffix of ids: the items of each `ForEach` around the node, `[red_1]`.
    pub suffix: String,
    /// Nodes made so far.
    pub nodes: usize,
    pub ids: BTreeMap<String, (&'a str, Location)>,
    pub local: Board,
    pub shared: Board,
    pub errors: Errors,
    pub findings: Vec<Finding>,
    /// Findings of the types of leaves.
    pub noted: Vec<Finding>,
}

impl<'a, H: Host> Builder<'a, H> {
    pub(super) fn new(
        library: &'a Library<H>,
        constants: BTreeMap<String, Value>,
        mut shared: Board,
        errors: Errors,
    ) -> Self {
        // The board of the caller may have clients of other trees with the same node names.
        shared.next_tree();
        Self {
            library,
            constants,
            declared_constants: Vec::new(),
            used_constants: BTreeSet::new(),
            declared_keys: Vec::new(),
            broken_keys: BTreeSet::new(),
            subtrees: BTreeMap::new(),
            leaves: BTreeMap::new(),
            used_subtrees: BTreeSet::new(),
            open: Vec::new(),
            suffix: String::new(),
            nodes: 0,
            ids: BTreeMap::new(),
            local: Board::new(),
            shared,
            errors,
            findings: Vec::new(),
            noted: Vec::new(),
        }
    }

    pub(super) fn board(&mut self, scope: Scope) -> &mut Board {
        match scope {
            Scope::Local => &mut self.local,
            Scope::Shared => &mut self.shared,
        }
    }

    /// The constant with that name; an unknown one is reported.
    fn constant(&mut self, file: &str, place: Location, name: &str) -> Option<Value> {
        if let Some(value) = self.constants.get(name) {
            self.used_constants.insert(name.to_owned());
            return Some(*value);
        }
        let known: Vec<&str> = self.constants.keys().map(String::as_str).collect();
        let message = advice::unknown("constant", name, &known);
        self.errors.push(file, place, message);
        None
    }

    /// The constant if `text` is nothing but `${name}`.
    fn whole_constant(&mut self, file: &str, place: Location, text: &str) -> Option<Value> {
        self.constant(file, place, only_constant(text)?)
    }

    /// `text` with its constants replaced; mistakes are reported.
    pub(super) fn text(&mut self, file: &str, place: Location, text: &str) -> Option<String> {
        // Constants in it may make it longer, so it is limited before they are replaced.
        if text.len() > MAX_TEXT {
            let message = format!(
                "a text of {} bytes, at most {MAX_TEXT} are allowed",
                text.len()
            );
            self.errors.push(file, place, message);
            return None;
        }
        let mut replaced = String::with_capacity(text.len());
        let mut rest = text;
        while let Some((before, after)) = rest.split_once("${") {
            let Some((name, after)) = after.split_once('}') else {
                let message = "'${' without '}'; write '${name}' to use a constant";
                self.errors.push(file, place, message);
                return None;
            };
            let value = self.constant(file, place, name)?;
            // A list has no form within a text that a reader would recognise.
            let Some(word) = literal::within_text(value) else {
                let message = format!(
                    "constant '{name}' is a list and cannot be part of a text; use it alone"
                );
                self.errors.push(file, place, message);
                return None;
            };
            replaced.push_str(before);
            replaced.push_str(&word);
            rest = after;
        }
        replaced.push_str(rest);
        Some(replaced)
    }

    /// The literal `json` as that type; mistakes are reported.
    pub(super) fn literal(&mut self, file: &str, json: &Json, wanted: ValueType) -> Option<Value> {
        match &json.data {
            // A text that is only a constant keeps the type of the constant: `${speed}` is a
            // number.
            Data::Text(text) if only_constant(text).is_some() => {
                let value = self.whole_constant(file, json.place, text)?;
                self.coerced(file, json.place, value, wanted)
            }
            Data::Text(text) if text.contains("${") => {
                let data = Data::Text(self.text(file, json.place, text)?);
                let place = json.place;
                self.plain(file, &Json { place, data }, wanted)
            }
            _ => self.plain(file, json, wanted),
        }
    }

    /// The literal `json` with the type that its form implies.
    pub(super) fn any_literal(&mut self, file: &str, json: &Json) -> Option<Value> {
        if let Some(text) = json.as_text() {
            return match only_constant(text) {
                Some(_) => self.whole_constant(file, json.place, text),
                None => self.literal(file, json, ValueType::Text),
            };
        }
        match literal::untyped(json) {
            Ok(value) => Some(value),
            Err(message) => {
                self.errors.push(file, json.place, message);
                None
            }
        }
    }

    fn plain(&mut self, file: &str, json: &Json, wanted: ValueType) -> Option<Value> {
        match literal::typed(json, wanted) {
            Ok(value) => Some(value),
            Err(message) => {
                self.errors.push(file, json.place, message);
                None
            }
        }
    }

    fn coerced(
        &mut self,
        file: &str,
        place: Location,
        value: Value,
        wanted: ValueType,
    ) -> Option<Value> {
        let coerced = literal::coerced(value, wanted);
        if coerced.is_none() {
            let wanted = literal::wanted(wanted);
            let message = format!("{wanted} is needed here, this is {value}");
            self.errors.push(file, place, message);
        }
        coerced
    }

    /// The binding of a port to `json`, for a port of that type, or of any.
    pub(super) fn binding(
        &mut self,
        context: &NodeContext<'a>,
        json: &Json,
        wanted: Option<ValueType>,
    ) -> Option<Binding> {
        let Data::Object(entries) = &json.data else {
            return match wanted {
                Some(wanted) => self.literal(context.file, json, wanted),
                None => self.any_literal(context.file, json),
            }
            .map(Binding::Literal);
        };
        match entries.as_slice() {
            [entry] if entry.key == "bb" => self.key(context.file, &entry.value, wanted),
            [entry] if entry.key == "port" => self.outer_port(context, &entry.value, wanted),
            _ => {
                let message = "a value, {\"bb\": \"local.KEY\"}, {\"bb\": \"shared.KEY\"} or, in a \
                               subtree, {\"port\": \"NAME\"} is needed here, this is another object";
                self.errors.push(context.file, json.place, message);
                None
            }
        }
    }

    /// The key with the name `json`, `local.KEY` or `shared.KEY`.
    fn key(&mut self, file: &str, json: &Json, wanted: Option<ValueType>) -> Option<Binding> {
        let Some(text) = json.as_text() else {
            let message = format!(
                "a key like 'local.KEY' is needed here, this is {}",
                json.describe()
            );
            self.errors.push(file, json.place, message);
            return None;
        };
        let name = self.text(file, json.place, text)?;
        let (scope, key) = match name.split_once('.') {
            Some(("local", key)) => (Scope::Local, key),
            Some(("shared", key)) => (Scope::Shared, key),
            other => {
                let found = other.map_or(name.as_str(), |(scope, _)| scope);
                let scope = advice::unknown("blackboard", found, SCOPES);
                let message = format!("{scope}; write 'local.KEY' or 'shared.KEY'");
                self.errors.push(file, json.place, message);
                return None;
            }
        };
        // Its declaration is wrong and was reported; each use would repeat the same mistake.
        if self.broken_keys.contains(key) {
            return None;
        }
        let board = self.board(scope);
        let Some(found) = board.index(key).and_then(|i| board.keys().nth(i)) else {
            let known: Vec<&str> = board.keys().map(|k| k.name.as_str()).collect();
            let what = match scope {
                Scope::Local => "local blackboard key",
                Scope::Shared => "shared blackboard key",
            };
            let message = advice::unknown(what, key, &known);
            self.errors.push(file, json.place, message);
            return None;
        };
        let found = found.value_type;
        match wanted {
            Some(wanted) if wanted != found => {
                let message = format!(
                    "blackboard key '{}' is of type {}, the port needs {}",
                    shortened(key),
                    found.name(),
                    wanted.name()
                );
                self.errors.push(file, json.place, message);
                None
            }
            _ => Some(Binding::Key(scope, key.to_owned())),
        }
    }

    /// The binding of the port `json` of the subtree around.
    fn outer_port(
        &mut self,
        context: &NodeContext<'a>,
        json: &Json,
        wanted: Option<ValueType>,
    ) -> Option<Binding> {
        let (file, place) = (context.file, json.place);
        let Some(name) = json.as_text() else {
            let message = format!(
                "the name of a port is needed here, this is {}",
                json.describe()
            );
            self.errors.push(file, place, message);
            return None;
        };
        let Some(ports) = &context.ports else {
            self.errors
                .push(file, place, "only a subtree has ports to take a value from");
            return None;
        };
        let Some((found, binding)) = ports.get(name) else {
            let known: Vec<&str> = ports.keys().copied().collect();
            self.errors.push(
                file,
                place,
                advice::unknown("port of this subtree", name, &known),
            );
            return None;
        };
        match (binding, wanted) {
            // A literal of an integer fits a port for numbers; the type of a key has to be the
            // same, as it is written by others.
            (Binding::Literal(value), Some(wanted)) => self
                .coerced(file, place, *value, wanted)
                .map(Binding::Literal),
            (Binding::Key(..), Some(wanted)) if wanted != *found => {
                let message = format!(
                    "port '{}' of this subtree is of type {}, {} is needed",
                    shortened(name),
                    found.name(),
                    wanted.name()
                );
                self.errors.push(file, place, message);
                None
            }
            (binding, _) => Some(binding.clone()),
        }
    }

    /// Registers that `node` uses a key, and returns its slot and its type.
    pub(super) fn register(
        &mut self,
        at: (&str, Location),
        node: &str,
        (scope, key): (Scope, &str),
        access: Access,
    ) -> Option<(Slot, ValueType)> {
        let board = self.board(scope);
        let known = board.index(key).and_then(|i| board.keys().nth(i));
        let value_type = known.map(|k| k.value_type)?;
        match board.register(node, key, value_type, access) {
            Ok(index) => Some((Slot { scope, index }, value_type)),
            Err(error) => {
                self.errors.push(at.0, at.1, error.to_string());
                None
            }
        }
    }

    /// A name of at most [`MAX_NAME`] bytes with its constants replaced.
    pub(super) fn name(&mut self, file: &str, json: &Json) -> Option<String> {
        let Some(text) = json.as_text() else {
            let message = format!("a text is needed here, this is {}", json.describe());
            self.errors.push(file, json.place, message);
            return None;
        };
        let name = self.text(file, json.place, text)?;
        if name.is_empty() || name.len() > MAX_NAME || name.chars().any(char::is_control) {
            let message = format!(
                "a name has 1 to {MAX_NAME} bytes and no control characters, this is {}",
                json.describe()
            );
            self.errors.push(file, json.place, message);
            return None;
        }
        Some(name)
    }
}

/// The `name` in `${name}`.
pub(super) fn only_constant(text: &str) -> Option<&str> {
    let name = text.strip_prefix("${")?.strip_suffix('}')?;
    (!name.contains(['$', '{', '}'])).then_some(name)
}

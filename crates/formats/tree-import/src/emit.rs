//! Writes the tree file, when the types of all keys are known.

use behavior::descriptor::limits::{MAX_ENTRIES, MAX_NAME, MAX_PORTS};
use behavior::descriptor::{Errors, FORMAT};
use serde_json::Value;

use crate::bind::{no_text, number, shortest, truth};
use crate::document::Project;
use crate::out::{At, Bind, LeafUse, Out};
use crate::provided::{self, Provided};
use crate::script::Constant;
use crate::translate::{Key, Translated, Tree};
use crate::types::{Holder, Type};
use crate::write::{self, Json};
use crate::{Imported, Leaf};

/// Writes the file.
pub(crate) fn file(
    project: &Project,
    translated: &Translated,
    provided: &Provided,
) -> Result<Imported, Errors> {
    let mut emitter = Emitter {
        main: &project.main,
        translated,
        errors: Errors::default(),
    };
    let mut entries = vec![
        ("format".to_owned(), FORMAT.into()),
        ("name".to_owned(), project.main.as_str().into()),
    ];
    if let Some(include) = &provided.include {
        let list = Json::List(vec![include.as_str().into()]);
        entries.push(("includes".to_owned(), list));
    }
    let Some(main) = translated.trees.get(&project.main) else {
        return Err(emitter.errors);
    };
    // Unused trees are left out: their keys and leaves would be needed without being run.
    let used = used(translated, &project.main);
    let keys = emitter.keys(&project.main, main);
    if !keys.is_empty() {
        let local = Json::Object(vec![("local".to_owned(), Json::Object(keys))]);
        entries.push(("blackboard".to_owned(), local));
    }
    let leaves = emitter.leaves();
    if !leaves.is_empty() {
        entries.push(("leaves".to_owned(), Json::Object(leaves)));
    }
    let mut subtrees = Vec::new();
    // In the order in which the trees were completed: a tree after those that it uses.
    for name in used.iter().filter(|name| **name != project.main) {
        if let Some(tree) = translated.trees.get(name) {
            emitter.unlike_provided(name, project, provided);
            subtrees.push((name.clone(), emitter.subtree(name, tree)));
        }
    }
    if !subtrees.is_empty() {
        entries.push(("subtrees".to_owned(), Json::Object(subtrees)));
    }
    entries.push(("root".to_owned(), emitter.node(&project.main, &main.root)));
    let mut notes = project.notes.clone();
    // The author learns what was left out: a misspelt name of a tree would be invisible.
    let unused = translated.order.iter().filter(|name| !used.contains(name));
    notes.extend(
        unused.map(|name| format!("the tree '{name}' is not used by the main tree; left out")),
    );
    let imported = Imported {
        json: write::text(&Json::Object(entries)),
        leaves: emitter.needed(),
        notes,
    };
    emitter.errors.or(imported)
}

/// The trees that the main tree uses, in the order of their completion.
fn used(translated: &Translated, main: &str) -> Vec<String> {
    fn visit(out: &Out, translated: &Translated, open: &mut Vec<String>) {
        if let Some(name) = &out.subtree
            && !open.contains(name)
        {
            open.push(name.clone());
            if let Some(tree) = translated.trees.get(name) {
                visit(&tree.root, translated, open);
            }
        }
        out.children
            .iter()
            .for_each(|child| visit(child, translated, open));
    }
    let mut open = vec![main.to_owned()];
    if let Some(tree) = translated.trees.get(main) {
        visit(&tree.root, translated, &mut open);
    }
    let order = translated.order.iter();
    order.filter(|name| open.contains(name)).cloned().collect()
}

struct Emitter<'t> {
    main: &'t str,
    translated: &'t Translated,
    errors: Errors,
}

impl Emitter<'_> {
    fn refuse(&mut self, at: &At, why: &str) {
        let message = format!("{}: {why}", at.node);
        self.errors.push(&at.file, at.place, message);
    }

    /// Refuses a subtree with the name of a provided one: the names of both files are one set.
    fn unlike_provided(&mut self, name: &str, project: &Project, provided: &Provided) {
        let trees = project.trees.iter();
        if let Some(signature) = provided.subtrees.get(name)
            && let Some((_, root)) = trees.into_iter().find(|(tree, _)| tree == name)
        {
            let own = provided::named(name, signature);
            let message = format!("tree '{name}' has the name of {own}; rename one of them");
            self.errors.push(&root.file, root.place, message);
        }
    }

    fn keys(&mut self, tree: &str, read: &Tree) -> Vec<(String, Json)> {
        let keys = read.keys.iter();
        let keys: Vec<_> = keys
            .map(|(name, key)| self.declared(tree, name, key))
            .collect();
        // Keys of the main tree are on its board; those of a subtree are ports of its uses.
        let most = if tree == self.main {
            MAX_ENTRIES
        } else {
            MAX_PORTS
        };
        let long = keys.iter().any(|(name, _)| name.len() > MAX_NAME);
        if keys.len() > most || long {
            let message = format!(
                "tree '{tree}' has {} keys on its blackboard, with those of its subtrees; at most \
                 {most} with names of at most {MAX_NAME} bytes have room",
                keys.len()
            );
            let place = behavior::descriptor::json::Location::START;
            self.errors.push(tree, place, message);
        }
        keys
    }

    fn declared(&mut self, tree: &str, name: &str, key: &Key) -> (String, Json) {
        let of = Holder::Key {
            tree: tree.to_owned(),
            key: name.to_owned(),
        };
        let value_type = self.translated.types.of(&of);
        let mut entries = vec![("type".to_owned(), value_type.name().into())];
        // Ports of subtrees get the first value of each use, so only keys of the main tree have
        // one.
        if tree == self.main
            && let Some((text, at)) = &key.default
            && let Some(value) = self.typed(text, value_type, at)
        {
            entries.push(("default".to_owned(), Json::Value(value)));
        }
        (name.to_owned(), Json::Object(entries))
    }

    fn leaves(&mut self) -> Vec<(String, Json)> {
        let translated = self.translated;
        let leaves = translated.leaves.iter();
        leaves
            .map(|(name, leaf)| (name.clone(), self.leaf(name, leaf)))
            .collect()
    }

    fn leaf(&mut self, name: &str, leaf: &LeafUse) -> Json {
        let mut entries = Vec::new();
        if leaf.condition {
            entries.push(("condition".to_owned(), true.into()));
        }
        let mut ports = Vec::new();
        for (port, known) in &leaf.ports {
            let (value_type, type_name) = self.port_type(name, port);
            let mut entries = vec![
                ("type".to_owned(), type_name.into()),
                ("access".to_owned(), known.access().into()),
            ];
            // The literals of a port for any type have different types; the default has that of
            // its text.
            let value_type = match type_name {
                "any" => known
                    .default
                    .as_ref()
                    .map_or(value_type, |(text, _)| Type::of_text(text)),
                _ => value_type,
            };
            if let Some((text, at)) = &known.default
                // A port that is only written has no use for a default.
                && known.access() != "write"
                && let Some(value) = self.typed(text, value_type, at)
            {
                entries.push(("default".to_owned(), Json::Value(value)));
            }
            ports.push((port.clone(), Json::Object(entries)));
        }
        if !ports.is_empty() {
            entries.push(("ports".to_owned(), Json::Object(ports)));
        }
        Json::Object(entries)
    }

    /// The type of a port, and its name.
    fn port_type(&self, leaf: &str, port: &str) -> (Type, &'static str) {
        let (types, port) = (&self.translated.types, Holder::port(leaf, port));
        let value_type = types.of(&port);
        if types.is_any(&port) {
            return (value_type, "any");
        }
        (value_type, value_type.name())
    }

    /// The leaves that a program has to provide.
    fn needed(&self) -> Vec<Leaf> {
        let leaves = self.translated.leaves.iter();
        leaves
            .map(|(name, leaf)| Leaf {
                name: name.clone(),
                condition: leaf.condition,
                place: leaf.place.clone(),
                ports: leaf
                    .ports
                    .iter()
                    .map(|(port, known)| {
                        (port.clone(), self.port_type(name, port).1, known.access())
                    })
                    .collect(),
            })
            .collect()
    }

    fn subtree(&mut self, name: &str, tree: &Tree) -> Json {
        let mut entries = Vec::new();
        let ports = self.keys(name, tree);
        if !ports.is_empty() {
            entries.push(("ports".to_owned(), Json::Object(ports)));
        }
        entries.push(("root".to_owned(), self.node(name, &tree.root)));
        Json::Object(entries)
    }

    fn node(&mut self, tree: &str, out: &Out) -> Json {
        let mut entries: Vec<(String, Json)> = vec![
            ("id".to_owned(), out.id.as_str().into()),
            ("type".to_owned(), out.kind.as_str().into()),
        ];
        if let Some(name) = &out.name {
            entries.push(("name".to_owned(), name.as_str().into()));
        }
        if let Some(subtree) = &out.subtree {
            entries.push(("subtree".to_owned(), subtree.as_str().into()));
        }
        let ports = out.ports.iter();
        let ports: Vec<_> = ports
            .filter_map(|(name, bind)| self.port(tree, name, bind))
            .collect();
        if !ports.is_empty() {
            entries.push(("ports".to_owned(), Json::Object(ports)));
        }
        if !out.modifiers.is_empty() {
            let modifiers = out.modifiers.iter().cloned().map(Json::Value);
            entries.push(("modifiers".to_owned(), Json::List(modifiers.collect())));
        }
        if !out.children.is_empty() {
            let children = out.children.iter().map(|child| self.node(tree, child));
            entries.push(("children".to_owned(), Json::List(children.collect())));
        }
        Json::Object(entries)
    }

    fn port(&mut self, tree: &str, name: &str, bind: &Bind) -> Option<(String, Json)> {
        let value = match bind {
            Bind::Fixed(value) => value.clone(),
            Bind::Key(key) => {
                // Keys of a subtree are its ports, so each use binds them to keys of the tree
                // around it.
                let (word, key) = if tree == self.main {
                    ("bb", format!("local.{key}"))
                } else {
                    ("port", key.clone())
                };
                let entry = vec![(word.to_owned(), Json::Value(key.into()))];
                return Some((name.to_owned(), Json::Object(entry)));
            }
            Bind::Text(text, of, at) => {
                let types = &self.translated.types;
                let any = types.is_any(of).then(|| Type::of_text(text));
                let value_type = any.unwrap_or_else(|| types.of(of));
                self.typed(text, value_type, at)?
            }
            Bind::Constant(constant, of, at) => {
                let value_type = self.translated.types.of(of);
                self.constant(constant, value_type, at)?
            }
            // A number is true if it is not 0, as in scripts.
            Bind::True(of, at) => match self.translated.types.of(of) {
                Type::Bool => true.into(),
                Type::Number => return Some(("differs".to_owned(), 0.into())),
                Type::Text => {
                    let why = "a text is neither true nor false; compare the key with a text, or \
                               set it to true or false somewhere";
                    self.refuse(at, why);
                    return None;
                }
            },
        };
        Some((name.to_owned(), Json::Value(value)))
    }

    /// The text of an attribute as a value of its type.
    fn typed(&mut self, text: &str, value_type: Type, at: &At) -> Option<Value> {
        let word = text.trim();
        let value = match (value_type, word) {
            (Type::Text, _) => return self.text(text, at),
            (Type::Bool, word) => truth(word),
            (Type::Number, "true") => Some(1.into()),
            (Type::Number, "false") => Some(0.into()),
            (Type::Number, word) => number(word),
        };
        if value.is_none() {
            let why = format!("'{text}' is not a {}, as elsewhere", value_type.name());
            self.refuse(at, &why);
        }
        value
    }

    fn constant(&mut self, constant: &Constant, value_type: Type, at: &At) -> Option<Value> {
        match (constant, value_type) {
            (Constant::Bool(value), Type::Bool) => Some((*value).into()),
            (Constant::Bool(value), _) => Some(u8::from(*value).into()),
            (Constant::Number(value), _) => Some(shortest(*value)),
            (Constant::Text(text), _) => self.text(text, at),
        }
    }

    fn text(&mut self, text: &str, at: &At) -> Option<Value> {
        let Some(why) = no_text(text) else {
            return Some(text.into());
        };
        self.refuse(at, &why);
        None
    }
}

//! Uses of trees by other trees, and the keys that they share.

use behavior::suggest;

use crate::bind::{self, Value};
use crate::document::Element;
use crate::out::{At, Bind};
use crate::translate::{Key, Part, Translator};
use crate::types::Holder;

impl Translator<'_> {
    pub(crate) fn subtree(&mut self, element: &Element) -> Option<Part> {
        let Some(name) = element.get("ID") else {
            self.refuse(element, "<SubTree> needs ID=\"TREE\"");
            return None;
        };
        if !element.children.is_empty() {
            let why = "a SubTree has no children; <remap internal=\"A\" external=\"B\"/> of version 3 is \
                       A=\"{B}\" in version 4";
            self.refuse(element, why);
            return None;
        }
        let project = self.project;
        let Some((_, root)) = project.trees.iter().find(|(tree, _)| tree == name) else {
            let known: Vec<&str> = project
                .trees
                .iter()
                .map(|(tree, _)| tree.as_str())
                .collect();
            let advice = suggest::advice(name, &known);
            self.refuse(element, format!("unknown BehaviorTree '{name}'; {advice}"));
            return None;
        };
        // Translated trees are found in `trees`; only those that are not complete are `open`.
        if self.open.iter().any(|open| open == name) {
            let circle = [self.open.join(" -> "), name.to_owned()].join(" -> ");
            self.refuse(element, format!("a tree is part of itself: {circle}"));
            return None;
        }
        // The subtree first: its keys are the ports of this use.
        self.tree(name, root);
        let inner = self.trees.get(name).and_then(Option::as_ref)?;
        let keys: Vec<(String, Key)> = inner
            .keys
            .iter()
            .map(|(key, known)| (key.clone(), known.clone()))
            .collect();
        let mut out = self.out(element, "Subtree", Vec::new());
        out.subtree = Some(name.to_owned());
        for (key, known) in keys {
            let bind = self.shared_key(element, (name, &out.id), &key, &known);
            out = out.bound(&key, bind);
        }
        Some(Part::of(out))
    }

    /// The binding of a key of a subtree where it is used.
    fn shared_key(
        &mut self,
        element: &Element,
        (tree, id): (&str, &str),
        key: &str,
        known: &Key,
    ) -> Bind {
        let at = At::of(element);
        let inner = Holder::Key {
            tree: tree.to_owned(),
            key: key.to_owned(),
        };
        // Values with which BehaviorTree.CPP switches it on.
        let remaps = matches!(element.get("_autoremap"), Some("1" | "true" | "True"));
        let given = element.get(key).filter(|_| key != "ID" && key != "name");
        let model = self
            .project
            .models
            .get(tree)
            .map(|model| model.ports.as_slice());
        let model = model
            .unwrap_or_default()
            .iter()
            .find(|port| port.name == key);
        // The model of a subtree may give the default of its port.
        let given = given.or_else(|| model.and_then(|port| port.default.as_deref()));
        let outer = match given.map(|text| bind::value(key, text)) {
            // `@key` belongs to the outermost tree, and is passed through every use on the way.
            _ if key.starts_with('@') => self.key(key, known.written),
            Some(Value::Key(outer)) => self.key(outer, known.written),
            // A literal is enough for a key that is only read by leaves.
            Some(Value::Text(text)) if !known.written && !known.tested => {
                self.types.looks_like(&inner, text);
                return Bind::Text(text.to_owned(), inner, at);
            }
            // Otherwise it is the first value of a key for this use.
            Some(Value::Text(text)) => {
                self.types.looks_like(&inner, text);
                let default = Some((text.to_owned(), at.clone()));
                self.own_key(id, key, known.written, default)
            }
            // `_autoremap` shares keys of the same name, except private ones with a leading
            // `_`.
            None if remaps && !known.inner && !key.starts_with('_') => self.key(key, known.written),
            None => self.own_key(id, key, known.written, known.default.clone()),
        };
        if let Some(own) = self.scope.keys.get_mut(&outer) {
            own.tested |= known.tested;
        }
        let of_outer = self.holder(&outer);
        // Both names are one key at run time, so their types have to agree.
        if let Err((before, found)) = self.types.same(&of_outer, &inner) {
            self.mixed(&at, &outer, before, found);
        }
        Bind::Key(outer)
    }

    /// A key for one use of a subtree.
    fn own_key(
        &mut self,
        id: &str,
        key: &str,
        written: bool,
        default: Option<(String, At)>,
    ) -> String {
        // With the id of the use in its name: two uses of one tree must not share it.
        let name = self.key(&format!("{id}.{key}"), written);
        if let Some(own) = self.scope.keys.get_mut(&name) {
            own.inner = true;
            own.default = default;
        }
        name
    }
}

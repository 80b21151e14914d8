//! Translates elements to nodes, tree by tree.

use std::collections::{BTreeMap, BTreeSet};

use behavior::descriptor::Errors;
use behavior::descriptor::limits::{MAX_DEPTH, MAX_NAME, MAX_NODES};

use crate::document::{Element, Project};
use crate::out::{At, LeafUse, Out};
use crate::provided::{BoundKey, Provided};
use crate::types::{Holder, Types};

/// The effect of a skipped node on its parent: our nodes cannot return SKIPPED.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Skip {
    /// It continues as after a success.
    Success,
    /// It continues as after a failure.
    Failure,
    /// An effect that no result of ours has.
    Never,
}

/// A node, and whether it may be skipped.
pub(crate) struct Part {
    pub out: Out,
    pub skips: bool,
}

impl Part {
    pub(crate) fn of(out: Out) -> Self {
        Self { out, skips: false }
    }
}

/// A key of the blackboard of one tree.
#[derive(Clone, Debug, Default)]
pub(crate) struct Key {
    pub written: bool,
    /// A node of the engine tests it, so a literal is not sufficient.
    pub tested: bool,
    /// Its initial value, as text.
    pub default: Option<(String, At)>,
    /// It belongs to a subtree, and is not shared.
    pub inner: bool,
}

/// A tree that is translated.
#[derive(Debug)]
pub(crate) struct Tree {
    pub root: Out,
    pub keys: BTreeMap<String, Key>,
}

/// The tree that is being translated.
#[derive(Default)]
pub(crate) struct Scope {
    pub name: String,
    pub keys: BTreeMap<String, Key>,
    ids: BTreeSet<String>,
    nodes: usize,
}

/// The state of the translation.
pub(crate) struct Translator<'p> {
    pub project: &'p Project,
    pub provided: &'p Provided,
    /// Keys bound to ports of provided leaves, whose types are compared at the end.
    pub bound: Vec<BoundKey>,
    pub types: Types,
    pub errors: Errors,
    /// Translated trees; `None` for refused ones.
    pub trees: BTreeMap<String, Option<Tree>>,
    /// Trees in the order of their completion.
    pub order: Vec<String>,
    pub open: Vec<String>,
    pub leaves: BTreeMap<String, LeafUse>,
    pub scope: Scope,
}

/// The result of [`all`].
pub(crate) struct Translated {
    pub types: Types,
    pub trees: BTreeMap<String, Tree>,
    pub order: Vec<String>,
    pub leaves: BTreeMap<String, LeafUse>,
}

/// Translates all trees of a file, including trees that the main tree does not use.
pub(crate) fn all(project: &Project, provided: &Provided) -> Result<Translated, Errors> {
    let mut translator = Translator {
        project,
        provided,
        bound: Vec::new(),
        types: Types::default(),
        errors: Errors::default(),
        trees: BTreeMap::new(),
        order: Vec::new(),
        open: Vec::new(),
        leaves: BTreeMap::new(),
        scope: Scope::default(),
    };
    for (name, root) in &project.trees {
        translator.tree(name, root);
    }
    let Translator {
        mut types,
        mut errors,
        bound,
        trees,
        order,
        leaves,
        ..
    } = translator;
    // Types of literals and keys are compared at the end: a later use may determine the type.
    types.finish();
    for key in &bound {
        key.check(&types, &mut errors);
    }
    let trees = trees.into_iter();
    errors.or(Translated {
        types,
        trees: trees
            .filter_map(|(name, tree)| Some((name, tree?)))
            .collect(),
        order,
        leaves,
    })
}

impl Translator<'_> {
    /// Translates one tree, once.
    pub(crate) fn tree(&mut self, name: &str, root: &Element) {
        // A tree that several others use has one translation.
        if self.trees.contains_key(name) {
            return;
        }
        let scope = Scope {
            name: name.to_owned(),
            ..Scope::default()
        };
        // The scope of the outer tree is put aside: each tree has its own keys and ids.
        let outer = std::mem::replace(&mut self.scope, scope);
        self.open.push(name.to_owned());
        let part = self.node(root, Skip::Never, 0);
        self.open.pop();
        let inner = std::mem::replace(&mut self.scope, outer);
        let tree = part.map(|part| Tree {
            root: part.out,
            keys: inner.keys,
        });
        self.trees.insert(name.to_owned(), tree);
        self.order.push(name.to_owned());
    }

    pub(crate) fn refuse(&mut self, element: &Element, why: impl AsRef<str>) {
        let message = format!("{}: {}", At::of(element).node, why.as_ref());
        self.errors.push(&element.file, element.place, message);
    }

    /// A node with everything below it. The recursion is limited by [`MAX_DEPTH`].
    pub(crate) fn node(&mut self, element: &Element, skip: Skip, depth: usize) -> Option<Part> {
        if depth >= MAX_DEPTH {
            let why = format!("nodes are nested deeper than {MAX_DEPTH} levels");
            self.refuse(element, why);
            return None;
        }
        self.scope.nodes += 1;
        // Reported once, at the first node beyond the limit.
        if self.scope.nodes > MAX_NODES {
            if self.scope.nodes == MAX_NODES + 1 {
                let why = format!("the tree has more than {MAX_NODES} nodes; this is one too many");
                self.refuse(element, why);
            }
            return None;
        }
        let around = self.around(element);
        let skip_inside = match &around {
            // A script after the node does not run when the node is skipped.
            Some(around) if around.has_scripts() => Skip::Never,
            _ => skip,
        };
        let part = self.body(element, skip_inside, depth);
        // Both are evaluated before one is tested, so that all refusals are reported.
        self.surrounded(element, part?, &around?, skip)
    }

    /// A unique id for a node of this tree.
    pub(crate) fn id(&mut self, wanted: &str) -> String {
        let wrong = |c: char| c.is_whitespace() || c.is_control() || c == '/';
        // Characters that our ids do not allow are replaced.
        let clean = wanted.trim().replace(wrong, "_");
        // Room for the number, and for the suffixes of wrappers.
        let mut end = clean.len().min(MAX_NAME - 48);
        while !clean.is_char_boundary(end) {
            end -= 1;
        }
        let clean = match clean.get(..end) {
            None | Some("") => "node",
            Some(clean) => clean,
        };
        let mut id = clean.to_owned();
        let mut number = 2;
        // Nodes of one name are numbered: state in a checkpoint is found by the id.
        while !self.scope.ids.insert(id.clone()) {
            id = format!("{clean}_{number}");
            number += 1;
        }
        id
    }

    /// A node for an element, with an id made from its name.
    pub(crate) fn out(&mut self, element: &Element, kind: &str, children: Vec<Out>) -> Out {
        let name = element.get("name").filter(|name| !name.trim().is_empty());
        // The name of the tree is more specific than the word SubTree.
        let tree = element.get("ID").filter(|_| element.tag == "SubTree");
        let id = self.id(name.or(tree).unwrap_or(element.node_type()));
        let mut out = Out::new(id, kind, children);
        out.name = name
            .filter(|name| *name != out.id && name.len() <= MAX_NAME)
            .map(str::to_owned);
        out
    }

    /// The key with that name of the tree that is being translated.
    pub(crate) fn key(&mut self, name: &str, written: bool) -> String {
        // `@key` is a key of the outermost tree.
        let name = match name.strip_prefix('@') {
            Some(outermost) if self.scope.name == self.project.main => outermost,
            _ => name,
        };
        let key = self.scope.keys.entry(name.to_owned()).or_default();
        key.written |= written;
        name.to_owned()
    }

    pub(crate) fn holder(&self, key: &str) -> Holder {
        Holder::Key {
            tree: self.scope.name.clone(),
            key: key.to_owned(),
        }
    }

    /// The only child of a decorator.
    pub(crate) fn child(&mut self, element: &Element, skip: Skip, depth: usize) -> Option<Part> {
        match element.children.as_slice() {
            [child] => self.node(child, skip, depth + 1),
            children => {
                let found = children.len();
                self.refuse(
                    element,
                    format!("exactly one child is needed, here are {found}"),
                );
                None
            }
        }
    }

    /// All children; `None` if one is refused, after all were translated.
    pub(crate) fn children(
        &mut self,
        element: &Element,
        skip: Skip,
        depth: usize,
    ) -> Option<Vec<Part>> {
        if element.children.is_empty() {
            self.refuse(element, "it has no children, at least one is needed");
            return None;
        }
        let children = element.children.iter();
        let parts: Vec<_> = children
            .map(|child| self.node(child, skip, depth + 1))
            .collect();
        parts.into_iter().collect()
    }
}

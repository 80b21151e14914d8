//! From elements to nodes, tree by tree.

use std::collections::{BTreeMap, BTreeSet};

use behavior::descriptor::Errors;
use behavior::descriptor::limits::{MAX_DEPTH, MAX_NAME, MAX_NODES};

use crate::document::{Element, Project};
use crate::leaves::LeafUse;
use crate::out::{At, Out};
use crate::provided::{BoundKey, Provided};
use crate::types::{Holder, Types};

/// What the node around one makes of it when it is skipped: there is no such answer here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Skip {
    /// It continues as after a success.
    Success,
    /// It continues as after a failure.
    Failure,
    /// Something that no answer stands for.
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
    /// A node of the engine tests it: a literal does not do.
    pub tested: bool,
    /// The value it has at first, as text.
    pub default: Option<(String, At)>,
    /// It belongs to a subtree, which does not share it.
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

/// See the module.
pub(crate) struct Translator<'p> {
    pub project: &'p Project,
    pub provided: &'p Provided,
    /// Keys of ports of provided leaves: their types have to be the same in the end.
    pub bound: Vec<BoundKey>,
    pub types: Types,
    pub errors: Errors,
    /// Translated trees; `None` for those that are refused.
    pub trees: BTreeMap<String, Option<Tree>>,
    /// In the order in which they were completed.
    pub order: Vec<String>,
    pub open: Vec<String>,
    pub leaves: BTreeMap<String, LeafUse>,
    pub scope: Scope,
}

/// What [`all`] found.
pub(crate) struct Translated {
    pub types: Types,
    pub trees: BTreeMap<String, Tree>,
    pub order: Vec<String>,
    pub leaves: BTreeMap<String, LeafUse>,
}

/// Translates all trees of a file: those that the main tree does not use are checked, too.
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
        if self.trees.contains_key(name) {
            return;
        }
        let scope = Scope {
            name: name.to_owned(),
            ..Scope::default()
        };
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

    /// A node with everything below it. Recursion ends at [`MAX_DEPTH`].
    pub(crate) fn node(&mut self, element: &Element, skip: Skip, depth: usize) -> Option<Part> {
        if depth >= MAX_DEPTH {
            let why = format!("nodes are nested deeper than {MAX_DEPTH} levels");
            self.refuse(element, why);
            return None;
        }
        self.scope.nodes += 1;
        if self.scope.nodes > MAX_NODES {
            if self.scope.nodes == MAX_NODES + 1 {
                let why = format!("the tree has more than {MAX_NODES} nodes; this is one too many");
                self.refuse(element, why);
            }
            return None;
        }
        let around = self.around(element);
        let skip_inside = match &around {
            // A script after the node does not run when it is skipped.
            Some(around) if around.has_scripts() => Skip::Never,
            _ => skip,
        };
        let part = self.body(element, skip_inside, depth);
        self.surrounded(element, part?, &around?, skip)
    }

    /// An id for a node, which no other of this tree has.
    pub(crate) fn id(&mut self, wanted: &str) -> String {
        let wrong = |c: char| c.is_whitespace() || c.is_control() || c == '/';
        let clean = wanted.trim().replace(wrong, "_");
        // Room for the number, and for what wrappers add.
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
        while !self.scope.ids.insert(id.clone()) {
            id = format!("{clean}_{number}");
            number += 1;
        }
        id
    }

    /// A node for an element, with an id made from its name.
    pub(crate) fn out(&mut self, element: &Element, kind: &str, children: Vec<Out>) -> Out {
        let name = element.get("name").filter(|name| !name.trim().is_empty());
        // The tree says more than the word SubTree.
        let tree = element.get("ID").filter(|_| element.tag == "SubTree");
        let id = self.id(name.or(tree).unwrap_or(element.node_type()));
        let mut out = Out::new(id, kind, children);
        out.name = name
            .filter(|name| *name != out.id && name.len() <= MAX_NAME)
            .map(str::to_owned);
        out
    }

    /// The key of that name of the tree that is being translated.
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

    /// All children; `None` where one is refused, after all were looked at.
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

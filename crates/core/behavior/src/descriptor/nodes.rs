//! Nodes of a file, including those below them.

use super::build::{Builder, NodeContext};
use super::detail::detail;
use super::engine::{self, Children};
use super::files::{get, object};
use super::json::{Entry, Location, Value as Json, shortened};
use super::kinds::At;
use super::limits::{MAX_DEPTH, MAX_NAME, MAX_NODES};
use super::types::Found;
use crate::finding::Finding;
use crate::tree::{Host, Kind, Node};

/// Keys of a node.
pub(super) const NODE_KEYS: &[&str] = &[
    "id",
    "type",
    "name",
    "doc",
    "ports",
    "modifiers",
    "children",
    "subtree",
    "guard",
    "as",
    "items",
];
/// Keys of the guard of a node.
pub(super) const GUARD_KEYS: &[&str] = &["type", "doc", "ports"];

/// A node's place in the tree.
#[derive(Clone, Copy)]
pub(super) struct Seat<'n> {
    /// Id of its parent; empty for the root.
    pub parent: &'n str,
    /// Its index among the children.
    pub index: usize,
    pub depth: usize,
}

impl Seat<'_> {
    pub(super) const ROOT: Seat<'static> = Seat {
        parent: "",
        index: 0,
        depth: 0,
    };
}

impl<'a, H: Host> Builder<'a, H> {
    /// The node `json` with all nodes below it. `None` for a mistake,
    /// which is reported. The recursion is limited by [`MAX_DEPTH`], the work by
    /// [`MAX_NODES`].
    pub(super) fn node(
        &mut self,
        context: &NodeContext<'a>,
        json: &'a Json,
        seat: Seat<'_>,
    ) -> Option<Node<H>> {
        if self.errors.is_full() {
            return None;
        }
        let attached = json.get("modifiers").and_then(Json::as_list);
        let attached = attached.map_or(0, <[Json]>::len);
        let inner = seat.depth + attached;
        // Counted before anything is read: uses of subtrees multiply a short file.
        if self.is_too_large(context, json.place, inner, attached + 1) {
            return None;
        }
        let entries = object(&mut self.errors, context.file, json, "a node", NODE_KEYS)?;
        // From here on every part is read even if an earlier one is wrong, so that a file
        // reports all its mistakes at once; the results are joined at the end.
        let type_name = self.type_name(context, json, entries);
        let found = type_name.and_then(|name| self.find(context, entries, name));
        let id = self.id(context, json, entries, type_name, seat);
        let name = if let Some(name) = get(entries, "name") {
            self.name(context.file, name).unwrap_or_default()
        } else {
            let id = get(entries, "id").and_then(Json::as_text);
            let plain = id.or(type_name).unwrap_or_default();
            // The name is the id without the prefix of subtrees, which a reader of the picture
            // sees anyway.
            format!("{plain}{}", self.suffix)
        };
        let at = At {
            context,
            id: &id,
            place: get(entries, "type").map_or(json.place, |t| t.place),
        };
        let modifiers = self.modifiers(at, get(entries, "modifiers"));
        let raw = self.child_list(context, entries);
        self.misplaced(context, entries, found.as_ref(), raw.len(), at.place);
        let kind = self.node_kind(at, entries, found.as_ref(), &raw);
        let children = self.children(at, entries, found.as_ref(), &raw, inner);
        let (Some(found), Some(kind), Some(modifiers), Some(children)) =
            (found, kind, modifiers, children)
        else {
            return None;
        };
        Some(Node {
            detail: detail(entries, &self.constants),
            type_name: found.name().to_owned(),
            condition: found.is_condition(),
            name,
            kind,
            modifiers,
            children,
            id,
            suffix: String::new(),
        })
    }

    /// Counts a node with its modifiers, and reports a tree that is too large.
    fn is_too_large(
        &mut self,
        context: &NodeContext<'a>,
        place: Location,
        depth: usize,
        count: usize,
    ) -> bool {
        if depth >= MAX_DEPTH {
            let message =
                format!("nodes are nested deeper than {MAX_DEPTH} levels, modifiers included");
            self.errors.push(context.file, place, message);
            return true;
        }
        let before = self.nodes;
        self.nodes = before.saturating_add(count);
        // Reported once, at the first node beyond the limit.
        if before <= MAX_NODES && self.nodes > MAX_NODES {
            let message = format!(
                "the tree has more than {MAX_NODES} nodes, all modifiers, uses of subtrees and \
                 items of ForEach counted; this is one too many"
            );
            self.errors.push(context.file, place, message);
        }
        self.nodes > MAX_NODES
    }

    pub(super) fn type_name(
        &mut self,
        context: &NodeContext<'a>,
        json: &'a Json,
        entries: &'a [Entry],
    ) -> Option<&'a str> {
        let Some(value) = get(entries, "type") else {
            let message = "\"type\" is missing; name the type of the node";
            self.errors.push(context.file, json.place, message);
            return None;
        };
        let name = value.as_text();
        if name.is_none() {
            let message = format!(
                "the name of a node type is needed here, this is {}",
                value.describe()
            );
            self.errors.push(context.file, value.place, message);
        }
        name
    }

    /// The id in the file with the prefix of its site, or one made from the place of the node.
    fn id(
        &mut self,
        context: &NodeContext<'a>,
        json: &'a Json,
        entries: &'a [Entry],
        type_name: Option<&str>,
        seat: Seat<'_>,
    ) -> String {
        let Some(value) = get(entries, "id") else {
            let type_name = type_name.unwrap_or("node");
            let id = match seat.parent {
                "" => format!("{}{type_name}", context.prefix),
                parent => format!("{parent}/{}:{}", seat.index, shortened(type_name)),
            };
            let id = format!("{id}{}", self.suffix);
            // A made-up id changes when nodes are added before this one, and its state is then
            // lost.
            self.missing_id(context, json.place, type_name);
            return self.unique(context, json.place, id);
        };
        let text = value.as_text().unwrap_or_default();
        let wrong = |c: char| c.is_whitespace() || c.is_control() || c == '/';
        if text.is_empty() || text.len() > MAX_NAME || text.contains(wrong) {
            let message = format!(
                "an id is a text of 1 to {MAX_NAME} bytes without spaces and '/', this is {}",
                value.describe()
            );
            self.errors.push(context.file, value.place, message);
        }
        let id = format!("{}{text}{}", context.prefix, self.suffix);
        self.unique(context, value.place, id)
    }

    fn missing_id(&mut self, context: &NodeContext<'a>, place: Location, type_name: &str) {
        let finding = Finding {
            rule: "missing_id",
            place: format!("{}:{}:{}", context.file, place.line, place.column),
            message: format!(
                "{} has no id; state is carried over by ids, so give it one that stays",
                shortened(type_name)
            ),
        };
        // A subtree is read once for each use.
        if !self.findings.contains(&finding) {
            self.findings.push(finding);
        }
    }

    fn unique(&mut self, context: &NodeContext<'a>, place: Location, id: String) -> String {
        // Ids find the state of a node in a checkpoint: two equal ones would exchange it.
        if let Some((file, first)) = self.ids.get(&id) {
            let message = format!(
                "id '{}' is used in {file}:{}:{}, too; ids are unique in a tree",
                shortened(&id),
                first.line,
                first.column
            );
            self.errors.push(context.file, place, message);
        } else {
            self.ids.insert(id.clone(), (context.file, place));
        }
        id
    }

    fn child_list(&mut self, context: &NodeContext<'a>, entries: &'a [Entry]) -> Vec<&'a Json> {
        let Some(value) = get(entries, "children") else {
            return Vec::new();
        };
        if let Some(list) = value.as_list() {
            return list.iter().collect();
        }
        let found = value.describe();
        let message = format!("a list of nodes is needed here, this is {found}");
        self.errors.push(context.file, value.place, message);
        Vec::new()
    }

    /// Reports a wrong number of children, and keys that belong to other types.
    fn misplaced(
        &mut self,
        context: &NodeContext<'a>,
        entries: &'a [Entry],
        found: Option<&Found<'a, H>>,
        count: usize,
        place: Location,
    ) {
        let Some(found) = found else { return };
        let name = found.name();
        let children = match found {
            Found::Engine(spec) => spec.children,
            Found::Registered(_) | Found::Declared(..) => Children::None,
        };
        let message = match children {
            Children::None if count > 0 => {
                Some(format!("{name} has no children, here are {count}"))
            }
            Children::One if count != 1 => {
                Some(format!("{name} needs exactly one child, here are {count}"))
            }
            _ => None,
        };
        if let Some(message) = message {
            let place = get(entries, "children").map_or(place, |c| c.place);
            self.errors.push(context.file, place, message);
        }
        for (key, owner) in engine::OWNED_KEYS {
            let entry = entries.iter().find(|e| e.key == key);
            match entry {
                Some(entry) if name != owner => {
                    let message = format!("only {owner} has '{key}', this is {name}");
                    self.errors.push(context.file, entry.place, message);
                }
                None if name == owner => {
                    let message = format!("\"{key}\" is missing; {owner} needs it");
                    self.errors.push(context.file, place, message);
                }
                _ => {}
            }
        }
    }

    fn node_kind(
        &mut self,
        at: At<'_, 'a>,
        entries: &'a [Entry],
        found: Option<&Found<'a, H>>,
        children: &[&'a Json],
    ) -> Option<Kind<H>> {
        let ports = get(entries, "ports");
        match found? {
            Found::Registered(node_type) => self.leaf(at, node_type, ports).map(Kind::Leaf),
            Found::Declared(name, _) => self.declared_leaf(at, name, ports).map(Kind::Leaf),
            // A use of a subtree passes the result of its root on.
            Found::Engine(spec) if spec.name == engine::SUBTREE => Some(Kind::PassThrough),
            Found::Engine(spec) if spec.name == engine::GUARD => {
                self.engine_ports(at.context, at.place, ports, spec)?;
                self.guard(at, get(entries, "guard")?)
            }
            Found::Engine(spec) => self.kind(at, spec, ports, children),
        }
    }

    fn children(
        &mut self,
        at: At<'_, 'a>,
        entries: &'a [Entry],
        found: Option<&Found<'a, H>>,
        raw: &[&'a Json],
        depth: usize,
    ) -> Option<Vec<Node<H>>> {
        if let Some(Found::Engine(spec)) = found
            && spec.name == engine::SUBTREE
        {
            let child = self.subtree(at, entries, depth)?;
            return Some(vec![child]);
        }
        if let Some(Found::Engine(spec)) = found
            && spec.name == engine::FOR_EACH
        {
            // The wrong number was reported by `misplaced`.
            let [child] = raw else { return None };
            return self.for_each(at, entries, child, depth);
        }
        let mut children = Vec::new();
        for (index, child) in raw.iter().enumerate() {
            let seat = Seat {
                parent: at.id,
                index,
                depth: depth + 1,
            };
            children.push(self.node(at.context, child, seat));
        }
        children.into_iter().collect()
    }
}

//! Leaves whose types a file declares; another program provides them.

use super::advice;
use super::build::Builder;
use super::engine;
use super::error::Errors;
use super::files::{get, object};
use super::header::{TYPES, group};
use super::json::{Data, Entry, Location, Value as Json, shortened};
use super::kinds::At;
use super::limits::MAX_PORTS;
use crate::board::{Access, In, Scope};
use crate::tree::{AnyLeaf, Binding, DeclaredLeaf, DeclaredPort, Host};
use crate::value::{Value, ValueType};

/// Keys of a declared leaf type.
pub(super) const LEAF_KEYS: &[&str] = &["doc", "condition", "ports"];
/// Keys of a port.
pub(super) const PORT_KEYS: &[&str] = &["type", "default", "doc", "access"];
/// The word for a port that accepts values of all types.
const ANY: &str = "any";
/// The accesses to the key of a port.
pub(super) const ACCESS: &[&str] = &["read", "write", "both"];

/// A leaf type as declared.
pub(super) struct LeafType<'a> {
    pub file: &'a str,
    pub condition: bool,
    ports: Vec<Port<'a>>,
}

struct Port<'a> {
    name: &'a str,
    /// `None` for any.
    value_type: Option<ValueType>,
    default: Option<&'a Json>,
    reads: bool,
    writes: bool,
}

fn types() -> impl Iterator<Item = &'static str> {
    TYPES.iter().map(|t| t.name()).chain([ANY])
}

/// Reads the group `leaves` of a file.
pub(super) fn leaves<'a, H: Host>(
    builder: &mut Builder<'a, H>,
    file: &'a str,
    entries: &'a [Entry],
) {
    for entry in group(&mut builder.errors, file, entries, "leaves") {
        let errors = &mut builder.errors;
        let what = "a declared leaf";
        let Some(parts) = object(errors, file, &entry.value, what, LEAF_KEYS) else {
            continue;
        };
        // Engine types are found first, so a leaf with such a name would never be used.
        if engine::find(&entry.key).is_some() {
            let message = format!(
                "'{}' is a node type of the engine; give the leaf another name",
                shortened(&entry.key)
            );
            errors.push(file, entry.place, message);
            continue;
        }
        let condition = get(parts, "condition").is_some_and(|c| c.data == Data::Bool(true));
        let ports = ports(errors, file, parts);
        let declared = LeafType {
            file,
            condition,
            ports,
        };
        // The first declaration counts: that of the file itself before those of included files.
        builder.leaves.entry(&entry.key).or_insert(declared);
    }
}

fn ports<'a>(errors: &mut Errors, file: &str, parts: &'a [Entry]) -> Vec<Port<'a>> {
    let group = group(errors, file, parts, "ports");
    if let Some(beyond) = group.get(MAX_PORTS) {
        let message = format!("{} ports, at most {MAX_PORTS} are allowed", group.len());
        errors.push(file, beyond.place, message);
    }
    let declared = group.iter().take(MAX_PORTS);
    declared
        .filter_map(|entry| port(errors, file, entry))
        .collect()
}

fn port<'a>(errors: &mut Errors, file: &str, entry: &'a Entry) -> Option<Port<'a>> {
    let parts = object(errors, file, &entry.value, "a port", PORT_KEYS)?;
    let types: Vec<&str> = types().collect();
    let word = |key: &str| get(parts, key).map(|json| (json, json.as_text().unwrap_or_default()));
    let Some((json, name)) = word("type") else {
        let message = format!("\"type\" is missing; it is one of {}", types.join(", "));
        errors.push(file, entry.value.place, message);
        return None;
    };
    let value_type = TYPES.iter().copied().find(|t| t.name() == name);
    if value_type.is_none() && name != ANY {
        let message = advice::unknown("type of value", name, &types);
        errors.push(file, json.place, message);
        return None;
    }
    let access = word("access").map_or("read", |(_, access)| access);
    if !ACCESS.contains(&access) {
        let place = word("access").map_or(json.place, |(json, _)| json.place);
        errors.push(file, place, advice::unknown("access", access, ACCESS));
        return None;
    }
    Some(Port {
        name: &entry.key,
        value_type,
        default: get(parts, "default"),
        reads: access != "write",
        writes: access != "read",
    })
}

impl<'a, H: Host> Builder<'a, H> {
    /// A leaf of the declared type `name`.
    pub(super) fn declared_leaf(
        &mut self,
        at: At<'_, 'a>,
        name: &'a str,
        json: Option<&'a Json>,
    ) -> Option<Box<dyn AnyLeaf<H>>> {
        let declared = self.leaves.get(name)?;
        let declaring = declared.file;
        let known: Vec<&str> = declared.ports.iter().map(|port| port.name).collect();
        let wanted: Vec<_> = declared
            .ports
            .iter()
            .map(|p| (p.name, p.value_type, p.default, p.reads, p.writes))
            .collect();
        let entries = self.port_entries(at.context, json, &known);
        let mut ports = Some(Vec::new());
        for (port, value_type, default, reads, writes) in wanted {
            let json = get(entries, port);
            // Ports of foreign leaves are often optional; the leaf reports a missing one.
            let Some((place, binding)) = self.given(at, declaring, (json, default), value_type)
            else {
                continue;
            };
            // A default of a port that is only written is a value for the leaf, not a place to
            // write to.
            let takes_literals = reads || json.is_none();
            let from = match binding {
                Some(Binding::Literal(value)) if takes_literals => Some(In::Literal(value)),
                Some(Binding::Literal(_)) => {
                    let message = format!(
                        "port '{port}' is written; bind it to a key: {{\"bb\": \"local.KEY\"}}"
                    );
                    self.errors.push(at.context.file, place, message);
                    None
                }
                Some(Binding::Key(scope, key)) => {
                    self.used_key(at, place, (scope, &key), (reads, writes))
                }
                None => None,
            };
            match (from, &mut ports) {
                (Some(from), Some(ports)) => ports.push(DeclaredPort {
                    name: port.to_owned(),
                    value_type,
                    from,
                    writable: writes,
                }),
                _ => ports = None,
            }
        }
        let leaf = DeclaredLeaf {
            type_name: name.to_owned(),
            node: at.id.to_owned(),
            ports: ports?,
        };
        self.provided(at, leaf)
    }

    /// The place and the value of a port: `json` in the node, else the default in the file
    /// `declaring`. `None` where there is neither.
    fn given(
        &mut self,
        at: At<'_, 'a>,
        declaring: &'a str,
        (json, default): (Option<&'a Json>, Option<&'a Json>),
        value_type: Option<ValueType>,
    ) -> Option<(Location, Option<Binding>)> {
        if let Some(json) = json {
            return Some((json.place, self.binding(at.context, json, value_type)));
        }
        let json = default?;
        let value = match value_type {
            Some(value_type) => self.literal(declaring, json, value_type),
            None => self.any_literal(declaring, json),
        };
        Some((at.place, value.map(Binding::Literal)))
    }

    /// Registers the key of a port.
    fn used_key(
        &mut self,
        at: At<'_, 'a>,
        place: Location,
        key: (Scope, &str),
        (reads, writes): (bool, bool),
    ) -> Option<In<Value>> {
        let here = (at.context.file, place);
        let mut slot = None;
        // Both accesses are registered, as `Write` alone does not count as a reader in the
        // checks.
        for (used, access) in [(reads, Access::Read), (writes, Access::Write)] {
            if used {
                slot = self.register(here, at.id, key, access);
            }
        }
        slot.map(|(slot, _)| In::Key(slot))
    }

    fn provided(&mut self, at: At<'_, 'a>, leaf: DeclaredLeaf) -> Option<Box<dyn AnyLeaf<H>>> {
        let library = self.library;
        let name = shortened(&leaf.type_name);
        let problem = match &library.declared {
            Some(make) => match make(leaf) {
                Ok(made) => return Some(made),
                Err(error) => format!("{name}: {error}"),
            },
            None => format!(
                "the leaf '{name}' is declared, and this task has none of that name; a Python \
                 file provides it (TreeFile), or write it as a subtree of nodes that exist"
            ),
        };
        self.errors.push(at.context.file, at.place, problem);
        None
    }
}

/// The schema of a declared leaf type.
pub(super) fn describe() -> serde_json::Value {
    let types: Vec<&str> = types().collect();
    serde_json::json!({
        "type": "object",
        "properties": {
            "doc": {"type": "string"},
            "condition": {"type": "boolean", "description": "It is never running"},
            "ports": {
                "type": "object",
                "maxProperties": MAX_PORTS,
                "additionalProperties": {
                    "type": "object",
                    "properties": {
                        "type": {"enum": types},
                        "access": {"enum": ACCESS, "description": "Access to its key; read"},
                        "default": {"type": ["boolean", "number", "string"]},
                        "doc": {"type": "string"},
                    },
                    "required": ["type"],
                    "additionalProperties": false,
                },
            },
        },
        "additionalProperties": false,
    })
}

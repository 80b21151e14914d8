//! Kinds of the engine's node types.

use super::build::{Builder, NodeContext};
use super::engine::{self, EngineType, PARALLEL, STATUSES};
use super::files::place_of;
use super::json::{Location, Value as Json};
use super::leaves::{CheckKey, From, SetKey};
use super::literal;
use super::ports::EnginePorts;
use crate::board::{Access, In, Slot};
use crate::status::Status;
use crate::tree::leaf::any;
use crate::tree::{
    AnyLeaf, BindError, Binder, Binding, Host, Kind, Memory, NodeType, OneShotPolicy,
    ParallelPolicy, Test,
};
use crate::value::{Value, ValueType};

/// A node that is being made.
#[derive(Clone, Copy)]
pub(super) struct At<'n, 'a> {
    pub context: &'n NodeContext<'a>,
    pub id: &'n str,
    pub place: Location,
}

/// The results that a converter replaces.
fn converter(name: &str) -> Option<(Status, Status)> {
    use Status::{Failure, Running, Success};
    Some(match name {
        "SuccessIsFailure" => (Success, Failure),
        "SuccessIsRunning" => (Success, Running),
        "FailureIsSuccess" => (Failure, Success),
        "FailureIsRunning" => (Failure, Running),
        "RunningIsFailure" => (Running, Failure),
        "RunningIsSuccess" => (Running, Success),
        _ => return None,
    })
}

/// The status at `index` of [`STATUSES`].
pub(super) fn status(index: usize) -> Status {
    match STATUSES.get(index) {
        Some(&"failure") => Status::Failure,
        Some(&"running") => Status::Running,
        _ => Status::Success,
    }
}

/// Whether the policy at `index` of [`PARALLEL`] has exactly the counts that it needs.
fn has_its_counts(index: usize, successes: Option<u32>, failures: Option<u32>) -> bool {
    let (needs_successes, needs_failures) = match PARALLEL.get(index) {
        Some(&"count") => (true, true),
        Some(&"finish") => (false, true),
        _ => (false, false),
    };
    successes.is_some() == needs_successes && failures.is_some() == needs_failures
}

impl<'a, H: Host> Builder<'a, H> {
    /// The kind of a node of the engine, except for guards and subtrees.
    pub(super) fn kind(
        &mut self,
        at: At<'_, 'a>,
        spec: &'static EngineType,
        json: Option<&'a Json>,
        children: &[&'a Json],
    ) -> Option<Kind<H>> {
        // Ports first: a node with wrong ports has no kind, and all mistakes of its ports are
        // reported.
        let ports = self.engine_ports(at.context, at.place, json, spec)?;
        let memory = if ports.bool("memory") {
            Memory::Yes
        } else {
            Memory::No
        };
        if let Some((from, to)) = converter(spec.name) {
            return Some(Kind::Converter { from, to });
        }
        Some(match spec.name {
            "Sequence" | engine::FOR_EACH => Kind::Sequence(memory),
            "Selector" => Kind::Selector(memory),
            "Parallel" => Kind::Parallel(self.parallel(at, &ports, json, children)?),
            "Inverter" => Kind::Inverter,
            "SequenceWithMemory" => Kind::SequenceWithMemory,
            "Repeat" | "Retry" if ports.bool("at_once") => Kind::Again {
                count: ports.count("count"),
                on_failure: spec.name == "Retry",
            },
            "Repeat" => Kind::Repeat {
                count: ports.count("count"),
            },
            "Retry" => Kind::Retry {
                count: ports.count("count"),
            },
            "OneShot" => Kind::OneShot(match ports.choice("policy", super::engine::ONE_SHOT) {
                0 => OneShotPolicy::OnCompletion,
                _ => OneShotPolicy::OnSuccess,
            }),
            "Condition" => Kind::Condition(status(ports.choice("status", STATUSES))),
            "Count" => Kind::Count,
            "Timeout" => Kind::Timeout(self.seconds(at, &ports)?),
            "Wait" => Kind::Wait(self.seconds(at, &ports)?),
            "CheckBlackboard" => {
                let (slot, test) = self.test(at, &ports)?;
                Kind::Leaf(any(CheckKey { slot, test }))
            }
            "SetBlackboard" => Kind::Leaf(any(self.set_key(at, &ports)?)),
            _ => Kind::PassThrough,
        })
    }

    fn parallel(
        &mut self,
        at: At<'_, 'a>,
        ports: &EnginePorts,
        json: Option<&'a Json>,
        children: &[&'a Json],
    ) -> Option<ParallelPolicy> {
        let synchronise = ports.bool("synchronise");
        let ids = json.and_then(|json| json.get("selected"));
        let policy = ports.choice("policy", PARALLEL);
        let (successes, failures) = (ports.count("successes"), ports.count("failures"));
        if !has_its_counts(policy, successes, failures) {
            let message = "the policy 'count' needs the ports 'successes' and 'failures', \
                           'finish' needs 'failures', and other policies have neither";
            let place = ports.place("policy").unwrap_or(at.place);
            self.errors.push(at.context.file, place, message);
            return None;
        }
        match (policy, ids) {
            (0, None) => Some(ParallelPolicy::All { synchronise }),
            (1, None) => Some(ParallelPolicy::One),
            (3, None) => Some(ParallelPolicy::Count {
                successes: successes?,
                failures: failures?,
            }),
            (4, None) => Some(ParallelPolicy::Finish {
                failures: failures?,
            }),
            (2, Some(ids)) => {
                let children = self.selected(at.context, ids, children)?;
                Some(ParallelPolicy::Selected {
                    children,
                    synchronise,
                })
            }
            // A selection without its policy would have no effect, and the file would look as
            // if it had.
            (_, ids) => {
                let message = "the port 'selected' and the policy 'selected' belong together; \
                               give both or none";
                let place = ids.map_or(at.place, |ids| ids.place);
                self.errors.push(at.context.file, place, message);
                None
            }
        }
    }

    fn selected(
        &mut self,
        context: &NodeContext<'a>,
        ids: &'a Json,
        children: &[&'a Json],
    ) -> Option<Vec<usize>> {
        let list = ids.as_list().unwrap_or_default();
        if list.is_empty() {
            let message = "a list of ids of children is needed here";
            self.errors.push(context.file, ids.place, message);
            return None;
        }
        let id_of = |child: &&'a Json| child.get("id").and_then(Json::as_text);
        let known: Vec<&str> = children.iter().filter_map(id_of).collect();
        let mut selected = Vec::new();
        for item in list {
            let name = item.as_text().unwrap_or_default();
            match children.iter().position(|c| id_of(c) == Some(name)) {
                // Named twice counts once.
                Some(index) if !selected.contains(&index) => selected.push(index),
                Some(_) => {}
                None => {
                    let message = super::advice::unknown("child of this node", name, &known);
                    self.errors.push(context.file, item.place, message);
                    return None;
                }
            }
        }
        Some(selected)
    }

    /// The port `seconds`.
    pub(super) fn seconds(&mut self, at: At<'_, 'a>, ports: &EnginePorts) -> Option<In<f64>> {
        match ports.get("seconds")? {
            Binding::Literal(Value::Number(seconds)) => Some(In::Literal(*seconds)),
            Binding::Literal(_) => None,
            Binding::Key(scope, key) => {
                let here = (at.context.file, ports.place("seconds").unwrap_or(at.place));
                let (slot, _) = self.register(here, at.id, (*scope, key), Access::Read)?;
                Some(In::Key(slot))
            }
        }
    }

    /// The key and its only test.
    pub(super) fn test(&mut self, at: At<'_, 'a>, ports: &EnginePorts) -> Option<(Slot, Test)> {
        const TESTS: [&str; 5] = ["equals", "differs", "below", "above", "set"];
        let Some(Binding::Key(scope, key)) = ports.get("key") else {
            return None;
        };
        let here = (at.context.file, ports.place("key").unwrap_or(at.place));
        let (slot, value_type) = self.register(here, at.id, (*scope, key), Access::Read)?;
        let given: Vec<&str> = TESTS
            .into_iter()
            .filter(|t| ports.get(t).is_some())
            .collect();
        let name = match given.as_slice() {
            // Without a test the check is whether the key has a value.
            [] => return Some((slot, Test::IsSet)),
            [one] => *one,
            [_, second, ..] => {
                let message = format!(
                    "one test is enough, here are {}; nest checks",
                    given.join(", ")
                );
                let place = ports.place(second).unwrap_or(at.place);
                self.errors.push(at.context.file, place, message);
                return None;
            }
        };
        let place = ports.place(name).unwrap_or(at.place);
        let value = ports.literal(name)?;
        let number = match value {
            Value::Number(number) => number,
            _ => 0.0,
        };
        // Numbers are compared with numbers only: on a text the test would never hold.
        let is_number = matches!(value_type, ValueType::Integer | ValueType::Number);
        let test = match name {
            "equals" | "differs" => self.comparison(at, place, name, value, value_type)?,
            "set" if value == Value::Bool(true) => Test::IsSet,
            "set" => Test::IsUnset,
            "below" if is_number => Test::Below(number),
            "above" if is_number => Test::Above(number),
            _ => {
                let found = value_type.name();
                let message = format!("'{name}' is for numbers, the key is of type {found}");
                self.errors.push(at.context.file, place, message);
                return None;
            }
        };
        Some((slot, test))
    }

    fn comparison(
        &mut self,
        at: At<'_, 'a>,
        place: Location,
        name: &str,
        value: Value,
        value_type: ValueType,
    ) -> Option<Test> {
        let Some(value) = literal::coerced(value, value_type) else {
            let found = value_type.name();
            let message = format!("the key is of type {found}, it is compared with {value}");
            self.errors.push(at.context.file, place, message);
            return None;
        };
        Some(match name {
            "equals" => Test::Equals(value),
            _ => Test::Differs(value),
        })
    }

    fn set_key(&mut self, at: At<'_, 'a>, ports: &EnginePorts) -> Option<SetKey> {
        let Some(Binding::Key(scope, key)) = ports.get("key") else {
            return None;
        };
        let here = (at.context.file, ports.place("key").unwrap_or(at.place));
        let (slot, wanted) = self.register(here, at.id, (*scope, key), Access::Write)?;
        let place = ports.place("value").unwrap_or(at.place);
        let (found, from) = match ports.get("value")? {
            // A literal that does not fit keeps its own type for the message below.
            Binding::Literal(value) => match literal::coerced(*value, wanted) {
                Some(value) => (wanted, From::Literal(value)),
                None => (value.value_type(), From::Literal(*value)),
            },
            Binding::Key(scope, key) => {
                let here = (at.context.file, place);
                let (slot, found) = self.register(here, at.id, (*scope, key), Access::Read)?;
                (found, From::Key(slot))
            }
        };
        if found != wanted {
            let message = format!(
                "the key is of type {}, the value of type {}",
                wanted.name(),
                found.name()
            );
            self.errors.push(at.context.file, place, message);
            return None;
        }
        Some(SetKey { slot, from })
    }

    /// A leaf of a registered type.
    pub(super) fn leaf(
        &mut self,
        at: At<'_, 'a>,
        node_type: &'a NodeType<H>,
        ports: Option<&'a Json>,
    ) -> Option<Box<dyn AnyLeaf<H>>> {
        let bindings = self.bindings(at.context, at.place, ports, node_type)?;
        let mut binder = Binder {
            node: at.id,
            bindings: &bindings,
            constants: &self.constants,
            local: &mut self.local,
            shared: &mut self.shared,
            findings: &mut self.noted,
        };
        match (node_type.build)(&mut binder) {
            Ok(leaf) => Some(leaf),
            Err(error) => {
                // The error names the port, so that the message has the place of that port in
                // the file.
                let port = match &error {
                    BindError::Unknown { port, .. }
                    | BindError::Missing { port, .. }
                    | BindError::Type { port, .. }
                    | BindError::Board { port, .. } => port,
                    BindError::Host(_) => "",
                };
                let entries = ports.and_then(Json::as_object).unwrap_or_default();
                let place = place_of(entries, port, at.place);
                let message = format!("{}: {error}", node_type.name);
                self.errors.push(at.context.file, place, message);
                None
            }
        }
    }
}

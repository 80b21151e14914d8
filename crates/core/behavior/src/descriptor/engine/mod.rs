//! The node types and modifiers of the engine as files name them. Loader and schema use the
//! same table, so an editor offers exactly what can be loaded.

mod modifiers;
mod ports;

pub(super) use modifiers::MODIFIERS;
use ports::{AT_ONCE, KEY, SECONDS, TEST, memory};

/// Number of children of a type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Children {
    None,
    One,
    Any,
}

/// The values that a port of the engine accepts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    /// `true` or `false`, known at load.
    Bool,
    /// A whole number, at least this one, known at load.
    Count(u32),
    /// One of these words, known at load.
    Choice(&'static [&'static str]),
    /// Seconds, 0 or more: a literal or a key.
    Seconds,
    /// A finite number, known at load.
    Number,
    /// Any value, known at load.
    Value,
    /// Any value or a key.
    Bound,
    /// A key.
    Key,
    /// Ids of children.
    Ids,
}

/// A port of the engine.
pub(super) struct EnginePort {
    pub name: &'static str,
    pub doc: &'static str,
    pub shape: Shape,
    /// As JSON; `None` where the port has to be bound or may be left out.
    pub default: Option<&'static str>,
    pub required: bool,
}

/// A node type or a modifier of the engine.
pub(super) struct EngineType {
    pub name: &'static str,
    pub doc: &'static str,
    pub keywords: &'static [&'static str],
    pub children: Children,
    pub ports: &'static [EnginePort],
}

const fn port(
    name: &'static str,
    shape: Shape,
    default: Option<&'static str>,
    required: bool,
    doc: &'static str,
) -> EnginePort {
    EnginePort {
        name,
        doc,
        shape,
        default,
        required,
    }
}

const fn node(
    name: &'static str,
    children: Children,
    ports: &'static [EnginePort],
    keywords: &'static [&'static str],
    doc: &'static str,
) -> EngineType {
    EngineType {
        name,
        doc,
        keywords,
        children,
        ports,
    }
}

/// Words for a result of a child.
pub(super) const STATUSES: &[&str] = &["success", "failure", "running"];
/// Words for the result that a finished node gets.
pub(super) const FINAL_STATUSES: &[&str] = &["success", "failure"];
/// Words for the policy of a parallel.
pub(super) const PARALLEL: &[&str] = &["all", "one", "selected", "count", "finish"];
/// Words for the policy of a one-shot.
pub(super) const ONE_SHOT: &[&str] = &["on_completion", "on_success"];
/// Words for the nodes that a check may interrupt.
pub(super) const ABORTS: &[&str] = &["none", "self", "lower_priority", "both"];

/// The node types, in the order in which the schema offers them.
pub(super) const NODES: &[EngineType] = &[
    node(
        "Sequence",
        Children::Any,
        &[memory("true")],
        &["and", "then"],
        "Children one after the other until one does not succeed",
    ),
    node(
        "Selector",
        Children::Any,
        &[memory("false")],
        &["fallback", "or", "priority"],
        "Children one after the other until one does not fail",
    ),
    node(
        FOR_EACH,
        Children::One,
        &[memory("true")],
        &["each", "items", "copies"],
        "A sequence of one copy of the child for each of 'items', in their order; ${NAME} is the \
         item, where 'as' is NAME, and ids and names of the copy end with [ITEM]",
    ),
    node(
        "Parallel",
        Children::Any,
        &[
            port(
                "policy",
                Shape::Choice(PARALLEL),
                Some("\"all\""),
                false,
                "Which children have to succeed, where one that fails makes it fail; or 'count': ends as soon as so many succeeded or failed; 'finish': ends when all have finished",
            ),
            port(
                "selected",
                Shape::Ids,
                None,
                false,
                "Ids of the children that have to succeed, for the policy 'selected'",
            ),
            port(
                "successes",
                Shape::Count(1),
                None,
                false,
                "So many successes are a success, for the policy 'count'",
            ),
            port(
                "failures",
                Shape::Count(1),
                None,
                false,
                "So many failures are a failure, for the policies 'count' and 'finish'",
            ),
            port(
                "synchronise",
                Shape::Bool,
                Some("true"),
                false,
                "A child that succeeded is not ticked again until all are done",
            ),
        ],
        &["together", "simultaneous"],
        "All children at every tick",
    ),
    node(
        "SequenceWithMemory",
        Children::Any,
        &[],
        &["sequencestar"],
        "As Sequence, but continues with the child that it was at also after a failure and after it was stopped; starts one child a tick",
    ),
    node(
        "Inverter",
        Children::One,
        &[],
        &["not", "negate"],
        "Success for failure and the other way round",
    ),
    node(
        "SuccessIsFailure",
        Children::One,
        &[],
        &["converter"],
        "Failure where the child succeeds",
    ),
    node(
        "SuccessIsRunning",
        Children::One,
        &[],
        &["converter"],
        "Running where the child succeeds",
    ),
    node(
        "FailureIsSuccess",
        Children::One,
        &[],
        &["converter", "optional"],
        "Success where the child fails",
    ),
    node(
        "FailureIsRunning",
        Children::One,
        &[],
        &["converter"],
        "Running where the child fails",
    ),
    node(
        "RunningIsFailure",
        Children::One,
        &[],
        &["converter"],
        "Failure where the child is running",
    ),
    node(
        "RunningIsSuccess",
        Children::One,
        &[],
        &["converter"],
        "Success where the child is running",
    ),
    node(
        "Repeat",
        Children::One,
        &[
            port(
                "count",
                Shape::Count(1),
                None,
                false,
                "How often the child has to succeed; forever without",
            ),
            AT_ONCE,
        ],
        &["loop"],
        "Runs the child until it succeeded so often; a failure ends it",
    ),
    node(
        "Retry",
        Children::One,
        &[
            port(
                "count",
                Shape::Count(1),
                None,
                false,
                "How often the child may fail; forever without",
            ),
            AT_ONCE,
        ],
        &["again"],
        "Runs the child again when it failed",
    ),
    node(
        "OneShot",
        Children::One,
        &[port(
            "policy",
            Shape::Choice(ONE_SHOT),
            Some("\"on_completion\""),
            false,
            "Whether a failure is final, too",
        )],
        &["once"],
        "Runs the child to its end once and gives that answer ever after",
    ),
    node(
        "Condition",
        Children::One,
        &[port(
            "status",
            Shape::Choice(STATUSES),
            Some("\"success\""),
            false,
            "The awaited answer of the child",
        )],
        &["until", "await"],
        "Success when the child gives this answer, running until then",
    ),
    node(
        "EternalGuard",
        Children::One,
        &[],
        &["invariant", "while"],
        "Asks its guard before each tick of the child and fails where it does not succeed",
    ),
    node(
        "Count",
        Children::One,
        &[],
        &["statistics"],
        "Counts ticks and answers of the child",
    ),
    node(
        "Timeout",
        Children::One,
        &[SECONDS],
        &["deadline"],
        "Fails when the child is not finished in time; a child that finishes in the very tick wins",
    ),
    node(
        "PassThrough",
        Children::One,
        &[],
        &["group", "identity"],
        "The child's answer",
    ),
    node(
        "Wait",
        Children::None,
        &[SECONDS],
        &["pause", "sleep", "delay"],
        "Runs for these seconds, then succeeds",
    ),
    node(
        "CheckBlackboard",
        Children::None,
        TEST,
        &["condition", "if"],
        "Success where the test of the key holds, otherwise failure",
    ),
    node(
        "SetBlackboard",
        Children::None,
        &[
            KEY,
            port(
                "value",
                Shape::Bound,
                None,
                true,
                "The value, or the key to copy it from",
            ),
        ],
        &["write", "assign"],
        "Writes a key and succeeds",
    ),
    node(
        SUBTREE,
        Children::None,
        &[],
        &["include", "call", "reuse"],
        "A subtree of this file or of an included one, with its ports",
    ),
];

/// Name of the type that uses a subtree.
pub(super) const SUBTREE: &str = "Subtree";
/// Name of the type with a guard.
pub(super) const GUARD: &str = "EternalGuard";
/// Name of the type that copies its child.
pub(super) const FOR_EACH: &str = "ForEach";
/// Keys that one type of node has, and needs.
pub(super) const OWNED_KEYS: [(&str, &str); 4] = [
    ("subtree", SUBTREE),
    ("guard", GUARD),
    ("as", FOR_EACH),
    ("items", FOR_EACH),
];

/// The node type with that name.
pub(super) fn find(name: &str) -> Option<&'static EngineType> {
    NODES.iter().find(|t| t.name == name)
}

/// The modifier with that name.
pub(super) fn find_modifier(name: &str) -> Option<&'static EngineType> {
    MODIFIERS.iter().find(|t| t.name == name)
}

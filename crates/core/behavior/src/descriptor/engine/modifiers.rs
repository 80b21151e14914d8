//! The modifiers that any node may have.

use super::{Children, EngineType, FINAL_STATUSES, SECONDS, Shape, TEST, node, port};

/// The modifiers that any node may have.
pub(in crate::descriptor) const MODIFIERS: &[EngineType] = &[
    node(
        "CheckBlackboard",
        Children::None,
        TEST,
        &["guard", "condition"],
        "The node runs only where the test of the key holds",
    ),
    node(
        "Timeout",
        Children::None,
        &[SECONDS],
        &["deadline"],
        "The node fails when it is not finished in time",
    ),
    node(
        "Delay",
        Children::None,
        &[SECONDS],
        &["wait"],
        "These seconds before the node starts",
    ),
    node(
        "Repeat",
        Children::None,
        &[
            port(
                "count",
                Shape::Count(0),
                Some("0"),
                false,
                "How often in all; 0 forever",
            ),
            port(
                "break_on_failure",
                Shape::Bool,
                Some("true"),
                false,
                "A failure ends it",
            ),
        ],
        &["loop"],
        "Runs the node again when it is finished",
    ),
    node(
        "Retry",
        Children::None,
        &[
            port(
                "max",
                Shape::Count(0),
                Some("0"),
                false,
                "How often again at most; 0 forever",
            ),
            port(
                "reset_on_success",
                Shape::Bool,
                Some("true"),
                false,
                "A success sets the count back",
            ),
        ],
        &["again"],
        "Runs the node again when it failed",
    ),
    node(
        "InvertStatus",
        Children::None,
        &[],
        &["not", "negate"],
        "Success for failure and the other way round",
    ),
    node(
        "ForceStatus",
        Children::None,
        &[port(
            "status",
            Shape::Choice(FINAL_STATUSES),
            None,
            true,
            "The answer",
        )],
        &["always"],
        "This answer when the node is finished, instead of its own",
    ),
];

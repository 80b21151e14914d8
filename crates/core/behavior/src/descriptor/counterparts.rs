//! Names of node types in files for BehaviorTree.CPP 4 and Nav2, and their counterparts here.

/// The foreign name, and the advice.
// Trees of these libraries are the largest body of trees (ADR 0027): a user who writes a file
// by hand knows these names, and a search by similar letters would not find the counterpart.
const NAMES: &[(&str, &str)] = &[
    ("Fallback", SELECTOR),
    ("AsyncFallback", SELECTOR),
    (
        "ReactiveFallback",
        "write Selector (with \"memory\": false, as it is without the port)",
    ),
    (
        "ReactiveSequence",
        "write Sequence with \"ports\": {\"memory\": false}",
    ),
    ("AsyncSequence", "write Sequence"),
    ("SequenceStar", SEQUENCE),
    (
        "PipelineSequence",
        "write Sequence with \"ports\": {\"memory\": false}",
    ),
    (
        "RecoveryNode",
        "write a Retry around a Selector of the action and, forced to fail, its recovery",
    ),
    (
        "RoundRobin",
        "no counterpart; a Selector asks its children in order",
    ),
    ("ParallelAll", "write Parallel"),
    (
        "ForceSuccess",
        "write {\"type\": \"ForceStatus\", \"ports\": {\"status\": \"success\"}} into the child's \
         \"modifiers\"",
    ),
    (
        "ForceFailure",
        "write {\"type\": \"ForceStatus\", \"ports\": {\"status\": \"failure\"}} into the child's \
         \"modifiers\"",
    ),
    ("RetryUntilSuccessful", RETRY),
    ("RetryUntilSuccesful", RETRY),
    ("KeepRunningUntilFailure", "write Repeat without \"count\""),
    ("RunOnce", "write OneShot"),
    ("Sleep", "write Wait with \"ports\": {\"seconds\": 1.0}"),
    (
        "Precondition",
        "write EternalGuard, or the condition as first child of a Sequence",
    ),
    ("SubTree", "write Subtree with \"subtree\": \"NAME\""),
    ("SubTreePlus", "write Subtree with \"subtree\": \"NAME\""),
    ("IfThenElse", BRANCHES),
    ("WhileDoElse", BRANCHES),
    (
        "AlwaysSuccess",
        "write Sequence without children, or leave the node out",
    ),
    ("AlwaysFailure", "write Selector without children"),
    ("Script", "write SetBlackboard"),
    ("ScriptCondition", "write CheckBlackboard"),
    (
        "UnsetBlackboard",
        "no counterpart; write SetBlackboard with a value that means none",
    ),
    ("LoopInt", LOOP),
    ("LoopDouble", LOOP),
    ("LoopString", LOOP),
];

const SELECTOR: &str = "write Selector with \"ports\": {\"memory\": true}";
const SEQUENCE: &str = "write SequenceWithMemory";
const RETRY: &str = "write Retry with \"ports\": {\"count\": 3}";
const BRANCHES: &str =
    "write a Selector of two Sequences, the first of which starts with the condition";
const LOOP: &str = "write ForEach with \"as\" and \"items\"";

/// The advice for a type with that name.
pub(super) fn of(name: &str) -> Option<&'static str> {
    let known = NAMES.iter().find(|(theirs, _)| *theirs == name);
    known.map(|(_, ours)| *ours)
}

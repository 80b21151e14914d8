//! The nodes of BehaviorTree.CPP itself.

use behavior::suggest;
use serde_json::json;

use crate::bind::{self, Value};
use crate::document::Element;
use crate::out::{At, Bind, Out};
use crate::script;
use crate::translate::{Part, Skip, Translator};

/// The nodes that have a counterpart, for suggestions.
const KNOWN: &[&str] = &[
    "Sequence",
    "ReactiveSequence",
    "SequenceWithMemory",
    "Fallback",
    "ReactiveFallback",
    "Parallel",
    "ParallelAll",
    "IfThenElse",
    "Inverter",
    "ForceSuccess",
    "ForceFailure",
    "Repeat",
    "RetryUntilSuccessful",
    "KeepRunningUntilFailure",
    "Timeout",
    "Delay",
    "RunOnce",
    "Precondition",
    "SubTree",
    "AlwaysSuccess",
    "AlwaysFailure",
    "Script",
    "ScriptCondition",
    "SetBlackboard",
    "Sleep",
];

/// Nodes of BehaviorTree.CPP without a counterpart, and the advice.
// Refused by name: without this list they would count as leaves of the author, and the tree
// would load and wait for a program to provide them (ADR 0027).
const REFUSED: &[(&str, &str)] = &[
    ("AsyncSequence", "use Sequence: here nothing waits for it"),
    ("AsyncFallback", "use Fallback: here nothing waits for it"),
    ("ManualSelector", "a person cannot choose a child"),
    (
        "SubTreePlus",
        "it is of version 3; write SubTree, with _autoremap where it was set",
    ),
    (
        "SequenceStar",
        "it is of version 3; write SequenceWithMemory",
    ),
    ("FallbackStar", "it is of version 3; write Fallback"),
    (
        "RetryUntilSuccesful",
        "it is of version 3; write RetryUntilSuccessful",
    ),
    (
        "BlackboardCheckInt",
        "it is of version 3; write _skipIf or ScriptCondition",
    ),
    (
        "BlackboardCheckDouble",
        "it is of version 3; write _skipIf or ScriptCondition",
    ),
    (
        "BlackboardCheckString",
        "it is of version 3; write _skipIf or ScriptCondition",
    ),
    (
        "BlackboardCheckBool",
        "it is of version 3; write _skipIf or ScriptCondition",
    ),
    (
        "WhileDoElse",
        "write a ReactiveFallback of two ReactiveSequences, if the first one cannot fail",
    ),
    ("Switch2", "write a ScriptCondition for each case"),
    ("Switch3", "write a ScriptCondition for each case"),
    ("Switch4", "write a ScriptCondition for each case"),
    ("Switch5", "write a ScriptCondition for each case"),
    ("Switch6", "write a ScriptCondition for each case"),
    ("UnsetBlackboard", "a leaf of your own takes a value away"),
    (
        "EntryUpdated",
        "keys do not count their changes; compare their values",
    ),
    (
        "WasEntryUpdated",
        "keys do not count their changes; compare their values",
    ),
    (
        "SkipUnlessUpdated",
        "keys do not count their changes; compare their values",
    ),
    (
        "WaitValueUpdate",
        "keys do not count their changes; compare their values",
    ),
    ("LoopInt", "keys hold no queues; a leaf takes the next item"),
    (
        "LoopDouble",
        "keys hold no queues; a leaf takes the next item",
    ),
    (
        "LoopBool",
        "keys hold no queues; a leaf takes the next item",
    ),
    (
        "LoopString",
        "keys hold no queues; a leaf takes the next item",
    ),
    (
        "ConsumeQueue",
        "keys hold no queues; a leaf takes the next item",
    ),
    (
        "TestNode",
        "write a leaf, and replace its answer with --replace",
    ),
];

impl Translator<'_> {
    /// The node without its scripts.
    pub(crate) fn body(&mut self, element: &Element, skip: Skip, depth: usize) -> Option<Part> {
        let name = element.node_type().to_owned();
        if name.is_empty() {
            let why = format!("<{}> needs ID=\"TYPE\"", element.tag);
            self.refuse(element, why);
            return None;
        }
        // The children of a refused node are translated all the same, so that one run reports
        // all refusals.
        if let Some((_, why)) = REFUSED.iter().find(|(refused, _)| *refused == name) {
            self.refuse(element, format!("{name} has no counterpart: {why}"));
            self.look_inside(element, depth);
            return None;
        }
        // An unknown attribute is a mistake or of another version; ignoring it could change the
        // tree.
        if !self.has_its_attributes(element, &name) {
            self.look_inside(element, depth);
            return None;
        }
        match name.as_str() {
            "Sequence" => self.line(element, "Sequence", true, skip, depth),
            // BehaviorTree.CPP: Sequence and Fallback have memory, the reactive ones do not.
            "ReactiveSequence" => self.line(element, "Sequence", false, skip, depth),
            "Fallback" => self.line(element, "Selector", true, skip, depth),
            "ReactiveFallback" => self.line(element, "Selector", false, skip, depth),
            "SequenceWithMemory" => {
                let children = self.outs(element, depth)?;
                Some(Part::of(self.out(element, "SequenceWithMemory", children)))
            }
            "Parallel" => self.parallel(element, depth),
            "ParallelAll" => self.parallel_all(element, depth),
            "IfThenElse" => self.if_then_else(element, depth),
            "Inverter" | "ForceSuccess" | "ForceFailure" | "KeepRunningUntilFailure" | "Delay" => {
                self.decorator(element, &name, skip, depth)
            }
            "Repeat" => self.again(element, ("Repeat", "num_cycles"), depth),
            "RetryUntilSuccessful" => self.again(element, ("Retry", "num_attempts"), depth),
            "Timeout" => self.timeout(element, depth),
            "RunOnce" => self.run_once(element, skip, depth),
            "Precondition" => self.precondition(element, skip, depth),
            "SubTree" => self.subtree(element),
            "AlwaysSuccess" | "AlwaysFailure" => {
                let id = self.out(element, "", Vec::new()).id;
                Some(Part::of(self.always(id, name == "AlwaysSuccess")))
            }
            "Script" => self.script(element),
            "ScriptCondition" => self.script_condition(element),
            "SetBlackboard" => self.set_blackboard(element),
            "Sleep" => {
                let seconds = self.seconds(element, "msec")?;
                let out = self.out(element, "Wait", Vec::new());
                Some(Part::of(out.port("seconds", seconds)))
            }
            _ => self.leaf(element, depth),
        }
    }

    /// Refuses attributes that the node does not have.
    fn has_its_attributes(&mut self, element: &Element, name: &str) -> bool {
        let known: &[&str] = match name {
            "Parallel" => &["success_count", "failure_count"],
            "ParallelAll" => &["max_failures"],
            "Repeat" => &["num_cycles"],
            "RetryUntilSuccessful" => &["num_attempts"],
            "Timeout" | "Sleep" => &["msec"],
            "Delay" => &["delay_msec"],
            "RunOnce" => &["then_skip"],
            "Precondition" => &["if", "else"],
            "Script" | "ScriptCondition" => &["code"],
            "SetBlackboard" => &["output_key", "value"],
            name if name != "SubTree" && KNOWN.contains(&name) => &[],
            _ => return true,
        };
        // Attributes with `_` are scripts and marks of editors, which `around` reads.
        let own = |name: &str| name.starts_with('_') || name == "name" || name == "ID";
        let names = element.attributes.iter().map(|(name, _)| name.as_str());
        let unknown: Vec<&str> = names.filter(|n| !own(n) && !known.contains(n)).collect();
        for attribute in &unknown {
            let advice = suggest::advice(attribute, known);
            self.refuse(element, format!("unknown port '{attribute}'; {advice}"));
        }
        unknown.is_empty()
    }

    /// Translates the children of a refused node to report more refusals.
    pub(crate) fn look_inside(&mut self, element: &Element, depth: usize) {
        for child in &element.children {
            let _refused_anyway = self.node(child, Skip::Success, depth + 1);
        }
    }

    /// The known node with the most similar name.
    pub(crate) fn known_node(name: &str) -> Option<&'static str> {
        suggest::nearest(name, KNOWN)
    }

    /// Children where none may be skipped.
    pub(crate) fn outs(&mut self, element: &Element, depth: usize) -> Option<Vec<Out>> {
        let parts = self.children(element, Skip::Never, depth)?;
        Some(parts.into_iter().map(|part| part.out).collect())
    }

    fn line(
        &mut self,
        element: &Element,
        kind: &str,
        memory: bool,
        skip: Skip,
        depth: usize,
    ) -> Option<Part> {
        // A Sequence continues after a skipped child as after a success, a Fallback as after a
        // failure.
        let own = match kind {
            "Sequence" => Skip::Success,
            _ => Skip::Failure,
        };
        let parts = self.children(element, own, depth)?;
        // If all children are skipped, it is skipped, too.
        let skips = parts.iter().all(|part| part.skips);
        if skips && skip != own {
            let why = "all its children may be skipped, and it with them: the node around it has \
                       no answer for that";
            self.refuse(element, why);
            return None;
        }
        let children = parts.into_iter().map(|part| part.out).collect();
        let out = self.out(element, kind, children).port("memory", memory);
        Some(Part { out, skips })
    }

    /// A whole number that is known at import.
    pub(crate) fn number(
        &mut self,
        element: &Element,
        port: &str,
        default: Option<i64>,
    ) -> Option<i64> {
        let text = match (element.get(port), default) {
            (Some(text), _) => text,
            (None, Some(default)) => return Some(default),
            (None, None) => {
                self.refuse(element, format!("the port '{port}' is missing"));
                return None;
            }
        };
        let why = match bind::value(port, text) {
            // In BehaviorTree.CPP a key may change the number at run time; ours are part of the
            // node.
            Value::Key(key) => format!(
                "the port '{port}' is the key '{key}'; here it has to be a number: write it"
            ),
            Value::Text(text) => match text.trim().parse() {
                Ok(number) => return Some(number),
                Err(_) => format!("the port '{port}' is '{text}', a whole number is needed"),
            },
        };
        self.refuse(element, why);
        None
    }

    /// Milliseconds, converted to seconds.
    pub(crate) fn seconds(&mut self, element: &Element, port: &str) -> Option<f64> {
        let milliseconds = self.number(element, port, None)?;
        if milliseconds < 0 {
            let why = format!("the port '{port}' is {milliseconds} ms, 0 or more is needed");
            self.refuse(element, why);
            return None;
        }
        Some(milliseconds as f64 / 1000.0)
    }

    fn script(&mut self, element: &Element) -> Option<Part> {
        let Some(code) = element.get("code") else {
            self.refuse(element, "code=\"KEY := VALUE\" is missing");
            return None;
        };
        let sets = match script::assignments(code) {
            Ok(sets) => sets,
            Err(why) => {
                self.refuse(element, why);
                return None;
            }
        };
        let at = At::of(element);
        let mut out = self.out(element, "Sequence", Vec::new());
        let base = out.id.clone();
        let mut children: Vec<Out> = sets.iter().map(|set| self.set(set, &base, &at)).collect();
        // A single assignment needs no sequence around it.
        if children.len() == 1
            && let Some(only) = children.pop()
        {
            (out.kind, out.ports) = (only.kind, only.ports);
            return Some(Part::of(out));
        }
        out.children = children;
        Some(Part::of(out.port("memory", true)))
    }

    fn script_condition(&mut self, element: &Element) -> Option<Part> {
        let Some(code) = element.get("code") else {
            self.refuse(element, "code=\"CONDITION\" is missing");
            return None;
        };
        match script::condition(code) {
            Ok(expr) => {
                let named = self.out(element, "", Vec::new());
                let mut out = self.condition(&expr, true, &named.id, &At::of(element));
                // The node keeps its own id and name; those of the condition are for parts of
                // it.
                (out.id, out.name) = (named.id, named.name);
                Some(Part::of(out))
            }
            Err(why) => {
                self.refuse(element, why);
                None
            }
        }
    }

    fn set_blackboard(&mut self, element: &Element) -> Option<Part> {
        let (Some(key), Some(text)) = (element.get("output_key"), element.get("value")) else {
            self.refuse(element, "the ports 'output_key' and 'value' are needed");
            return None;
        };
        let at = At::of(element);
        // The port is the name of a key, with or without braces.
        let key = match bind::value("output_key", key) {
            Value::Key(key) | Value::Text(key) => self.key(key, true),
        };
        let value = match bind::value("value", text) {
            Value::Key(other) => self.copied(&key, other, &at),
            Value::Text(text) => {
                let holder = self.holder(&key);
                self.types.looks_like(&holder, text);
                Bind::Text(text.to_owned(), holder, at)
            }
        };
        let out = self.out(element, "SetBlackboard", Vec::new());
        let out = out.bound("key", Bind::Key(key)).bound("value", value);
        Some(Part::of(out))
    }

    pub(crate) fn delay(out: &mut Out, seconds: f64) {
        out.modifiers
            .push(json!({"type": "Delay", "ports": {"seconds": seconds}}));
    }
}

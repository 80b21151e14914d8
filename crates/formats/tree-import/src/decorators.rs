//! Decorators, and nodes with several children other than sequences and fallbacks.

use crate::document::Element;
use crate::out::{At, Bind, Out};
use crate::script::{self, Constant};
use crate::translate::{Part, Skip, Translator};

impl Translator<'_> {
    pub(crate) fn parallel(&mut self, element: &Element, depth: usize) -> Option<Part> {
        // Children and ports are read before any is tested, so that all mistakes are reported.
        let children = self.outs(element, depth);
        let successes = self.threshold(element, "success_count", -1);
        let failures = self.threshold(element, "failure_count", 1);
        let (children, successes, failures) = (children?, successes?, failures?);
        let out = self.out(element, "Parallel", children);
        let out = out.port("policy", "count").port("successes", successes);
        Some(Part::of(out.port("failures", failures)))
    }

    pub(crate) fn parallel_all(&mut self, element: &Element, depth: usize) -> Option<Part> {
        let children = self.outs(element, depth);
        let failures = self.threshold(element, "max_failures", 1);
        let (children, failures) = (children?, failures?);
        let out = self.out(element, "Parallel", children);
        Some(Part::of(
            out.port("policy", "finish").port("failures", failures),
        ))
    }

    /// A number of children; negative numbers count from all of them, -1.
    fn threshold(&mut self, element: &Element, port: &str, default: i64) -> Option<i64> {
        let given = self.number(element, port, Some(default))?;
        let count = i64::try_from(element.children.len()).unwrap_or(i64::MAX);
        let meant = if given < 0 {
            count.saturating_add(given).saturating_add(1)
        } else {
            given
        };
        // 0 decides before any child has finished; more than all can never be reached.
        if (1..=count).contains(&meant) {
            return Some(meant);
        }
        let why = format!(
            "the port '{port}' is {given}; with {count} children 1 to {count} has a counterpart, \
             or -{count} to -1"
        );
        self.refuse(element, why);
        None
    }

    /// The choice between both branches is kept in a key, so the condition is not ticked again.
    pub(crate) fn if_then_else(&mut self, element: &Element, depth: usize) -> Option<Part> {
        let mut children = self.outs(element, depth)?.into_iter();
        let (condition, yes, no) = (children.next(), children.next(), children.next());
        let (Some(condition), Some(yes), None) = (condition, yes, children.next()) else {
            self.refuse(
                element,
                "two or three children are needed: condition, then, else",
            );
            return None;
        };
        let mut out = self.out(element, "Sequence", Vec::new());
        // Without an else branch it fails when the condition fails, which a Sequence does.
        let Some(no) = no else {
            out.children = vec![condition, yes];
            return Some(Part::of(out.port("memory", true)));
        };
        let (base, at) = (out.id.clone(), At::of(element));
        let key = self.key(&format!("{base}.holds"), true);
        // A key of this node alone: uses of a subtree must not share it by `_autoremap`.
        if let Some(own) = self.scope.keys.get_mut(&key) {
            own.inner = true;
        }
        let held = self.flag(&base, &key, true, &at);
        let not_held = self.flag(&base, &key, false, &at);
        // The condition may run for several ticks; its result is stored when it has finished.
        let asked = self.both(&format!("{base}.asked"), vec![condition, held]);
        let asked = self.either(&format!("{base}.ask"), vec![asked, not_held]);
        let then_if = self.check(&base, &key, true, &at);
        let else_if = self.check(&base, &key, false, &at);
        let yes = self.both(&format!("{base}.then"), vec![then_if, yes]);
        let no = self.both(&format!("{base}.else"), vec![else_if, no]);
        let chosen = self.either(&format!("{base}.choice"), vec![yes, no]);
        out.children = vec![asked, chosen];
        Some(Part::of(out.port("memory", true)))
    }

    fn both(&mut self, id: &str, children: Vec<Out>) -> Out {
        Out::new(self.id(id), "Sequence", children).port("memory", true)
    }

    fn either(&mut self, id: &str, children: Vec<Out>) -> Out {
        Out::new(self.id(id), "Selector", children).port("memory", true)
    }

    /// Sets a key of this node.
    fn flag(&mut self, base: &str, key: &str, value: bool, at: &At) -> Out {
        let id = self.id(&format!("{base}.note_{value}"));
        let holder = self.holder(key);
        let value = Bind::Constant(Constant::Bool(value), holder.clone(), at.clone());
        // The key belongs to this node, so no other type conflicts with it.
        let _own = self.types.is(&holder, crate::types::Type::Bool).is_ok();
        let out = Out::new(id, "SetBlackboard", Vec::new());
        out.bound("key", Bind::Key(key.to_owned()))
            .bound("value", value)
    }

    fn check(&mut self, base: &str, key: &str, value: bool, at: &At) -> Out {
        let id = self.id(&format!("{base}.if_{value}"));
        let value = Bind::Constant(Constant::Bool(value), self.holder(key), at.clone());
        let out = Out::new(id, "CheckBlackboard", Vec::new());
        out.bound("key", Bind::Key(key.to_owned()))
            .bound("equals", value)
    }

    pub(crate) fn decorator(
        &mut self,
        element: &Element,
        name: &str,
        skip: Skip,
        depth: usize,
    ) -> Option<Part> {
        // The result of a skipped child as its parent sees it: an inverter turns it round, a
        // node that forces a result hides it.
        let (kind, inner) = match (name, skip) {
            ("Inverter", Skip::Success) => ("Inverter", Skip::Failure),
            ("Inverter", Skip::Failure) => ("Inverter", Skip::Success),
            ("Inverter", Skip::Never) => ("Inverter", Skip::Never),
            ("ForceSuccess", Skip::Success) => ("FailureIsSuccess", Skip::Success),
            ("ForceSuccess", _) => ("FailureIsSuccess", Skip::Never),
            ("ForceFailure", Skip::Failure) => ("SuccessIsFailure", Skip::Failure),
            ("ForceFailure", _) => ("SuccessIsFailure", Skip::Never),
            ("Delay", skip) => ("PassThrough", skip),
            // KeepRunningUntilFailure: a success becomes running.
            (_, _) => ("SuccessIsRunning", Skip::Never),
        };
        let seconds = match name {
            "Delay" => Some(self.seconds(element, "delay_msec")),
            _ => None,
        };
        let part = self.child(element, inner, depth)?;
        let mut out = self.out(element, kind, vec![part.out]);
        if let Some(seconds) = seconds {
            Self::delay(&mut out, seconds?);
        }
        Some(Part {
            out,
            skips: part.skips,
        })
    }

    /// Repeat and Retry; -1 means for ever.
    pub(crate) fn again(
        &mut self,
        element: &Element,
        (kind, port): (&str, &str),
        depth: usize,
    ) -> Option<Part> {
        let count = self.number(element, port, None);
        let part = self.child(element, Skip::Never, depth)?;
        let out = self.out(element, kind, vec![part.out]);
        let out = match count? {
            -1 => out,
            count if count >= 1 => out.port("count", count),
            count => {
                let why = format!("the port '{port}' is {count}; -1 or 1 and more is needed");
                self.refuse(element, why);
                return None;
            }
        };
        // In BehaviorTree.CPP the next run starts in the tick in which a run ends.
        Some(Part::of(out.port("at_once", true)))
    }

    /// A clock before the child that fails at the deadline; after it the child is not ticked.
    pub(crate) fn timeout(&mut self, element: &Element, depth: usize) -> Option<Part> {
        let seconds = self.seconds(element, "msec");
        let part = self.child(element, Skip::Never, depth)?;
        let seconds = seconds?;
        // BehaviorTree.CPP has no deadline for 0 ms.
        if seconds <= 0.0 {
            return Some(Part::of(self.out(element, "PassThrough", vec![part.out])));
        }
        // Our Timeout lets a child win that finishes in the late tick; theirs does not.
        let mut out = self.out(element, "Parallel", Vec::new());
        let clock = self.id(&format!("{}.clock", out.id));
        let clock = Out::new(clock, "Wait", Vec::new()).port("seconds", seconds);
        let over = self.id(&format!("{}.over", out.id));
        let over = Out::new(over, "Inverter", vec![clock]);
        out.children = vec![over, part.out];
        let out = out.port("policy", "count").port("successes", 1);
        Some(Part::of(out.port("failures", 1)))
    }

    pub(crate) fn run_once(&mut self, element: &Element, skip: Skip, depth: usize) -> Option<Part> {
        let then_skip = !matches!(element.get("then_skip"), Some("false" | "0"));
        let part = self.child(element, Skip::Never, depth)?;
        // Without `then_skip` it returns the first result again and again, as OneShot does.
        if !then_skip {
            let out = self.out(element, "OneShot", vec![part.out]);
            return Some(Part::of(out.port("policy", "on_completion")));
        }
        if skip == Skip::Never {
            let why = "it is skipped after the first run, which needs a Sequence or Fallback \
                       around it; or give it then_skip=\"false\"";
            self.refuse(element, why);
            return None;
        }
        let at = At::of(element);
        let mut out = self.out(element, "Selector", Vec::new());
        let base = out.id.clone();
        // Whether it ran is a key and not a OneShot: after the first run it is skipped, with
        // the result that the parent expects of a skipped child.
        let key = self.key(&format!("{base}.ran"), true);
        if let Some(own) = self.scope.keys.get_mut(&key) {
            own.inner = true;
        }
        let ran = self.check(&base, &key, true, &at);
        let succeeded = self.flag(&base, &key, true, &at);
        let failed = self.flag(&base, &key, true, &at);
        let not = self.id(&format!("{base}.failed"));
        let failed = Out::new(not, "Inverter", vec![failed]);
        let run = self.both(&format!("{base}.run"), vec![part.out, succeeded]);
        // Skipped counts as success: a Selector ends with the first success, `ran`.
        if skip == Skip::Success {
            out.children = vec![ran, run, failed];
            let out = out.port("memory", true);
            return Some(Part { out, skips: true });
        }
        let not = self.id(&format!("{base}.first"));
        let first = Out::new(not, "Inverter", vec![ran]);
        let run = self.either(&format!("{base}.once"), vec![run, failed]);
        "Sequence".clone_into(&mut out.kind);
        out.children = vec![first, run];
        let out = out.port("memory", true);
        Some(Part { out, skips: true })
    }

    /// Evaluated while the child is not running.
    pub(crate) fn precondition(
        &mut self,
        element: &Element,
        skip: Skip,
        depth: usize,
    ) -> Option<Part> {
        // SKIPPED is accepted where the parent treats it as this result.
        let otherwise = match (element.get("else").unwrap_or("FAILURE"), skip) {
            ("FAILURE", _) | ("SKIPPED", Skip::Failure) => Some("Sequence"),
            ("SUCCESS", _) | ("SKIPPED", Skip::Success) => Some("Selector"),
            (other, _) => {
                let why =
                    format!("else=\"{other}\" has no counterpart here; FAILURE or SUCCESS has");
                self.refuse(element, why);
                None
            }
        };
        let expr = element.get("if").map(script::condition);
        // The child is translated before the condition is tested, to report its refusals, too.
        let part = self.child(element, Skip::Never, depth)?;
        let expr = match expr {
            Some(Ok(expr)) => expr,
            Some(Err(why)) => {
                self.refuse(element, why);
                return None;
            }
            None => {
                self.refuse(element, "if=\"CONDITION\" is missing");
                return None;
            }
        };
        let kind = otherwise?;
        let skips = element.get("else") == Some("SKIPPED");
        let mut out = self.out(element, kind, Vec::new());
        let condition =
            self.condition(&expr, kind == "Sequence", &out.id.clone(), &At::of(element));
        out.children = vec![condition, part.out];
        let out = out.port("memory", true);
        Some(Part { out, skips })
    }
}

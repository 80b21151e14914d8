//! Scripts of a node (`_skipIf`, `_onSuccess`, ..), and their translation.

use crate::document::Element;
use crate::out::{At, Bind, Out};
use crate::script::{self, Assignment, Constant, Expr, Source};
use crate::translate::{Part, Skip, Translator};
use crate::types::Type;

/// Attributes of editors.
const IGNORED: &[&str] = &[
    "_description",
    "_uid",
    "_fullPath",
    "_fullpath",
    "_collapsed",
];

/// The scripts around one node.
#[derive(Default)]
pub(crate) struct Around {
    failure_if: Option<Expr>,
    success_if: Option<Expr>,
    skip_if: Option<Expr>,
    while_true: Option<Expr>,
    on_success: Vec<Assignment>,
    on_failure: Vec<Assignment>,
    post: Vec<Assignment>,
}

impl Around {
    /// Whether a key is set when the node ends.
    pub(crate) fn has_scripts(&self) -> bool {
        !(self.on_success.is_empty() && self.on_failure.is_empty() && self.post.is_empty())
    }

    fn may_skip(&self) -> bool {
        self.skip_if.is_some() || self.while_true.is_some()
    }

    fn answers(&self) -> bool {
        self.failure_if.is_some() || self.success_if.is_some()
    }
}

impl Translator<'_> {
    /// The scripts around a node; `None` where one is refused.
    pub(crate) fn around(&mut self, element: &Element) -> Option<Around> {
        let mut around = Around::default();
        let mut whole = true;
        for (name, text) in &element.attributes {
            let read = match name.as_str() {
                "_failureIf" => expr(text, &mut around.failure_if),
                "_successIf" => expr(text, &mut around.success_if),
                "_skipIf" => expr(text, &mut around.skip_if),
                "_while" => expr(text, &mut around.while_true),
                "_onSuccess" => script(text, &mut around.on_success),
                "_onFailure" => script(text, &mut around.on_failure),
                "_post" => script(text, &mut around.post),
                "_onHalted" => Err(
                    "a script that runs when a node is stopped has no counterpart; \
                                    a leaf sets the key when it is stopped"
                        .to_owned(),
                ),
                "_autoremap" if element.tag == "SubTree" => Ok(()),
                name if !name.starts_with('_') || IGNORED.contains(&name) => Ok(()),
                _ => Err("this attribute has no counterpart".to_owned()),
            };
            if let Err(why) = read {
                self.refuse(element, format!("{name}: {why}"));
                whole = false;
            }
        }
        whole.then_some(around)
    }

    /// The node with its scripts around it.
    pub(crate) fn surrounded(
        &mut self,
        element: &Element,
        part: Part,
        around: &Around,
        skip: Skip,
    ) -> Option<Part> {
        let at = At::of(element);
        // SKIPPED has no equivalent: it is a success or a failure of the node, as the parent
        // treats it, so a parent that treats it as neither makes the tree refused (ADR 0027).
        if around.may_skip() && skip == Skip::Never {
            let why = "_skipIf and _while need a Sequence or Fallback around the node: no answer \
                       means 'skipped' here";
            self.refuse(element, why);
            return None;
        }
        // Scripts do not run when a node is skipped, but run for the result of _successIf; no
        // order of the wrappers gives both.
        if around.may_skip() && around.answers() && around.has_scripts() {
            let why = "_skipIf or _while together with _successIf or _failureIf and a script after \
                       the node: put a Sequence around the node and one of them on it";
            self.refuse(element, why);
            return None;
        }
        let skips = part.skips || around.may_skip();
        // From the inside out, so that the conditions are evaluated in the order of
        // BehaviorTree.CPP: _failureIf, _successIf, _skipIf, _while.
        let mut out = part.out;
        let answers = around.answers();
        if !answers {
            out = self.with_scripts(out, around, &at);
        }
        if let Some(expr) = &around.while_true {
            out = self.while_true(out, expr, skip, &at);
        }
        if let Some(expr) = &around.skip_if {
            let kind = skipped(skip);
            out = self.on_entry(out, expr, ("skip_if", kind), &at);
        }
        if let Some(expr) = &around.success_if {
            out = self.on_entry(out, expr, ("success_if", "Selector"), &at);
        }
        if let Some(expr) = &around.failure_if {
            out = self.on_entry(out, expr, ("failure_if", "Sequence"), &at);
        }
        // Scripts run for a result of _successIf and _failureIf, too, so they are outside of
        // them.
        if answers {
            out = self.with_scripts(out, around, &at);
        }
        Some(Part { out, skips })
    }

    /// Evaluated when the node is entered: a Selector succeeds if it holds, a Sequence fails.
    fn on_entry(&mut self, node: Out, expr: &Expr, (what, kind): (&str, &str), at: &At) -> Out {
        let id = self.id(&format!("{}.{what}", node.id));
        let condition = self.condition(expr, kind == "Selector", &id, at);
        // With memory the condition is not evaluated again while the node runs.
        Out::new(id, kind, vec![condition, node]).port("memory", true)
    }

    /// Evaluated in every tick; the node is stopped when it does not hold.
    fn while_true(&mut self, node: Out, expr: &Expr, skip: Skip, at: &At) -> Out {
        let id = self.id(&format!("{}.while", node.id));
        let kind = skipped(skip);
        let condition = self.condition(expr, kind == "Sequence", &id, at);
        // Without memory the condition is ticked first in every tick.
        Out::new(id, kind, vec![condition, node]).port("memory", false)
    }

    fn with_scripts(&mut self, node: Out, around: &Around, at: &At) -> Out {
        let own = node.id.clone();
        let after_success: Vec<&Assignment> =
            around.on_success.iter().chain(&around.post).collect();
        let after_failure: Vec<&Assignment> =
            around.on_failure.iter().chain(&around.post).collect();
        let mut out = node;
        // Each assignment succeeds, so a Sequence passes the success of the node on.
        if !after_success.is_empty() {
            let id = self.id(&format!("{own}.on_success"));
            let mut children = vec![out];
            children.extend(after_success.iter().map(|set| self.set(set, &id, at)));
            out = Out::new(id, "Sequence", children).port("memory", true);
        }
        if !after_failure.is_empty() {
            let id = self.id(&format!("{own}.on_failure"));
            let mut children = vec![out];
            for set in after_failure {
                let set = self.set(set, &id, at);
                // An inverted assignment fails, so the Selector runs all of them and then
                // fails.
                let inverter = self.id(&format!("{}.not", set.id));
                children.push(Out::new(inverter, "Inverter", vec![set]));
            }
            out = Out::new(id, "Selector", children).port("memory", true);
        }
        out
    }

    /// A node that succeeds if `expr` has the truth value `wanted`, else fails.
    pub(crate) fn condition(&mut self, expr: &Expr, wanted: bool, base: &str, at: &At) -> Out {
        let id = self.id(&format!("{base}.if"));
        match expr {
            Expr::Constant(value) => self.always(id, *value == wanted),
            // A key without a value differs from every constant, as with an inverter of
            // `equals`, which would be one node more.
            Expr::Not(inner) => match inner.as_ref() {
                Expr::Equals(key, constant) if wanted => {
                    let test = self.constant(key, constant, at);
                    self.test(id, key, ("differs", test))
                }
                inner => self.condition(inner, !wanted, base, at),
            },
            Expr::And(parts) | Expr::Or(parts) => {
                // De Morgan: a negated conjunction is a disjunction of negated parts.
                let all = matches!(expr, Expr::And(_)) == wanted;
                let kind = if all { "Sequence" } else { "Selector" };
                let parts = parts.iter();
                let children = parts.map(|part| self.condition(part, wanted, &id, at));
                let children = children.collect();
                // Without memory all parts are evaluated again in every tick, as one
                // expression.
                Out::new(id, kind, children).port("memory", false)
            }
            Expr::Key(_) | Expr::Equals(..) | Expr::Below(..) | Expr::Above(..) if !wanted => {
                let inner = self.condition(expr, true, &id, at);
                Out::new(id, "Inverter", vec![inner])
            }
            Expr::Key(key) => {
                let name = self.key(key, false);
                let test = Bind::True(self.holder(&name), at.clone());
                self.test(id, key, ("equals", test))
            }
            Expr::Equals(key, constant) => {
                let test = self.constant(key, constant, at);
                self.test(id, key, ("equals", test))
            }
            Expr::Below(key, number) | Expr::Above(key, number) => {
                let name = if matches!(expr, Expr::Below(..)) {
                    "below"
                } else {
                    "above"
                };
                let test = self.constant(key, &Constant::Number(*number), at);
                self.test(id, key, (name, test))
            }
        }
    }

    fn test(&mut self, id: String, key: &str, (test, value): (&str, Bind)) -> Out {
        let key = self.key(key, false);
        if let Some(known) = self.scope.keys.get_mut(&key) {
            known.tested = true;
        }
        let out = Out::new(id, "CheckBlackboard", Vec::new());
        out.bound("key", Bind::Key(key)).bound(test, value)
    }

    /// A constant that is compared with a key or assigned to it.
    fn constant(&mut self, key: &str, constant: &Constant, at: &At) -> Bind {
        let key = self.key(key, false);
        let holder = self.holder(&key);
        let found = Type::of_constant(constant);
        // A key has one type in our files; BehaviorTree.CPP converts between texts and numbers.
        if let Err(before) = self.types.is(&holder, found) {
            self.mixed(at, &key, before, found);
        }
        Bind::Constant(constant.clone(), holder, at.clone())
    }

    pub(crate) fn mixed(&mut self, at: &At, key: &str, before: Type, found: Type) {
        let message = format!(
            "{}: '{key}' is a {} elsewhere, here it is a {}; a key has one type",
            at.node,
            before.name(),
            found.name()
        );
        self.errors.push(&at.file, at.place, message);
    }

    /// An assignment as a node.
    pub(crate) fn set(&mut self, set: &Assignment, base: &str, at: &At) -> Out {
        let id = self.id(&format!("{base}.set_{}", set.key));
        let key = self.key(&set.key, true);
        let value = match &set.from {
            Source::Constant(constant) => self.constant(&set.key, constant, at),
            Source::Key(other) => self.copied(&key, other, at),
        };
        let out = Out::new(id, "SetBlackboard", Vec::new());
        out.bound("key", Bind::Key(key)).bound("value", value)
    }

    /// The value of another key.
    pub(crate) fn copied(&mut self, key: &str, other: &str, at: &At) -> Bind {
        let other = self.key(other, false);
        let (to, from) = (self.holder(key), self.holder(&other));
        if let Err((before, found)) = self.types.same(&to, &from) {
            self.mixed(at, key, before, found);
        }
        Bind::Key(other)
    }

    /// A node that always gives the same result.
    pub(crate) fn always(&mut self, id: String, success: bool) -> Out {
        if success {
            // A Wait of 0 s succeeds in its first tick.
            return Out::new(id, "Wait", Vec::new()).port("seconds", 0);
        }
        let inner = self.id(&format!("{id}.not"));
        let inner = Out::new(inner, "Wait", Vec::new()).port("seconds", 0);
        Out::new(id, "Inverter", vec![inner])
    }
}

/// The composite in which a skipped node gives the result that replaces SKIPPED.
fn skipped(skip: Skip) -> &'static str {
    match skip {
        Skip::Failure => "Sequence",
        Skip::Success | Skip::Never => "Selector",
    }
}

fn expr(text: &str, into: &mut Option<Expr>) -> Result<(), String> {
    *into = Some(script::condition(text)?);
    Ok(())
}

fn script(text: &str, into: &mut Vec<Assignment>) -> Result<(), String> {
    *into = script::assignments(text)?;
    Ok(())
}

//! The modifiers of a node in a file.

use super::advice;
use super::build::Builder;
use super::counterparts;
use super::engine::{self, ABORTS, FINAL_STATUSES};
use super::files::{get, object};
use super::json::{Entry, Value as Json};
use super::kinds::{At, status};
use super::limits::MAX_PORTS;
use crate::tree::{Abort, Host, Modifier};

/// Keys of a modifier.
pub(super) const MODIFIER_KEYS: &[&str] = &["type", "abort", "ports", "doc"];
/// The modifier that has an abort mode.
pub(super) const CHECK: &str = "CheckBlackboard";

impl<'a, H: Host> Builder<'a, H> {
    /// The modifiers of a node, the outermost first.
    pub(super) fn modifiers(
        &mut self,
        at: At<'_, 'a>,
        json: Option<&'a Json>,
    ) -> Option<Vec<Modifier>> {
        let Some(json) = json else {
            return Some(Vec::new());
        };
        let Some(list) = json.as_list().filter(|list| list.len() <= MAX_PORTS) else {
            let message = format!(
                "a list of at most {MAX_PORTS} modifiers is needed here, this is {}",
                json.describe()
            );
            self.errors.push(at.context.file, json.place, message);
            return None;
        };
        // All are read before the result is tested, so that each wrong one is reported.
        let made: Vec<_> = list.iter().map(|item| self.modifier(at, item)).collect();
        made.into_iter().collect()
    }

    fn modifier(&mut self, at: At<'_, 'a>, json: &'a Json) -> Option<Modifier> {
        let file = at.context.file;
        let entries = object(&mut self.errors, file, json, "a modifier", MODIFIER_KEYS)?;
        let Some(value) = get(entries, "type") else {
            let message = "\"type\" is missing; name the type of the modifier";
            self.errors.push(file, json.place, message);
            return None;
        };
        let at = At {
            place: value.place,
            ..at
        };
        let name = value.as_text().unwrap_or_default();
        let Some(spec) = engine::find_modifier(name) else {
            let known: Vec<&str> = engine::MODIFIERS.iter().map(|m| m.name).collect();
            // The name may be a decorator of another library, which is a modifier here.
            let message = match counterparts::of(name) {
                Some(ours) => format!("unknown modifier '{name}'; {ours}"),
                None => advice::unknown("modifier", name, &known),
            };
            self.errors.push(file, value.place, message);
            return None;
        };
        let abort = self.abort(at, entries, name)?;
        let ports = self.engine_ports(at.context, at.place, get(entries, "ports"), spec)?;
        Some(match spec.name {
            "Repeat" => Modifier::Repeat {
                count: ports.count("count").unwrap_or(0),
                break_on_failure: ports.bool("break_on_failure"),
            },
            "Retry" => Modifier::Retry {
                max: ports.count("max").unwrap_or(0),
                reset_on_success: ports.bool("reset_on_success"),
            },
            "InvertStatus" => Modifier::InvertStatus,
            "ForceStatus" => Modifier::ForceStatus(status(ports.choice("status", FINAL_STATUSES))),
            "Delay" => Modifier::Delay(self.seconds(at, &ports)?),
            "Timeout" => Modifier::Timeout(self.seconds(at, &ports)?),
            _ => {
                let (slot, test) = self.test(at, &ports)?;
                Modifier::CheckBlackboard { slot, test, abort }
            }
        })
    }

    fn abort(&mut self, at: At<'_, 'a>, entries: &'a [Entry], name: &str) -> Option<Abort> {
        let Some(value) = get(entries, "abort") else {
            return Some(Abort::None);
        };
        if name != CHECK {
            let message = format!("only {CHECK} has an abort mode, this is {name}");
            self.errors.push(at.context.file, value.place, message);
            return None;
        }
        match value.as_text() {
            Some("none") => Some(Abort::None),
            Some("self") => Some(Abort::Own),
            Some("lower_priority") => Some(Abort::LowerPriority),
            Some("both") => Some(Abort::Both),
            other => {
                let found = other.map_or_else(|| value.describe(), str::to_owned);
                let message = advice::unknown("abort mode", &found, ABORTS);
                self.errors.push(at.context.file, value.place, message);
                None
            }
        }
    }
}

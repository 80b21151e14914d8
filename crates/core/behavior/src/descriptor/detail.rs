//! The ports of a node in one line.

use std::collections::BTreeMap;

use super::build::only_constant;
use super::files::get;
use super::json::{Data, Entry, Value as Json, shortened};
use super::literal;
use crate::value::Value;

/// Number of items of a list that are shown.
const SHOWN: usize = 8;

type Constants = BTreeMap<String, Value>;

/// The ports in one line; a port bound to a constant shows its value.
pub(super) fn detail(entries: &[Entry], constants: &Constants) -> String {
    let mut parts = Vec::new();
    if let Some(name) = get(entries, "subtree").and_then(Json::as_text) {
        parts.push(shortened(name));
    }
    if let (Some(name), Some(items)) = (get(entries, "as"), get(entries, "items")) {
        let name = shortened(name.as_text().unwrap_or_default());
        parts.push(format!("{name} in {}", value(items, constants)));
    }
    parts.extend(ports_line(get(entries, "ports"), constants));
    let modifiers = get(entries, "modifiers").and_then(Json::as_list);
    let settings = modifiers.unwrap_or_default().iter();
    parts.extend(settings.filter_map(|modifier| setting(modifier, constants)));
    parts.join(" ")
}

/// The settings of a modifier; the picture adds its name.
fn setting(modifier: &Json, constants: &Constants) -> Option<String> {
    let mut parts = ports_line(modifier.get("ports"), constants);
    let abort = modifier.get("abort").and_then(Json::as_text);
    parts.extend(abort.map(|abort| format!("abort={}", shortened(abort))));
    (!parts.is_empty()).then(|| format!("[{}]", parts.join(" ")))
}

fn ports_line(ports: Option<&Json>, constants: &Constants) -> Vec<String> {
    let entries = ports.and_then(Json::as_object).unwrap_or_default();
    let line = |e: &Entry| format!("{}={}", shortened(&e.key), value(&e.value, constants));
    entries.iter().map(line).collect()
}

/// `text` with its constants replaced.
fn filled(text: &str, constants: &Constants) -> String {
    let mut filled = text.to_owned();
    for (name, value) in constants {
        if let Some(word) = literal::within_text(*value) {
            filled = filled.replace(&format!("${{{name}}}"), &word);
        }
    }
    filled
}

fn value(json: &Json, constants: &Constants) -> String {
    match &json.data {
        Data::Null => "null".to_owned(),
        Data::Bool(value) => value.to_string(),
        Data::Integer(value) => value.to_string(),
        Data::Number(value) => value.to_string(),
        Data::Text(text) => match only_constant(text).and_then(|name| constants.get(name)) {
            Some(value) => value.to_string(),
            None => format!("'{}'", shortened(&filled(text, constants))),
        },
        Data::List(items) => {
            let mut shown: Vec<String> = items
                .iter()
                .take(SHOWN)
                .map(|item| value(item, constants))
                .collect();
            if items.len() > SHOWN {
                shown.push("...".to_owned());
            }
            format!("[{}]", shown.join(", "))
        }
        // A binding has one entry, the key or the port; its name alone is shown.
        Data::Object(entries) => match entries.as_slice() {
            [entry] => shortened(&filled(
                entry.value.as_text().unwrap_or_default(),
                constants,
            )),
            _ => String::new(),
        },
    }
}

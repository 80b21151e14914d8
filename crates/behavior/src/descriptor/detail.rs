//! Ports of a node in one line.

use super::files::get;
use super::json::{Data, Entry, Value as Json, shortened};

/// Ports in one line.
pub(super) fn detail(entries: &[Entry]) -> String {
    let mut parts = Vec::new();
    if let Some(name) = get(entries, "subtree").and_then(Json::as_text) {
        parts.push(shortened(name));
    }
    parts.extend(ports_line(get(entries, "ports")));
    parts.join(" ")
}

fn ports_line(ports: Option<&Json>) -> Vec<String> {
    let entries = ports.and_then(Json::as_object).unwrap_or_default();
    let line = |e: &Entry| format!("{}={}", shortened(&e.key), value(&e.value));
    entries.iter().map(line).collect()
}

fn value(json: &Json) -> String {
    match &json.data {
        Data::Null => "null".to_owned(),
        Data::Bool(value) => value.to_string(),
        Data::Integer(value) => value.to_string(),
        Data::Number(value) => value.to_string(),
        Data::Text(text) => format!("'{}'", shortened(text)),
        Data::List(items) => {
            let items: Vec<String> = items.iter().take(8).map(value).collect();
            format!("[{}]", items.join(", "))
        }
        Data::Object(entries) => match entries.as_slice() {
            [entry] => shortened(entry.value.as_text().unwrap_or_default()),
            _ => String::new(),
        },
    }
}

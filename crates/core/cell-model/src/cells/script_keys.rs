//! The keys of a line of a script.

use serde_json::{Map, Value};

use crate::suggest;

/// Keys that decide when a line fires.
pub(super) const TRIGGER_KEYS: [&str; 4] = ["at_s", "at_phase", "nth", "after_s"];

/// The actions of a line, with the keys of each.
const ACTIONS: [(&str, &[&str]); 20] = [
    ("drag", &["object", "to", "for_s"]),
    ("kill", &["process"]),
    ("stop", &["process", "for_s"]),
    ("restart", &["process", "policy"]),
    ("starve", &["for_s"]),
    ("fill", &["for_s"]),
    ("corrupt", &["file"]),
    ("gripper", &["to", "arm"]),
    ("target", &["position", "orientation_wxyz", "arm"]),
    ("add_bin", &["flipped"]),
    ("drop_parts", &["count"]),
    ("task_start", &[]),
    ("task_pause", &[]),
    ("task_resume", &[]),
    ("task_reset", &[]),
    ("pause", &["for_s"]),
    ("resume", &[]),
    ("reset", &[]),
    ("speed", &["to"]),
    ("break", &["name", "remove"]),
];

/// Refuses unknown actions and keys, with the nearest known name.
pub(super) fn check_keys(line: &Map<String, Value>) -> Result<(), String> {
    let names = ACTIONS.map(|(name, _)| name);
    let asked = match line.get("do") {
        Some(Value::String(asked)) => asked,
        Some(other) => return Err(format!("do is {other}, a text is needed")),
        None => return missing_action(line),
    };
    let Some((_, keys)) = ACTIONS.iter().find(|(name, _)| name == asked) else {
        let advice = suggest::advice(asked, &names);
        return Err(format!("unknown action '{asked}'; {advice}"));
    };
    let known: Vec<&str> = ["do"]
        .iter()
        .chain(*keys)
        .chain(&TRIGGER_KEYS)
        .copied()
        .collect();
    match line.keys().find(|key| !known.contains(&key.as_str())) {
        None => Ok(()),
        Some(key) => {
            let advice = suggest::advice(key, &known);
            Err(format!("unknown key '{key}' of {asked}; {advice}"))
        }
    }
}

/// Error for a line without an action; names a key that was probably meant as `do`.
fn missing_action(line: &Map<String, Value>) -> Result<(), String> {
    let is_known = |key: &&String| !TRIGGER_KEYS.contains(&key.as_str());
    let unknown = line.keys().find(is_known);
    let unknown = unknown.map_or_else(String::new, |key| format!(", there is '{key}'"));
    Err(format!("key 'do' is missing{unknown}"))
}

#[cfg(test)]
mod tests {
    use crate::cells::script::parse;

    fn refused(line: &str) -> String {
        let text = format!("{{\"at_s\": 1, \"do\": \"pause\"}}\n{line}");
        parse(&text, "s.jsonl").unwrap_err().to_string()
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line_and_the_one_that_was_meant() {
        let said = refused(r#"{"at_s": 1, "do": "drop_parts", "conut": 3}"#);
        let wanted = "s.jsonl:2: unknown key 'conut' of drop_parts; did you mean 'count'?";
        assert!(said.starts_with(wanted), "{said}");
        let said = refused(r#"{"at_phase": "LIFT", "nht": 2, "do": "pause"}"#);
        assert!(
            said.contains("'nht'") && said.contains("did you mean 'nth'?"),
            "{said}"
        );
        let said = refused(r#"{"at_s": 1, "do": "dragg"}"#);
        assert!(
            said.contains("unknown action 'dragg'; did you mean 'drag'?"),
            "{said}"
        );
        assert!(
            refused(r#"{"at_s": 1, "doo": "drag"}"#).contains("'do' is missing, there is 'doo'")
        );
        assert!(refused(r#"{"at_s": 1, "do": 7}"#).contains("do is 7"));
    }

    #[test]
    fn every_action_is_known_by_its_name() {
        for (name, _) in super::ACTIONS {
            let said = parse(&format!(r#"{{"at_s": 1, "do": "{name}"}}"#), "s");
            let is_known =
                said.map_or_else(|error| !error.to_string().contains("unknown"), |_| true);
            assert!(is_known, "{name}");
        }
    }
}

//! Scripts: one JSON object in each line, run at a simulated time or a phase.

use crate::cells::cell::Cell;
use crate::cells::script_check;
use crate::cells::script_keys::{TRIGGER_KEYS, check_keys};
use crate::runs::speed::Speed;

pub use crate::cells::script_line::{CORRUPTIBLE, GripperWord, ScriptAction, ScriptLine, Trigger};
pub use crate::cells::script_runner::{ScriptProgress, ScriptRunner};

/// Shown to the author of a line that cannot be read.
const EXAMPLE: &str =
    r#"{"at_s": 12.0, "do": "drag", "object": "blue_cube", "to": [0.5, -0.2, 0.025]}"#;

/// Largest number of lines of a script.
// Each line that was executed has a reply, which is in the state that physics saves twice a
// second, and in the summary.
pub(crate) const MAX_LINES: usize = 10_000;
/// Largest number of parts that a line may drop at a time.
const MAX_PARTS: f64 = 100.0;

/// A line that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{file}:{line}: {problem}")]
pub struct ScriptError {
    file: String,
    line: usize,
    problem: String,
}

/// Reads a script; empty lines are skipped. `file` is for messages.
///
/// # Errors
/// Returns [`ScriptError`] for the first line that cannot be used.
pub fn parse(text: &str, file: &str) -> Result<Vec<ScriptLine>, ScriptError> {
    parse_with(text, file, |_| Ok(()))
}

/// As [`parse`], and refuses objects, arms and controllers that the cell does not have.
///
/// # Errors
/// As [`parse`].
pub fn parse_for(text: &str, file: &str, cell: &Cell) -> Result<Vec<ScriptLine>, ScriptError> {
    parse_with(text, file, |line| script_check::check(&line.action, cell))
}

fn parse_with(
    text: &str,
    file: &str,
    also: impl Fn(&ScriptLine) -> Result<(), String>,
) -> Result<Vec<ScriptLine>, ScriptError> {
    let mut lines = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if line.trim().is_empty() {
            continue;
        }
        let fail = |problem: String| ScriptError {
            file: file.to_owned(),
            line: index + 1,
            problem,
        };
        if lines.len() == MAX_LINES {
            return Err(fail(format!(
                "a script has at most {MAX_LINES} lines; split the run"
            )));
        }
        let parsed = parse_line(line)
            // The example is shown only where the line cannot be read at all; other errors name
            // the key.
            .map_err(|problem| fail(format!("{problem}; a line looks like {EXAMPLE}")))?;
        check_trigger(&parsed.trigger).map_err(fail)?;
        check_action(&parsed.action).map_err(fail)?;
        also(&parsed).map_err(fail)?;
        lines.push(parsed);
    }
    Ok(lines)
}

fn parse_line(line: &str) -> Result<ScriptLine, String> {
    let value: serde_json::Value = serde_json::from_str(line).map_err(|e| e.to_string())?;
    let Some(object) = value.as_object() else {
        return Err("not a JSON object".to_owned());
    };
    let part = |of_trigger: bool| {
        object
            .iter()
            .filter(|(key, _)| TRIGGER_KEYS.contains(&key.as_str()) == of_trigger)
            .map(|(key, value)| (key.clone(), value.clone()))
            .collect::<serde_json::Map<_, _>>()
    };
    // Both or neither have no meaning; the reader would take the first that fits.
    if object.contains_key("at_s") == object.contains_key("at_phase") {
        return Err("give either at_s or at_phase".to_owned());
    }
    if object.contains_key("at_s") && (object.contains_key("nth") || object.contains_key("after_s"))
    {
        return Err("nth and after_s belong to at_phase, not to at_s".to_owned());
    }
    // Keys are checked first: this error names the key that was probably meant.
    check_keys(object)?;
    let trigger: Trigger = serde_json::from_value(part(true).into()).map_err(|e| e.to_string())?;
    let action: ScriptAction =
        serde_json::from_value(part(false).into()).map_err(|e| e.to_string())?;
    Ok(ScriptLine { trigger, action })
}

fn within(key: &str, value: f64, low: f64, high: f64) -> Result<(), String> {
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(format!("{key} is {value}, allowed is {low} to {high}"))
    }
}

fn check_trigger(trigger: &Trigger) -> Result<(), String> {
    match trigger {
        Trigger::Time { at_s } => within("at_s", *at_s, 0.0, 1.0e6),
        Trigger::Phase { nth, after_s, .. } => {
            within("nth", f64::from(*nth), 1.0, 1.0e6)?;
            within("after_s", *after_s, 0.0, 1.0e6)
        }
    }
}

fn check_action(action: &ScriptAction) -> Result<(), String> {
    match action {
        ScriptAction::Drag { to, for_s, .. } => {
            within("for_s", *for_s, 0.001, 3600.0)?;
            to.iter().try_for_each(|c| within("to", *c, -20.0, 20.0))
        }
        ScriptAction::Stop { for_s, process } => {
            script_check::process_word(process)?;
            within("for_s", *for_s, 0.001, 3600.0)
        }
        ScriptAction::Restart { process, policy } => {
            script_check::process_word(process)?;
            match policy {
                Some(policy) if process != "task" => {
                    Err(format!("policy is {policy:?}; only the task has one"))
                }
                _ => Ok(()),
            }
        }
        ScriptAction::Starve { for_s }
        | ScriptAction::Fill { for_s }
        | ScriptAction::Pause { for_s: Some(for_s) } => within("for_s", *for_s, 0.001, 3600.0),
        ScriptAction::Corrupt { file } if !CORRUPTIBLE.contains(&file.as_str()) => Err(format!(
            "file is {file:?}, allowed are {}",
            CORRUPTIBLE.join(", ")
        )),
        ScriptAction::Speed { to } if Speed::of_factor(*to).is_none() => Err(format!(
            "to is {to}; allowed are 1 (real time), 0 (as fast as possible), or 0.01 to 50"
        )),
        ScriptAction::DropParts { count } => within("count", f64::from(*count), 0.0, MAX_PARTS),
        ScriptAction::Kill { process } => script_check::process_word(process),
        ScriptAction::Target {
            position,
            orientation_wxyz,
            ..
        } => {
            let length = |q: &[f64; 4]| q.iter().map(|x| x * x).sum::<f64>().sqrt();
            if let Some(orientation) = orientation_wxyz {
                within(
                    "length of orientation_wxyz",
                    length(orientation),
                    0.99,
                    1.01,
                )?;
            }
            let mut position = position.iter();
            position.try_for_each(|c| within("position", *c, -100.0, 100.0))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documented_lines_are_read() {
        let text = r#"
{"at_s": 12.0, "do": "drag", "object": "blue_cube", "to": [0.5, -0.2, 0.025]}
{"at_phase": "LIFT", "nth": 2, "do": "kill", "process": "task"}
{"at_s": 1, "do": "task_pause"}
{"at_s": 1, "do": "gripper", "to": "open"}
"#;
        let lines = parse(text, "s.jsonl").unwrap();
        assert_eq!(lines.len(), 4);
        assert!(lines[1].action.is_for_launcher());
        let copy: Vec<ScriptLine> =
            serde_json::from_str(&serde_json::to_string(&lines).unwrap()).unwrap();
        assert_eq!(copy, lines);
    }

    #[test]
    fn bad_lines_are_named() {
        for (text, word) in [
            ("\n{\"at_s\": 1}", "do"),
            ("\n{\"at_s\": -1, \"do\": \"pause\"}", "at_s"),
            ("\n{\"do\": \"pause\"}", "at_phase"),
            ("\n{\"at_s\": 1, \"do\": \"dragg\"}", "dragg"),
            ("\n{\"at_s\": 1, \"do\": \"pause\", \"objct\": 1}", "objct"),
            (
                "\n{\"at_s\": 1, \"do\": \"kill\", \"process\": \"init\"}",
                "init",
            ),
            (
                "\n{\"at_s\": 1, \"do\": \"corrupt\", \"file\": \"/etc/passwd\"}",
                "task.slots",
            ),
            ("\n{\"at_s\": 1, \"do\": \"speed\", \"to\": 99}", "50"),
            (
                "\n{\"at_s\": 1, \"do\": \"restart\", \"process\": \"physics\", \"policy\": \"fsm\"}",
                "only the task",
            ),
            ("\n{\"at_s\": 1, \"nth\": 2, \"do\": \"pause\"}", "nth"),
            ("\n{", "s.jsonl:2"),
        ] {
            let message = parse(text, "s.jsonl").unwrap_err().to_string();
            assert!(
                message.contains(word) && message.starts_with("s.jsonl:2"),
                "{message}"
            );
        }
    }

    #[test]
    fn a_script_of_too_many_lines_is_refused_with_the_number() {
        let line = "{\"at_s\": 1, \"do\": \"pause\"}\n";
        let lines = |count| parse(&line.repeat(count), "s.jsonl");
        assert_eq!(lines(MAX_LINES).unwrap().len(), MAX_LINES);
        let message = lines(MAX_LINES + 1).unwrap_err().to_string();
        assert!(message.contains("10000 lines"), "{message}");
        assert!(message.starts_with("s.jsonl:10001"), "{message}");
    }
}

//! Phases for which a script waits, and the graph of the policy that shall enter them.

use cell_model::cells::script::{ScriptLine, Trigger};
use cell_model::runs::phase_name;
use cell_model::suggest;

/// One warning for each phase of `script` that is not in `drawing`, as the task program drew
/// the policy of `demo`. Only a warning: a policy in Rust may have phases that it does not
/// draw.
pub(super) fn unknown(script: &[ScriptLine], drawing: &str, demo: &str) -> Vec<String> {
    let drawn = plain(drawing);
    let mut asked: Vec<&str> = script.iter().filter_map(phase).collect();
    asked.dedup();
    asked.retain(|phase| !is_in(&plain(phase), &drawn));
    let words: Vec<&str> = words(drawing);
    let warning = |phase: &str| {
        format!(
            "the script waits for phase '{phase}', which the policy (`robocell fsm show {demo}` or \
             `bt show {demo}`) does not show{}",
            did_you_mean(phase, &words)
        )
    };
    asked.into_iter().map(warning).collect()
}

fn phase(line: &ScriptLine) -> Option<&str> {
    match &line.trigger {
        Trigger::Phase { at_phase, .. } => Some(at_phase),
        Trigger::Time { .. } => None,
    }
}

/// Whether a phase is in the graph. Phases of several arms start with the arm. The phases of
/// every policy, and a policy without a graph, need none.
fn is_in(phase: &str, drawn: &str) -> bool {
    let of_an_arm = phase.split_once('_').map_or(phase, |(_, rest)| rest);
    drawn.is_empty()
        || ["DONE", "FAILED", "IDLE", "HOLD"].contains(&phase)
        || drawn.contains(phase)
        || drawn.contains(of_an_arm)
}

/// The form that names of nodes have as phases.
fn plain(text: &str) -> String {
    phase_name::chars(&[text]).collect()
}

fn words(drawing: &str) -> Vec<&str> {
    let ends = |c: char| !(c.is_ascii_alphanumeric() || c == '_');
    drawing.split(ends).filter(|word| word.len() > 1).collect()
}

fn did_you_mean(phase: &str, words: &[&str]) -> String {
    let near = suggest::nearest(phase, words);
    near.map_or_else(String::new, |near| format!(", did you mean `{near}`?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_phase_is_named_with_what_was_meant() {
        let text = r#"{"at_phase": "LFIT", "do": "kill", "process": "task"}
{"at_phase": "DONE", "do": "pause"}
{"at_phase": "LEFT_PRE_GRASP", "do": "pause"}
{"at_s": 1, "do": "pause"}"#;
        let script = cell_model::cells::script::parse(text, "script").unwrap();
        let warnings = unknown(&script, "PRE_GRASP\n  -> LIFT: settled", "franka-stack");
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(warnings[0].contains("'LFIT'"), "{warnings:?}");
        assert!(warnings[0].contains("did you mean `LIFT`?"), "{warnings:?}");
        let tree = unknown(&script, "├── lfit (Leaf)\n├── pre grasp (Leaf)", "x");
        assert_eq!(tree, Vec::<String>::new());
        assert_eq!(unknown(&script, "", "x"), Vec::<String>::new());
    }
}

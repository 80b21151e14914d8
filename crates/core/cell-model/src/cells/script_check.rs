//! Checks of the processes, objects and arms that a script names.

use crate::cells::cell::Cell;
use crate::cells::script_line::ScriptAction;
use crate::suggest;

/// Refuses an action on a part that `cell` does not have.
pub(crate) fn check(action: &ScriptAction, cell: &Cell) -> Result<(), String> {
    match action {
        ScriptAction::Drag { object, .. } => cell
            .object_index(object)
            .map(|_| ())
            .map_err(|error| error.to_string()),
        ScriptAction::Kill { process }
        | ScriptAction::Stop { process, .. }
        | ScriptAction::Restart { process, .. } => controller(process, cell),
        ScriptAction::Target { arm, .. } => arm_index(*arm, cell).map(|_| ()),
        ScriptAction::Gripper { arm, .. } => gripper(*arm, cell),
        ScriptAction::AddBin { .. } => {
            let supply = cell.conveyor.as_ref().and_then(|belt| belt.supply.as_ref());
            there_is(supply.is_some(), "conveyor that brings bins")
        }
        ScriptAction::DropParts { .. } => there_is(cell.dispenser.is_some(), "dispenser"),
        _ => Ok(()),
    }
}

fn there_is(device: bool, what: &str) -> Result<(), String> {
    if device {
        Ok(())
    } else {
        Err(format!("this cell has no {what}"))
    }
}

fn arm_index(arm: u32, cell: &Cell) -> Result<usize, String> {
    let index = arm as usize;
    if index < cell.arms.len() {
        return Ok(index);
    }
    let names: Vec<String> = cell
        .arms
        .iter()
        .enumerate()
        .map(|(index, arm)| format!("{index} ({})", arm.name))
        .collect();
    let known = names.join(", ");
    Err(format!("arm is {arm}, this cell has {known}"))
}

fn gripper(arm: u32, cell: &Cell) -> Result<(), String> {
    let index = arm_index(arm, cell)?;
    let has = |arm: &crate::ArmSpec| arm.robot.gripper.is_some() || arm.robot.suction.is_some();
    if cell.arms.get(index).is_some_and(has) {
        return Ok(());
    }
    Err(format!("arm {arm} has no gripper"))
}

/// Checks a name: `controller` means those of all arms, `controller-1` that of one.
fn controller(process: &str, cell: &Cell) -> Result<(), String> {
    let arm = process.strip_prefix("controller-");
    match arm.and_then(|arm| arm.parse::<u32>().ok()) {
        Some(arm) => arm_index(arm, cell)
            .map(|_| ())
            .map_err(|error| format!("process is {process:?}: {error}")),
        // `process_word` has checked the name, without a cell.
        None => Ok(()),
    }
}

/// Refuses a name that is not a process.
pub(crate) fn process_word(process: &str) -> Result<(), String> {
    let known = [
        "task",
        "physics",
        "monitor",
        "controller",
        "controller-0",
        "controller-1",
    ];
    if known.contains(&process) {
        return Ok(());
    }
    let advice = suggest::advice(process, &known);
    Err(format!("process {process:?} is unknown; {advice}"))
}

#[cfg(test)]
mod tests {
    use crate::cells::script::parse_for;
    use crate::{Cell, Data};

    #[test]
    fn what_a_cell_does_not_have_is_refused_with_the_line() {
        let load = |demo| Cell::load(&Data::checkout(), demo, 1, None).unwrap();
        let (one, two) = (load("franka-stack"), load("franka-pyramid"));
        let cases = [
            (
                r#""do": "gripper", "to": "open", "arm": 1"#,
                "arm is 1, this cell has 0 (panda)",
            ),
            (
                r#""do": "target", "position": [0, 0, 0], "arm": 1"#,
                "arm is 1",
            ),
            (r#""do": "kill", "process": "controller-1""#, "controller-1"),
            (
                r#""do": "stop", "for_s": 1, "process": "controller-1""#,
                "arm is 1",
            ),
            (
                r#""do": "drag", "object": "cube_1", "to": [0, 0, 0]"#,
                "unknown object 'cube_1'",
            ),
        ];
        for (action, word) in cases {
            let text = format!("\n{{\"at_s\": 1, {action}}}");
            let error = parse_for(&text, "s.jsonl", &one).unwrap_err().to_string();
            assert!(
                error.starts_with("s.jsonl:2: ") && error.contains(word),
                "{error}"
            );
            assert_eq!(parse_for(&text, "s.jsonl", &two).unwrap().len(), 1);
        }
        let three = r#"{"at_s": 1, "do": "gripper", "to": "open", "arm": 2}"#;
        let error = parse_for(three, "s", &two).unwrap_err().to_string();
        assert!(error.contains("0 (left), 1 (right)"), "{error}");
        let many = r#"{"at_s": 1, "do": "drop_parts", "count": 1000}"#;
        let error = parse_for(many, "s", &load("ur10-fill-bin")).unwrap_err();
        let said = "s:1: count is 1000, allowed is 0 to 100";
        assert_eq!(error.to_string(), said);
        let all = r#"{"at_s": 1, "do": "kill", "process": "controller"}"#;
        assert!(parse_for(all, "s", &one).is_ok());
    }
}

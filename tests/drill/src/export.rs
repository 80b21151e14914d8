//! A plan for the real cell: its scene as a cell file, its faults and requests as lines of a script.
#![expect(clippy::format_push_string, reason = "short texts, made once in a run")]

use std::path::Path;

use serde_json::{Value, json};

use crate::plan::{Asked, Fault, Plan, ticks};
use crate::scene::TaskPlan;

/// How a real cell repeats a plan.
#[derive(Clone, Debug)]
pub struct Exported {
    /// The command.
    pub command: String,
    /// Events that have no line in a script.
    pub only_simulated: usize,
}

/// Writes the files of `plan` to `dir`; `ticks_per_ms` is how fast simulated time passed.
///
/// # Errors
/// Those of the file system.
pub fn write(plan: &Plan, ticks_per_ms: f64, dir: &Path) -> std::io::Result<Exported> {
    let (script, mut only_simulated) = script(plan, ticks_per_ms);
    std::fs::create_dir_all(dir)?;
    let script_path = dir.join("script.jsonl");
    std::fs::write(&script_path, script)?;
    let mut options = String::new();
    let mut policy = plan.policy.as_str();
    if let Some(scene) = &plan.scene {
        let mut scene = scene.clone();
        if let TaskPlan::Stub { .. } = scene.task {
            // A real cell has no such task: the arm follows its operator.
            (scene.task, policy) = (TaskPlan::Follow, "follow");
            only_simulated += 1;
        }
        scene.write(dir)?;
        options += &format!(" --data {}", dir.display());
        if !scene.joints.is_empty() {
            options += &format!(" --robot {}", dir.join("robot.urdf").display());
        }
    }
    let speed = if plan.lockstep { "max" } else { "1" };
    let end_s = (plan.horizon_ms as f64 * ticks_per_ms * 1.0e-3).ceil();
    let command = format!(
        "robocell run {} --policy {policy} --seed {}{options} --script {} --speed {speed} \
         --headless --timeout {end_s}",
        plan.demo,
        plan.seed,
        script_path.display()
    );
    Ok(Exported {
        command,
        only_simulated,
    })
}

/// The lines of the script, and the number of events that have none.
fn script(plan: &Plan, ticks_per_ms: f64) -> (String, usize) {
    let mut only_simulated = 0;
    let mut lines: Vec<(u64, String)> = Vec::new();
    for line in &plan.script {
        let at_s = serde_json::from_str::<Value>(line).ok();
        let at_s = at_s.and_then(|line| line["at_s"].as_f64()).unwrap_or(0.0);
        lines.push((ticks(at_s), line.clone()));
    }
    let faults = plan.faults.iter();
    let faults = faults.map(|timed| (timed.at_us, of_fault(&timed.fault)));
    let people = plan.people.iter();
    let people = people.map(|asked| (asked.at_us, of_request(asked)));
    for (at_us, action) in faults.chain(people) {
        let Some(Value::Object(mut action)) = action else {
            only_simulated += 1;
            continue;
        };
        // A script counts simulated time.
        let at_s = (at_us as f64 * 1.0e-6 * ticks_per_ms).max(0.001);
        action.insert("at_s".to_owned(), json!(at_s));
        lines.push((ticks(at_s), Value::Object(action).to_string()));
    }
    lines.sort();
    let mut script = String::new();
    for (_, line) in &lines {
        script += line;
        script.push('\n');
    }
    (script, only_simulated)
}

fn of_fault(fault: &Fault) -> Option<Value> {
    match fault {
        Fault::Restart { process } => Some(json!({"do": "restart", "process": process})),
        Fault::Full { for_ms } => Some(json!({"do": "fill", "for_s": *for_ms as f64 * 1.0e-3})),
        Fault::Kill { process, .. }
        | Fault::FailedStart { process }
        | Fault::SlowStart { process, .. } => Some(json!({"do": "kill", "process": process})),
        Fault::Stop { process, for_ms } => {
            let for_s = *for_ms as f64 * 1.0e-3;
            Some(json!({"do": "stop", "process": process, "for_s": for_s}))
        }
        _ => None,
    }
}

fn of_request(asked: &Asked) -> Option<Value> {
    match asked.action.as_str() {
        "reset" | "task_reset" | "task_pause" | "task_resume" | "task_start" => {
            Some(json!({"do": asked.action}))
        }
        // After a pause no line is due any more: ticks do not pass.
        _ => None,
    }
}

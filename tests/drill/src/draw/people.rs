//! Draws requests of people, and lines of a script.

use super::Draw;
use crate::plan::{Asked, Plan};

/// Requests: what is paused is resumed some time later.
pub(super) fn people(draw: &mut Draw, horizon_ms: u64) -> Vec<Asked> {
    let mut people = Vec::new();
    for _ in 0..draw.log(1, 6) {
        // Half of them while the arms are near their start.
        let most_ms = if draw.percent(50) {
            horizon_ms.min(1_500)
        } else {
            horizon_ms
        };
        let at_us = draw.below(most_ms * 1000);
        let after_us = at_us + 1000 * draw.log(5, 1_500);
        let ask = |at_us: u64, action: &str, count: u32| Asked {
            at_us,
            action: action.to_owned(),
            count,
            draw: 0,
        };
        let others = [
            "task_start",
            "drag",
            "target",
            "gripper",
            "drop_parts",
            "add_bin",
        ];
        match draw.below(8) {
            0 => people.push(ask(at_us, "reset", 0)),
            1 => people.push(ask(at_us, "task_reset", 0)),
            2 => {
                people.push(ask(at_us, "task_pause", 0));
                people.push(ask(after_us, "task_resume", 0));
            }
            3 => {
                people.push(ask(at_us, "step", 5));
                people.push(ask(after_us, "resume", 0));
            }
            4 | 5 => {
                people.push(ask(at_us, "pause", 0));
                people.push(ask(after_us, "resume", 0));
            }
            _ => {
                let action = others[draw.index(others.len())];
                let count = u32::try_from(draw.below(4)).unwrap_or(0);
                let draw = draw.below(u64::MAX);
                people.push(Asked {
                    draw,
                    ..ask(at_us, action, count)
                });
            }
        }
    }
    people.sort_by_key(|asked| asked.at_us);
    people
}

/// Lines about processes.
pub(super) fn script(draw: &mut Draw, plan: &Plan, arms: u8) -> Vec<String> {
    let all = ipc_types::topic::Process::all(arms);
    let mut lines: Vec<(u64, String)> = Vec::new();
    for _ in 0..draw.log(1, 4) {
        let ms = draw.below(plan.horizon_ms);
        let of = draw.one(&all).map_or_else(String::new, |of| of.name());
        if draw.percent(25) {
            lines.push((ms, machine_line(draw)));
            continue;
        }
        if !draw.percent(70) {
            let for_s = draw.log(20, 1_500) as f64 * 1.0e-3;
            lines.push((
                ms,
                format!("\"stop\", \"process\": \"{of}\", \"for_s\": {for_s}"),
            ));
            continue;
        }
        let kill = format!("\"kill\", \"process\": \"{of}\"");
        // Its successor may be starting.
        if draw.percent(30) {
            lines.push((ms + draw.log(1, 60), kill.clone()));
        }
        lines.push((ms, kill));
    }
    lines.sort();
    let line = |(ms, what): (u64, String)| {
        let at_s = ms as f64 * 1.0e-3;
        format!("{{\"at_s\": {at_s}, \"do\": {what}}}")
    };
    lines.into_iter().map(line).collect()
}

/// A line about the machine, or about simulated time.
fn machine_line(draw: &mut Draw) -> String {
    let for_s = draw.log(20, 1_500) as f64 * 1.0e-3;
    match draw.below(4) {
        0 => format!("\"starve\", \"for_s\": {for_s}"),
        1 => format!("\"fill\", \"for_s\": {for_s}"),
        2 => "\"restart\", \"process\": \"task\"".to_owned(),
        _ => format!("\"pause\", \"for_s\": {for_s}"),
    }
}

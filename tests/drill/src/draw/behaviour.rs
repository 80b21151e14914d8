//! Draws behaviour files: trees, tables and matrices whose steps are real skills.
//!
//! They do nothing useful. What they have to do is to resume as they were.
#![expect(clippy::format_push_string, reason = "short texts, made once in a run")]

use serde_json::{Value, json};

use super::Draw;
use crate::scene::TaskPlan;

/// A file of any kind about these objects.
pub(super) fn any(draw: &mut Draw, objects: &[&str]) -> TaskPlan {
    let (kind, text) = match draw.below(3) {
        0 => ("tree", tree(draw, objects)),
        1 => ("machine", machine(draw, objects)),
        _ => ("matrix", matrix(draw, objects)),
    };
    let kind = kind.to_owned();
    TaskPlan::File { kind, text }
}

/// A skill or a condition, as type and ports.
fn leaf(draw: &mut Draw, objects: &[&str], is_step: bool) -> (&'static str, Value) {
    let object = objects
        .get(draw.index(objects.len()))
        .copied()
        .unwrap_or("");
    let metres = 0.01 * draw.log(2, 25) as f64;
    match draw.below(if is_step { 7 } else { 9 }) {
        0 | 1 => ("MoveTo", json!({"object": object, "above_m": metres})),
        2 => (
            "MoveTo",
            json!({"object": object, "place": "mark", "above_m": metres}),
        ),
        3 => ("Close", json!({"object": object})),
        4 => ("Open", json!({})),
        5 => ("Up", json!({"by_m": metres})),
        6 => ("Home", json!({})),
        7 => ("Holding", json!({"object": object})),
        _ => ("At", json!({"object": object, "place": "mark"})),
    }
}

fn tree(draw: &mut Draw, objects: &[&str]) -> String {
    let mut count = 0;
    let root = node(draw, objects, 4, &mut count);
    json!({"format": "behavior-tree/1", "name": "drawn", "root": root}).to_string()
}

fn node(draw: &mut Draw, objects: &[&str], depth: u32, count: &mut u32) -> Value {
    *count += 1;
    let id = format!("n{count}");
    if depth == 0 || (depth < 4 && draw.percent(40)) {
        let (kind, ports) = leaf(draw, objects, false);
        return json!({"id": id, "type": kind, "name": id, "ports": ports});
    }
    let kind = ["Sequence", "Selector"][draw.index(2)];
    let children: Vec<Value> = (0..=draw.below(3))
        .map(|_| node(draw, objects, depth - 1, count))
        .collect();
    let ports = json!({"memory": draw.percent(50)});
    json!({"id": id, "type": kind, "name": id, "ports": ports, "children": children})
}

fn step(draw: &mut Draw, objects: &[&str]) -> String {
    let (kind, ports) = leaf(draw, objects, true);
    let ports = ports.as_object().cloned().unwrap_or_default();
    let ports = ports
        .iter()
        .map(|(key, value)| format!(", {key} = {value}"));
    format!("{{ do = \"{kind}\"{} }}", ports.collect::<String>())
}

/// One to three steps, as an inline table each.
fn steps(draw: &mut Draw, objects: &[&str]) -> String {
    let count = 1 + draw.below(3);
    let steps: Vec<String> = (0..count).map(|_| step(draw, objects)).collect();
    format!("[{}]", steps.join(", "))
}

fn machine(draw: &mut Draw, objects: &[&str]) -> String {
    let count = draw.log(2, 12);
    let object = Value::from(objects.first().copied().unwrap_or(""));
    let mut text = "version = 1\nname = \"drawn\"\ninitial = \"s0\"\n".to_owned();
    for state in 0..count {
        let steps = steps(draw, objects);
        text += &format!(
            "[[states]]\nname = \"s{state}\"\nduring.success = \"ok\"\nduring.failure = \"no\"\nduring.steps = {steps}\n"
        );
    }
    text += &format!("[events]\nheld = {{ do = \"Holding\", object = {object} }}\n");
    for state in 0..count {
        for trigger in ["ok", "no"] {
            let dest = draw.below(count);
            text += &format!(
                "[[rows]]\ntrigger = \"{trigger}\"\nsource = \"s{state}\"\ndest = \"s{dest}\"\n"
            );
        }
    }
    // A level that holds for long: its row must not lead back to where it holds.
    text += "[[rows]]\ntrigger = \"held\"\nsource = \"s0\"\ndest = \"s1\"\n";
    text
}

fn matrix(draw: &mut Draw, objects: &[&str]) -> String {
    let count = draw.log(2, 8);
    let states: Vec<String> = (0..count).map(|state| format!("\"S{state}\"")).collect();
    let mut text = format!(
        "version = 1\nname = \"drawn\"\nstates = [{}]\ninitial = \"S0\"\n\
         precedence = [\"OK\", \"NO\", \"IDLE\"]\n",
        states.join(", ")
    );
    let object = Value::from(objects.first().copied().unwrap_or(""));
    text += &format!("[events]\nIDLE = {{ do = \"Holding\", object = {object}, not = true }}\n");
    for state in 0..count {
        let (ok, no) = (draw.below(count), draw.below(count));
        text += &format!(
            "[cells.S{state}]\nOK = {{ handler = \"h{ok}\", goto = \"S{ok}\" }}\n\
             NO = {{ handler = \"h{no}\", goto = \"S{no}\" }}\nIDLE = \"h{state}\"\n"
        );
    }
    for state in 0..count {
        let steps = steps(draw, objects);
        text +=
            &format!("[handlers.h{state}]\nsuccess = \"OK\"\nfailure = \"NO\"\nsteps = {steps}\n");
    }
    text
}

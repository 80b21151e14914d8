//! The first field in which two messages differ.

use std::fmt::Debug;

use schemars::JsonSchema;
use serde::Serialize;

/// The first difference between a recorded and a computed message.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Difference {
    /// `decision`, `command of arm 0`, `status of arm 0`, `record of task`, ...
    pub message: String,
    /// Generation of its writer.
    pub generation: u32,
    /// Its number.
    pub seq: u64,
    /// The tick that caused it.
    pub tick: u64,
    /// Path of the field, as `goals[0].target.position[2]`.
    pub field: String,
    /// Its value in the recording.
    pub recorded: String,
    /// Its value as computed.
    pub computed: String,
}

/// Path and both values of the first field that differs.
pub(super) fn first_field<T: Debug>(recorded: &T, computed: &T) -> (String, String, String) {
    // The printed form is compared, not the bytes: it has the names of the fields, for any type
    // with `Debug` and without a table of offsets.
    let (one, other) = (format!("{recorded:#?}"), format!("{computed:#?}"));
    let mut path = Path::default();
    for (a, b) in one.lines().zip(other.lines()) {
        path.enter(a);
        if a != b {
            return (path.text(), value(a), value(b));
        }
    }
    // Bytes differ and text does not: padding, or values that print the same, such as NaNs with
    // other payloads.
    let hidden = || "equal as text, not in its bytes".to_owned();
    ("(hidden)".to_owned(), hidden(), hidden())
}

/// The value of a field, by its path.
pub(super) fn field_text<T: Debug>(message: &T, field: &str) -> Option<String> {
    let printed = format!("{message:#?}");
    let mut path = Path::default();
    printed.lines().find_map(|line| {
        path.enter(line);
        (path.text() == field).then(|| value(line))
    })
}

/// The first byte at which two records differ.
pub(super) fn first_byte(recorded: &[u8], computed: &[u8]) -> (String, String, String) {
    let at = recorded.iter().zip(computed).position(|(a, b)| a != b);
    if let Some(at) = at {
        let byte = |bytes: &[u8]| bytes.get(at).map(u8::to_string).unwrap_or_default();
        return (format!("byte {at}"), byte(recorded), byte(computed));
    }
    let length = |bytes: &[u8]| format!("{} bytes", bytes.len());
    ("length".to_owned(), length(recorded), length(computed))
}

/// The path to a line of the printed form of a message; each level is indented by four more
/// spaces.
#[derive(Default)]
struct Path {
    levels: Vec<Level>,
}

struct Level {
    name: Option<String>,
    /// Lines of this level so far: the index within a list.
    index: usize,
}

impl Path {
    fn enter(&mut self, line: &str) {
        let text = line.trim_start_matches(' ');
        let depth = (line.len() - text.len()) / 4;
        // The line with the name of the type, and the closing brackets of lists and structs.
        if depth == 0 || text.starts_with([']', '}', ')']) {
            return;
        }
        let name = text.split_once(": ").map(|(name, _)| name.to_owned());
        self.levels.truncate(depth);
        match self.levels.get_mut(depth - 1) {
            Some(level) => {
                level.index += 1;
                level.name = name;
            }
            None => self.levels.push(Level { name, index: 0 }),
        }
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for level in &self.levels {
            match &level.name {
                Some(name) if text.is_empty() => text.push_str(name),
                Some(name) => text.extend([".", name]),
                None => text.extend(["[", level.index.to_string().as_str(), "]"]),
            }
        }
        text
    }
}

fn value(line: &str) -> String {
    let text = line.trim().trim_end_matches(',');
    text.split_once(": ")
        .map_or(text, |(_, value)| value)
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::{ArmCommand, Decision, Input, Text, Wire};

    #[test]
    fn a_field_is_named_by_the_way_to_it() {
        let one = Decision::zeroed();
        let mut other = one;
        other.goals[1].target.position[2] = -0.0;
        other.drops = 3;
        let found = first_field(&one, &other);
        assert_eq!(found.0, "goals[1].target.position[2]");
        assert_eq!((found.1.as_str(), found.2.as_str()), ("0.0", "-0.0"));
        assert_eq!(field_text(&other, &found.0).as_deref(), Some("-0.0"));
        assert_eq!(field_text(&other, "no_such_field"), None);
        other = one;
        other.phase = Text::new("LIFT");
        let found = first_field(&one, &other);
        assert_eq!((found.0.as_str(), found.2.as_str()), ("phase", "\"LIFT\""));
    }

    #[test]
    fn inputs_are_counted_from_zero() {
        let one = ArmCommand::zeroed();
        let mut other = one;
        other.header.inputs[1] = Input {
            topic: 0,
            generation: 0,
            seq: 9,
            age_ticks: 0,
        };
        assert_eq!(first_field(&one, &other).0, "header.inputs[1].seq");
        assert_eq!(first_byte(&[1, 2], &[1, 3]).0, "byte 1");
        assert_eq!(first_byte(&[1, 2], &[1]).0, "length");
    }
}

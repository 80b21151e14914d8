//! Which lines of the log are events worth a mark on the timeline.

/// Word in square brackets at the start of a line, and its mark.
const MARKS: &[(&str, &str)] = &[
    ("drop", "drop"),
    ("resync", "resync"),
    ("abort", "abort"),
    ("recover", "recover"),
    ("resume", "recover"),
    ("center", "recover"),
    ("done", "done"),
    ("failed", "fault"),
    ("fault", "fault"),
    ("error", "fault"),
];

/// The mark of a line, if it is an event.
pub fn of(text: &str) -> Option<&'static str> {
    let word = text.strip_prefix('[')?.split_once(']')?.0;
    if word == "task" {
        // A process that began anew, or a person who put it back.
        let anew = ["goes on from", "starts from", "started again"];
        return anew.iter().any(|a| text.contains(a)).then_some("restart");
    }
    if text == "[decide] -> all stacked" {
        return Some("done");
    }
    MARKS
        .iter()
        .find(|(known, _)| *known == word)
        .map(|(_, mark)| *mark)
}

#[cfg(test)]
mod tests {
    #[test]
    fn events_of_the_policies_are_told_apart() {
        let cases = [
            (
                "[drop] red_cube left the gripper, deciding again",
                Some("drop"),
            ),
            (
                "[resync] red_cube moved, picking it up anew",
                Some("resync"),
            ),
            ("[abort] the stack is broken", Some("abort")),
            ("[recover] left: lets cube_1 go", Some("recover")),
            ("[task] goes on from its record", Some("restart")),
            ("[task] paused: the operator leads", None),
            ("[decide] -> stack red_cube", None),
            ("[done] left: the stack is complete", Some("done")),
            ("[failed] red_cube fell off the table", Some("fault")),
            ("no word at all", None),
        ];
        for (text, mark) in cases {
            assert_eq!(super::of(text), mark, "{text}");
        }
    }
}

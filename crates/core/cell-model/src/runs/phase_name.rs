//! Names of phases: the names that people, scripts and breakpoints use for the node
//! `bring[red_1]` of the arm `left`. A cell of several arms shows `LEFT_BRING_RED_1`, one of a
//! single arm the node's own name; both are understood in both.

use ipc_types::text::CUT;

/// The characters of `parts`, as in the phase of a cell with several arms: upper case letters
/// and digits, with one `_` for everything between them. Allocates nothing.
pub fn chars<'p>(parts: &'p [&'p str]) -> impl Iterator<Item = char> + 'p {
    let all = parts.iter().flat_map(|part| part.chars().chain(['_']));
    let mut is_gap = true;
    let plain = all.filter_map(move |c| {
        let was_gap = std::mem::replace(&mut is_gap, !c.is_ascii_alphanumeric());
        match (is_gap, was_gap) {
            (false, _) => Some(c.to_ascii_uppercase()),
            (true, false) => Some('_'),
            (true, true) => None,
        }
    });
    // No `_` after the last part.
    let mut plain = plain.peekable();
    std::iter::from_fn(move || {
        let next = plain.next()?;
        (next != '_' || plain.peek().is_some()).then_some(next)
    })
}

/// The name of the phase of a node of an arm.
pub fn of_arm(arm: &str, node: &str) -> String {
    chars(&[arm, node]).collect()
}

/// Whether `asked` is the phase `shown`, or another form of its name: in another case, as a
/// node's id, or with the arm in front. A phase that was cut is compared up to the cut.
pub fn is_same(asked: &str, shown: &str, arms: &[String]) -> bool {
    let mut arms = arms.iter().map(String::as_str);
    asked == shown
        || alike(&[asked], &[shown])
        || arms.any(|arm| alike(&[arm, asked], &[shown]) || alike(&[asked], &[arm, shown]))
}

/// Whether two names have the same form as phases.
pub fn alike(asked: &[&str], shown: &[&str]) -> bool {
    let is_cut = shown.last().is_some_and(|name| name.ends_with(CUT));
    let (mut asked, mut shown) = (chars(asked), chars(shown));
    // Two names without letters and digits have no characters here, and are not the same.
    let mut any = false;
    loop {
        match (asked.next(), shown.next()) {
            (None, None) => return any,
            (Some(_), None) if is_cut => return any,
            (a, b) if a == b => any = true,
            _ => return false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_and_its_phase_are_the_same_and_those_of_another_arm_are_not() {
        assert_eq!(of_arm("left", "bring[red_1]"), "LEFT_BRING_RED_1");
        assert_eq!(of_arm("left", "Pick up: next?"), "LEFT_PICK_UP_NEXT");
        let arms = ["left".to_owned(), "right".to_owned()];
        for asked in [
            "LEFT_BRING_RED_1",
            "bring[red_1]",
            "left_bring[red_1]",
            "BRING_RED_1",
        ] {
            assert!(is_same(asked, "LEFT_BRING_RED_1", &arms), "{asked}");
            assert!(is_same(asked, "bring[red_1]", &arms), "{asked}");
        }
        for asked in ["RIGHT_BRING_RED_1", "bring[red_2]", "RED_1", "", "[]"] {
            assert!(!is_same(asked, "LEFT_BRING_RED_1", &arms), "{asked}");
        }
        assert!(is_same("a_node_with_a_name", "LEFT_A_NODE_WITH…", &arms));
    }
}

//! Which signals a command line names.

use supervisor::failure::Failure;

use super::signals::Signal;
use crate::suggestion::did_you_mean;

/// The signals named by `asked`, each once, in the order they are named and at most
/// `most`; `*` in a name matches any text.
pub(super) fn choose(
    all: &[Signal],
    asked: &[String],
    most: usize,
) -> Result<Vec<Signal>, Failure> {
    let mut chosen: Vec<Signal> = Vec::new();
    for name in asked {
        let named = all.iter().filter(|signal| matches(name, &signal.name));
        let before = chosen.len();
        let mut is_known = false;
        for signal in named {
            is_known = true;
            if !chosen.contains(signal) {
                chosen.push(signal.clone());
            }
        }
        if !is_known {
            return Err(unknown(all, name));
        }
        if chosen.len() > most {
            return Err(Failure::usage(format!(
                "`{name}` makes it {} signals, after {before}; a plot has at most {most}, \
                 `--json` any number",
                chosen.len(),
            )));
        }
    }
    Ok(chosen)
}

fn unknown(all: &[Signal], name: &str) -> Failure {
    let names: Vec<String> = all.iter().map(|signal| signal.name.clone()).collect();
    let near = did_you_mean(name, &names);
    Failure::usage(format!(
        "the recording has no signal `{name}`{near}; `robocell plot FILE` lists its {} signals",
        all.len()
    ))
}

/// Whether `pattern` matches `name`.
fn matches(pattern: &str, name: &str) -> bool {
    let Some((first, rest)) = pattern.split_once('*') else {
        return pattern == name;
    };
    let Some(name) = name.strip_prefix(first) else {
        return false;
    };
    let mut ends = name.char_indices().map(|(at, _)| at).chain([name.len()]);
    ends.any(|at| matches(rest, &name[at..]))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::super::signals::signals;
    use super::*;
    use supervisor::failure::Code;

    fn all() -> Vec<Signal> {
        let joints = (1..=7).map(|n| json!({ "name": format!("joint{n}") }));
        let joints: Vec<_> = joints.collect();
        signals(&json!({ "arms": [{ "name": "left", "joints": joints }] }))
    }

    fn names(asked: &[&str]) -> Result<Vec<String>, Failure> {
        let asked: Vec<String> = asked.iter().map(|name| (*name).to_owned()).collect();
        let chosen = choose(&all(), &asked, evaluation::charts::MAX_LINES)?;
        Ok(chosen.into_iter().map(|signal| signal.name).collect())
    }

    #[test]
    fn names_and_patterns_choose_each_signal_once() {
        let chosen = names(&["left/joint2 error", "left/joint* error"]).unwrap();
        assert_eq!(chosen.len(), 7);
        assert_eq!(chosen[..2], ["left/joint2 error", "left/joint1 error"]);
        assert_eq!(names(&["*TCP z"]).unwrap(), ["left/TCP z"]);
    }

    #[test]
    fn an_unknown_name_is_answered_with_the_nearest_one() {
        let said = names(&["left/joint2 eror"]).unwrap_err();
        assert_eq!(said.code, Code::Usage);
        assert!(
            said.message.contains("did you mean `left/joint2 error`?"),
            "{said}"
        );
        assert!(names(&["right/*"]).is_err());
    }

    #[test]
    fn more_signals_than_can_be_told_apart_are_refused() {
        let said = names(&["*"]).unwrap_err();
        assert!(
            said.code == Code::Usage && said.message.contains("at most 16"),
            "{said}"
        );
        let every = choose(&all(), &["*".to_owned()], usize::MAX).unwrap();
        assert_eq!(every, all());
    }
}

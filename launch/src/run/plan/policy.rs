//! The policy of a run.

use std::path::Path;

use cell_model::Cell;
use cell_model::runs::python;
use cell_model::runs::report;
use ipc_types::decision::POLICY_BYTES;

use crate::cli::RunArgs;
use crate::failure::Failure;
use crate::task_program;

/// The policy asked for, or the demo's default, and its drawing. The task program
/// reads `[task]` and the behaviour it names now, so that an error is said before
/// anything starts.
pub(super) fn policy_of(
    args: &RunArgs,
    cell: &Cell,
    files: task_program::Files<'_>,
    program: Option<&Path>,
) -> Result<(String, String), Failure> {
    let policy = policy_name(args.scene.policy.as_deref(), cell, program)?;
    let drawing = task_program::check_policy(program, &args.demo, &policy, files)?;
    Ok((policy, drawing))
}

/// The policy asked for, or the demo's default. A Python file brings its own policies,
/// whatever the cell names.
pub(crate) fn policy_name(
    asked: Option<&str>,
    cell: &Cell,
    program: Option<&Path>,
) -> Result<String, Failure> {
    match program.filter(|program| python::is_file(program)) {
        Some(file) => {
            Ok(asked.map_or_else(|| python::policy_name(file, POLICY_BYTES), str::to_owned))
        }
        None => choose(asked, &cell.policies, &cell.default_policy, &cell.name),
    }
}

/// `asked`, if the demo has it, else its default.
pub(crate) fn choose(
    asked: Option<&str>,
    known: &[String],
    default: &str,
    demo: &str,
) -> Result<String, Failure> {
    let Some(asked) = asked else {
        return Ok(default.to_owned());
    };
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    if let Some(policy) = report::policy_named(asked, &known) {
        return Ok(policy.to_owned());
    }
    let refusal = report::unknown_policy(asked, &known, demo);
    Err(Failure::configuration(refusal))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_policy_is_answered_with_the_near_and_the_known_ones() {
        let known = ["fsm".to_owned(), "ifelse".to_owned()];
        assert_eq!(choose(None, &known, "fsm", "d").unwrap(), "fsm");
        assert_eq!(
            choose(Some("ifelse"), &known, "fsm", "d").unwrap(),
            "ifelse"
        );
        let message = choose(Some("ifels"), &known, "fsm", "d")
            .unwrap_err()
            .to_string();
        assert!(message.contains("did you mean 'ifelse'?"), "{message}");
        let message = choose(Some("quantum"), &known, "fsm", "d")
            .unwrap_err()
            .to_string();
        assert!(message.contains("known are: fsm, ifelse"), "{message}");
    }
}

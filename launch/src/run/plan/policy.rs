//! The policy of a run.

use std::path::Path;

use cell_model::Cell;
use cell_model::runs::policy_name::CLIENT_POLICY;
use cell_model::runs::policy_server::is_address;
use cell_run::python;
use ipc_types::decision::POLICY_BYTES;
use supervisor::failure::Failure;
use supervisor::run::policy::choose;

use crate::args::RunArgs;
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
    let arms = &cell.arms;
    let has_own_arm = arms.iter().any(|arm| !arm.has_client());
    let policy = match args.scene.policy.as_deref() {
        // No task can command an arm that has a client.
        _ if !has_own_arm && !arms.is_empty() => CLIENT_POLICY.to_owned(),
        asked => policy_name(asked, cell, program)?,
    };
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
    // The task program makes the policy and refuses other addresses.
    if let Some(address) = asked.filter(|asked| is_address(asked)) {
        return Ok(address.to_owned());
    }
    match program.filter(|program| python::is_file(program)) {
        Some(file) => {
            Ok(asked.map_or_else(|| python::policy_name(file, POLICY_BYTES), str::to_owned))
        }
        None => choose(asked, &cell.policies, &cell.default_policy, &cell.name),
    }
}

//! The same cell inside one process: the task program beside our executable.

use cell_run::spec::ENDED_FILE;
use supervisor::failure::{Code, Context, Failure};
use supervisor::run::plan::Plan;
use supervisor::rundir::RunDir;

use crate::task_program;

/// Runs `plan` in one process.
pub(crate) fn run(plan: &Plan, json: bool) -> Result<(), Failure> {
    let arguments = json.then(|| "--json".to_owned());
    by_task_program(plan, "run", arguments)
}

/// Has the task program do `verb` with the cell of `plan`. It needs no shared memory and no
/// name, so many can run side by side.
pub(crate) fn by_task_program(
    plan: &Plan,
    verb: &str,
    arguments: impl IntoIterator<Item = String>,
) -> Result<(), Failure> {
    // Ctrl-C reaches the other program, too; ours stays to tidy up.
    cell_rt::signal::install_stop_handler().cannot("listen to signals")?;
    // With a dot, which `--cell` refuses: no cell can have this directory.
    let dir = RunDir::of(&format!(".one-{}", std::process::id()))?;
    dir.make()?;
    let mut spec = plan.spec.clone();
    dir.path().clone_into(&mut spec.run_dir);
    let result = spec
        .save(&dir.spec())
        .map_err(Failure::configuration)
        .and_then(|()| {
            let spec_file = dir.spec().display().to_string();
            let mut words = vec![verb.to_owned(), "--spec".to_owned(), spec_file];
            words.extend(arguments);
            let ended = dir.path().join(ENDED_FILE);
            task_program::run_to_its_end(spec.task_program.as_deref(), &words, &ended)
        });
    std::fs::remove_dir_all(dir.path()).ok();
    if cell_rt::signal::stop_requested() {
        return Err(Failure {
            code: Code::GaveUp,
            message: "stopped before its end".to_owned(),
        });
    }
    result
}

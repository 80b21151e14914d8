//! The whole job in one process, with physics and controllers.

use std::error::Error;
use std::path::Path;

use robocell_task_program::{RunOutcome, run_cell};

#[test]
fn the_cube_ends_on_the_mark() -> Result<(), Box<dyn Error>> {
    for seed in 0..3 {
        let summary = run_cell(&{{crate}}::policies(), Path::new("."), "{{name}}", seed)?;
        assert_eq!(summary.outcome, RunOutcome::Done, "seed {seed}: {summary:?}");
        assert_eq!(summary.placed, ["cube"], "seed {seed}");
        assert_eq!(summary.limit_violations, 0, "seed {seed}");
    }
    Ok(())
}

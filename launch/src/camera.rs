//! `robocell camera`: pictures of the cameras of a cell, by the task program.

use supervisor::failure::Failure;

use crate::args::CameraArgs;
use crate::run::{one_process, resolve};

/// Does what the arguments say.
pub(crate) fn run(args: &CameraArgs) -> Result<(), Failure> {
    let plan = resolve(&args.as_run())?;
    let mut words = vec!["--time".to_owned(), args.time.to_string()];
    for name in &args.camera {
        words.extend(["--camera".to_owned(), name.clone()]);
    }
    words.extend(args.hash.then(|| "--hash".to_owned()));
    if let Some(dir) = &args.out {
        words.extend(["--out".to_owned(), dir.display().to_string()]);
    }
    one_process::by_task_program(&plan, "camera", words)
}

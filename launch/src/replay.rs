//! `robocell replay`: a recording on the page, or computed again.

use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};

use supervisor::child::{ENV_CACHE_DIR, cache_dir};
use supervisor::failure::{Code, Context, Failure};
use supervisor::programs::beside;
use supervisor::rundir::RunDir;

use crate::args::ReplayArgs;
use crate::{page, say, task_program};

/// Does what the command line says.
pub(crate) fn replay(args: &ReplayArgs) -> Result<(), Failure> {
    let file = existing(&args.file)?;
    if args.verify {
        return verify(args, &file);
    }
    if args.actions {
        let words = ["replay".to_owned(), file.display().to_string()];
        return task_program::run_other("robocell-export", &words);
    }
    // By pid, so that several recordings can be shown at a time.
    let dir = RunDir::of(&format!("replay-{}", std::process::id()))?;
    let lock = dir.take("replay")?;
    dir.set_recording(&file).cannot("note the replayed file")?;
    let shown = page::Page::new(&args.page)?;
    dir.save_page(shown.secrets())?;
    let page = shown.spec(&dir);
    let program = beside("monitor-proc")?;
    let mut command = Command::new(&program);
    command
        .arg("replay")
        .arg(&file)
        .arg("--address")
        .arg(page.address.to_string())
        .arg("--secrets")
        .arg(&page.secrets)
        .arg("--hint")
        .arg(&page.hint);
    if let Some(cache) = cache_dir() {
        command.env(ENV_CACHE_DIR, cache);
    }
    if let Some(host) = &page.host {
        command.arg("--host").arg(host);
    }
    if let Some(dist) = &page.dist {
        command.arg("--dist").arg(dist);
    }
    let tell = || {
        // Nothing else says the link of a recording, so it can be used again.
        let lines = page::lines(&page, shown.secrets());
        lines.iter().for_each(say::line);
        say::line("Ctrl-C ends it.");
    };
    let status = to_its_end(&mut command, || page::listens(&page), tell);
    let status = status.cannot(format!("start {}", program.display()))?;
    std::fs::remove_dir_all(dir.path()).ok();
    drop(lock);
    if status.success() {
        Ok(())
    } else {
        // The page's process has said why.
        Err(Failure::silent(Code::Configuration))
    }
}

/// Runs the page's process until it ends, or Ctrl-C ends it; calls `tell` as soon as it
/// `listens`.
fn to_its_end(
    command: &mut Command,
    listens: impl Fn() -> bool,
    tell: impl FnOnce(),
) -> std::io::Result<ExitStatus> {
    let mut tell = Some(tell);
    // In a group of its own, so that Ctrl-C comes here: the files of the run are removed
    // after the server has ended.
    cell_rt::signal::install_stop_handler()?;
    let mut child = command.process_group(0).spawn()?;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        if tell.is_some()
            && listens()
            && let Some(tell) = tell.take()
        {
            tell();
        }
        if cell_rt::signal::stop_requested() {
            cell_rt::process::kill(child.id(), cell_rt::process::SIGTERM).ok();
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}

fn verify(args: &ReplayArgs, file: &Path) -> Result<(), Failure> {
    let mut arguments = vec!["verify".to_owned(), file.display().to_string()];
    if let Some(dir) = &args.data.data {
        let dir = existing(dir)?;
        arguments.extend(["--data".to_owned(), dir.display().to_string()]);
    }
    arguments.extend(args.json.then(|| "--json".to_owned()));
    let program = args.data.program.task.as_deref();
    let program = program
        .map(|name| task_program::find(name, None))
        .transpose()?;
    task_program::run(program.as_deref(), &arguments)
}

fn existing(path: &Path) -> Result<PathBuf, Failure> {
    std::fs::canonicalize(path).cannot(format!(
        "open {}; give a recording, as `robocell record last 60s` writes it",
        path.display()
    ))
}

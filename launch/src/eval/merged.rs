//! `robocell eval merge`: the rows of all shards on stdout, or in files.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use cell_model::user_file;
use cell_rt::stdout;
use evaluation::merge::{Merged, merge};
use supervisor::failure::{Context as _, Failure};

use crate::cli::MergeArgs;
use crate::say;

/// Checks all files before a row is printed, or a file replaced.
pub(super) fn write(args: &MergeArgs) -> Result<(), Failure> {
    let Some(path) = &args.out else {
        return print(&args.files);
    };
    let file = Partial::of("--out", path)?;
    let what = || format!("write {}", file.partial.display());
    let mut to = BufWriter::new(File::create(&file.partial).cannot(what())?);
    let Merged { rows } = merge(&args.files, &mut to).map_err(Failure::configuration)?;
    to.flush().cannot(what())?;
    let shown = path.display();
    std::fs::rename(&file.partial, path).cannot(format!("write {shown}"))?;
    say::line(format_args!("{shown}: {rows} rows"));
    Ok(())
}

fn print(files: &[PathBuf]) -> Result<(), Failure> {
    merge(files, &mut std::io::sink()).map_err(Failure::configuration)?;
    let mut out = BufWriter::new(stdout::Writer);
    let merged = merge(files, &mut out).map(|_| out.flush());
    match merged {
        // What became of the output is reported at the end of the command.
        Err(_) if !stdout::has_reader() => Ok(()),
        Err(error) => Err(Failure::configuration(error)),
        Ok(_) => Ok(()),
    }
}

/// A file that is written under a temporary name, so that an error leaves the old one.
struct Partial {
    partial: PathBuf,
}

impl Partial {
    /// A device or a pipe would be replaced by a file.
    fn of(option: &str, path: &Path) -> Result<Self, Failure> {
        user_file::check_output(path).cannot(format!(
            "write {} ({option}; without --out the rows go to standard output)",
            path.display()
        ))?;
        let mut partial = path.as_os_str().to_owned();
        partial.push(".partial");
        Ok(Self {
            partial: PathBuf::from(partial),
        })
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        // Not there after a rename.
        std::fs::remove_file(&self.partial).ok();
    }
}

//! `robocell eval merge`: the rows of all shards on stdout, or in files.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use cell_model::user_file;
use cell_rt::stdout;
use evaluation::EvaluationError;
use evaluation::merge::{Merged, merge, merge_lines};

use super::parquet;
use crate::cli::MergeArgs;
use crate::failure::{Context as _, Failure};
use crate::say;

/// Checks all files before a row is printed, or a file replaced.
pub(super) fn write(args: &MergeArgs) -> Result<(), Failure> {
    if args.out.is_none() && args.parquet.is_none() {
        return print(&args.files);
    }
    if args.out == args.parquet {
        return Err(Failure::usage("--out and --parquet name the same file"));
    }
    let of = |name, path: Option<&Path>| path.map(|path| Partial::of(name, path)).transpose();
    let out = of("--out", args.out.as_deref())?;
    let parquet = of("--parquet", args.parquet.as_deref())?;
    let Merged { rows } = write_partial(&args.files, out.as_ref(), parquet.as_ref())?;
    for file in [out, parquet].into_iter().flatten() {
        let path = file.path.display();
        std::fs::rename(&file.partial, &file.path).cannot(format!("write {path}"))?;
        say::line(format_args!("{path}: {rows} rows"));
    }
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
    path: PathBuf,
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
            path: path.to_owned(),
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

/// Reads `files` once for both.
fn write_partial(
    files: &[PathBuf],
    out: Option<&Partial>,
    parquet: Option<&Partial>,
) -> Result<Merged, Failure> {
    let mut parquet = parquet
        .map(|file| parquet::create(&file.partial))
        .transpose()?;
    let what = |file: &Partial| format!("write {}", file.partial.display());
    let mut out = match out {
        Some(file) => {
            let to = File::create(&file.partial).cannot(what(file))?;
            Some((file, BufWriter::new(to)))
        }
        None => None,
    };
    let merged = merge_lines(files, &mut |line| {
        if let Some(parquet) = &mut parquet {
            parquet.append(line.row()?)?;
        }
        if let Some((file, to)) = &mut out {
            let written = to.write_all(line.text.as_bytes());
            written.map_err(|source| EvaluationError::Io {
                path: file.partial.clone(),
                source,
            })?;
        }
        Ok(())
    });
    let merged = merged.map_err(Failure::configuration)?;
    if let Some((file, mut to)) = out {
        to.flush().cannot(what(file))?;
    }
    if let Some(parquet) = parquet {
        parquet.finish().map_err(Failure::configuration)?;
    }
    Ok(merged)
}

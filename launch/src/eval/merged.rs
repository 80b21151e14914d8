//! `robocell eval merge`: the rows of all shards on stdout.

use std::io::{BufWriter, Write as _};
use std::path::PathBuf;

use cell_rt::stdout;
use evaluation::merge::merge;

use supervisor::failure::Failure;

/// Checks all files before a row is printed.
pub(super) fn print(files: &[PathBuf]) -> Result<(), Failure> {
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

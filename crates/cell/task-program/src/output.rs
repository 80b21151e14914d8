//! Lines and JSON on standard output.

use std::io::Write as _;

use cell_rt::stdout;

/// Prints a line; the program reports output that was not written.
pub(crate) fn print_line(line: std::fmt::Arguments<'_>) {
    stdout::line(line);
}

/// A count with its word.
pub(crate) fn counted(count: u64, word: &str) -> String {
    match count {
        1 => format!("1 {word}"),
        _ => format!("{count} {word}s"),
    }
}

/// Prints `value` as one line of JSON.
pub(crate) fn print_json(value: &impl serde::Serialize) {
    match serde_json::to_string(value) {
        Ok(line) => print_line(format_args!("{line}")),
        Err(error) => {
            writeln!(std::io::stderr(), "the summary cannot be written: {error}").ok();
        }
    }
}

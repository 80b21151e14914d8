//! Log of a process.

use std::cell::RefCell;
use std::io::Write;

thread_local! {
    /// Lines of the modelled processes of this thread; `None` in a process.
    static KEPT: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// Keeps the lines that this thread logs from now on, and returns those since the last call: for
/// a model of processes.
pub fn keep_lines() -> Vec<String> {
    let kept = KEPT.with(|kept| kept.replace(Some(Vec::new())));
    kept.unwrap_or_default()
}

/// Writes a warning to the log. If the log cannot be written because its file system is full,
/// the warning is lost: `eprintln!` would panic and end the process.
pub fn warn(text: impl std::fmt::Display) {
    line(format_args!("warning: {text}"));
}

/// Writes a line to the log, as [`warn`].
pub(crate) fn line(text: impl std::fmt::Display) {
    let is_kept = KEPT.with_borrow_mut(|kept| {
        let kept = kept.as_mut();
        kept.map(|lines| lines.push(text.to_string())).is_some()
    });
    if !is_kept {
        writeln!(std::io::stderr().lock(), "{text}").ok();
    }
}

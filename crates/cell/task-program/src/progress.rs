//! A progress line on the terminal; nothing is shown where stderr is not a terminal.

use std::sync::atomic::{AtomicU64, Ordering};

use indicatif::{ProgressBar, ProgressStyle};

/// See the module. The line is removed when the value is dropped.
pub(crate) struct Progress {
    bar: ProgressBar,
    /// Simulated seconds shown last.
    shown_s: AtomicU64,
}

impl Progress {
    /// Of `total` runs.
    pub(crate) fn of_runs(total: u64) -> Self {
        let template = "{bar:30} {pos} of {len} runs, {per_sec}, {eta} left";
        Self::new(ProgressBar::new(total), template)
    }

    /// Of rows, some of which exist already.
    pub(crate) fn of_rows(before: u64, all: u64) -> Self {
        let bar = ProgressBar::new(all).with_position(before);
        // The time that is left is computed from the rows of this process alone: those of an
        // earlier one were not written in this time.
        bar.reset_eta();
        let template = "{bar:30} {pos} of {len} episodes, {per_sec}, {msg}{eta} left";
        Self::new(bar, template)
    }

    /// One more row; `failed` of them did not end done.
    pub(crate) fn row(&self, failed: u64) {
        self.bar.set_message(format!("{failed} not done, "));
        self.bar.inc(1);
    }

    /// Of work on simulated time.
    pub(crate) fn of_time(what: &'static str) -> Self {
        let bar = ProgressBar::new_spinner().with_prefix(what);
        Self::new(
            bar,
            "{spinner} {prefix}: {msg} of simulated time ({elapsed})",
        )
    }

    fn new(bar: ProgressBar, template: &str) -> Self {
        let style = ProgressStyle::with_template(template);
        let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
        Self {
            bar: bar.with_style(style),
            shown_s: AtomicU64::new(0),
        }
    }

    /// One more run; `print` writes to stdout.
    pub(crate) fn run(&self, print: impl FnOnce()) {
        self.bar.suspend(print);
        self.bar.inc(1);
    }

    /// Writes to stdout.
    pub(crate) fn print(&self, print: impl FnOnce()) {
        self.bar.suspend(print);
    }

    /// The work has reached `tick`.
    pub(crate) fn tick(&self, tick: u64) {
        let time_s = tick / 1000;
        // Drawn once per simulated second: a tick takes microseconds, a line on a terminal
        // more.
        if self.shown_s.swap(time_s, Ordering::Relaxed) != time_s {
            self.bar.set_message(format!("{time_s} s"));
            self.bar.tick();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

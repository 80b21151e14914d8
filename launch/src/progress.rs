//! A line on the terminal about work that takes long; nothing where stderr is none.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// How often the time is shown.
const TICK: Duration = Duration::from_millis(500);

/// See the module. The line disappears with its value.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// `what` is done, it is not known how long it takes.
    pub(crate) fn new(what: impl Into<String>) -> Self {
        let bar = ProgressBar::new_spinner();
        let style = ProgressStyle::with_template("{spinner} {msg} ({elapsed})");
        let bar = bar.with_message(what.into());
        let bar = bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
        bar.enable_steady_tick(TICK);
        Self(bar)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

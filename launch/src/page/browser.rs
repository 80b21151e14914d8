//! Opens the page in the user's browser.

use std::process::{Command, Stdio};

use cell_run::spec::PageSpec;

use super::link;
use crate::say;

/// What opens a link on Linux and on macOS.
const OPENERS: [&str; 2] = ["xdg-open", "open"];

/// Opens the link of `page`; says what to do where that is not possible.
pub(crate) fn open(page: Option<&PageSpec>) {
    let Some(link) = page.and_then(link) else {
        return;
    };
    for opener in OPENERS {
        let mut command = Command::new(opener);
        command.arg(&link).stdin(Stdio::null());
        command.stdout(Stdio::null()).stderr(Stdio::null());
        let Ok(mut child) = command.spawn() else {
            continue;
        };
        // It may stay as long as the browser does.
        let waits = std::thread::Builder::new().name("browser".to_owned());
        let wait = move || match child.wait() {
            Ok(status) if !status.success() => say::warn(format_args!(
                "--open: `{opener}` ended with {status}; open this link in a browser: {link}"
            )),
            _ => {}
        };
        waits.spawn(wait).ok();
        say::line(format_args!("opening the page with {opener}"));
        return;
    }
    say::warn(format_args!(
        "--open: neither {} is installed; open this link in a browser: {link}",
        OPENERS.join(" nor ")
    ));
}

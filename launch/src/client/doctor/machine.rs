//! Programs of others, and how the processor is clocked.

use std::fs;
use std::process::{Command, Stdio};

use supervisor::programs::beside;

use super::{Check, Severity};
use crate::asked;
use crate::page::dist;

/// The page is built with this version of Node.js or a newer one.
const LEAST_NODE: u32 = 20;
const NODE_COST: &str = "a checkout cannot build the page: it serves the last one built, or none; \
                         everything else works (`--headless`)";
const NODE_FIX: &str = "install Node.js 20 or newer with npm (https://nodejs.org)";

/// Node.js, which builds the page of a checkout.
pub(super) fn node() -> Check {
    let version = version_of("node");
    let major = version.as_deref().and_then(major);
    let found = version.as_deref().unwrap_or("not found");
    let fine = major.is_some_and(|major| major >= LEAST_NODE);
    Check::new(
        "Node.js",
        fine,
        Severity::Warn,
        found,
        (NODE_COST, NODE_FIX),
    )
}

/// Where the page comes from.
pub(super) fn page() -> Check {
    if let Some(ui) = dist::checkout() {
        let is_built = dist::is_built(&ui);
        let found = if is_built {
            "built in this checkout"
        } else {
            "built by the next start, with Node.js"
        };
        return Check::ok("page", found);
    }
    // A missing program is reported by the check of programs.
    let monitor = beside("monitor-proc").ok();
    let said = monitor.and_then(|path| {
        let mut command = Command::new(path);
        command.arg("page").stdout(Stdio::piped());
        asked::ask(&mut command, "monitor-proc", "its page", asked::QUICK).ok()
    });
    let found = said.map(|said| String::from_utf8_lossy(&said.stdout).trim().to_owned());
    let found = found.filter(|found| !found.is_empty());
    let fine = found.as_deref() == Some("built in");
    let found = found.unwrap_or_else(|| "unknown".to_owned());
    let cost = "no page is served; cells run (`--headless`)";
    let fix = "install a release, or build from a checkout with Node.js";
    Check::new("page", fine, Severity::Warn, found, (cost, fix))
}

/// npm, which comes with it.
pub(super) fn npm() -> Check {
    let version = version_of("npm");
    let found = version.as_deref().unwrap_or("not found");
    let fine = version.is_some();
    Check::new("npm", fine, Severity::Warn, found, (NODE_COST, NODE_FIX))
}

/// Whether the processor keeps its clock high.
pub(super) fn governor() -> Check {
    let name = "CPU governor";
    let governors = governors();
    let slow: Vec<&String> = governors.iter().filter(|g| *g != "performance").collect();
    match (governors.first(), slow.first()) {
        // Most containers and virtual machines have no `cpufreq`, and no means to change the clock.
        (None, _) => Check::ok(name, "not under the control of this system"),
        (Some(_), None) => Check::ok(name, "performance"),
        (Some(_), Some(governor)) => Check::new(
            name,
            false,
            Severity::Warn,
            format!("{governor} ({} of {} cores)", slow.len(), governors.len()),
            (
                "a cycle starts at a slow clock: up to some 100 us late",
                "sudo cpupower frequency-set -g performance",
            ),
        ),
    }
}

fn governors() -> Vec<String> {
    let cores = fs::read_dir("/sys/devices/system/cpu")
        .into_iter()
        .flatten();
    let files = cores
        .flatten()
        .map(|core| core.path().join("cpufreq/scaling_governor"));
    let governors = files.filter_map(|file| fs::read_to_string(file).ok());
    governors.map(|text| text.trim().to_owned()).collect()
}

/// The first line of `PROGRAM --version`; none where it does not start.
fn version_of(program: &str) -> Option<String> {
    let mut command = Command::new(program);
    command.arg("--version").stdout(Stdio::piped());
    command.stderr(Stdio::null());
    let said = asked::ask(&mut command, program, "its version", asked::QUICK).ok()?;
    let text = String::from_utf8_lossy(&said.stdout);
    let line = text.lines().next().unwrap_or_default().trim().to_owned();
    said.status.success().then_some(line)
}

/// The first number of a version.
fn major(version: &str) -> Option<u32> {
    let digits = version.trim_start_matches(|c: char| !c.is_ascii_digit());
    digits.split('.').next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_version_is_compared_by_its_first_number() {
        assert_eq!(major("v22.3.0"), Some(22));
        assert_eq!(major("18.19.1"), Some(18));
        assert_eq!(major("none"), None);
        assert_eq!(version_of("no-such-program-here"), None);
    }
}

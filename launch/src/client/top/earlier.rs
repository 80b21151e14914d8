//! What the task said before `top` was started, from the log the monitor keeps.

use supervisor::process_log::tail;
use supervisor::rundir::RunDir;

/// Name of that log.
const LOG: &str = "trace";
/// More lines than a terminal has.
const LINES: usize = 60;
/// More bytes than those lines have.
const BYTES: u64 = 32 << 10;

/// The last lines, with their simulated seconds; none where there is no log yet.
pub(super) fn lines(dir: &RunDir) -> Vec<(f64, String)> {
    let text = tail(&dir.log(LOG), BYTES);
    let mut lines: Vec<_> = text.lines().rev().filter_map(line).take(LINES).collect();
    lines.reverse();
    lines
}

/// `    12.340 s  text`; a star marks a line that came before its state.
fn line(text: &str) -> Option<(f64, String)> {
    let (at, rest) = text.trim_start().split_once(" s")?;
    let rest = rest.strip_prefix('*').unwrap_or(rest);
    let said = rest
        .strip_prefix(' ')
        .map_or(rest, |rest| rest.strip_prefix(' ').unwrap_or(rest));
    Some((at.parse().ok()?, said.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::line;

    #[test]
    fn a_line_of_the_log_is_its_time_and_its_words() {
        assert_eq!(
            line("     4.474 s  STANDBY -> PICKING (START)"),
            Some((4.474, "STANDBY -> PICKING (START)".to_owned()))
        );
        assert_eq!(
            line("    17.692 s* [task] resumed from its checkpoint"),
            Some((17.692, "[task] resumed from its checkpoint".to_owned()))
        );
        assert_eq!(
            line("     7.700 s    -> flipping").map(|l| l.1),
            Some("  -> flipping".to_owned())
        );
        assert_eq!(line("no time"), None);
    }
}

//! Programs that are asked for something, as a drawing or a version, and shall end by
//! themselves.
//!
//! A program of others can hang: a constructor that waits, a thread that keeps its process
//! alive after the answer. So every question has a time limit, and a failure names the
//! program, the question and the way it ended. Nothing else here waits without a limit.

use std::io::{self, Read};
use std::os::unix::process::ExitStatusExt as _;
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use cell_rt::process::kill_tree;
use cell_rt::signal::stop_requested;
use supervisor::failure::{Code, Context as _, Failure};

/// Answers of programs that come with the system or with us.
pub(crate) const QUICK: Duration = Duration::from_secs(20);
/// Imports of a Python file: a start of its task process may take 20 s, and here other
/// builds may run beside it.
pub(crate) const IMPORTS: Duration = Duration::from_secs(60);
/// A program that is built before it answers.
pub(crate) const BUILD: Duration = Duration::from_secs(30 * 60);

/// Time between two looks whether a program has ended.
const LOOK: Duration = Duration::from_millis(5);
/// Output of a program that has ended is read by then, unless another one holds the pipe.
const DRAIN: Duration = Duration::from_secs(1);

/// Runs `command` until it ends; returns the output that is piped. `name` is the program,
/// `question` as in "asked for {question}".
///
/// # Errors
/// When it cannot be started, a signal ended it, it is not done after `limit`, or we are
/// asked to stop. Any exit code is an answer.
pub(crate) fn ask(
    command: &mut Command,
    name: &str,
    question: &str,
    limit: Duration,
) -> Result<Output, Failure> {
    // A program that reads stdin would wait for the terminal, or consume the input of a script.
    command.stdin(Stdio::null());
    ask_with_input(command, name, question, limit)
}

/// As [`ask`], of a program that has an input.
///
/// # Errors
/// As [`ask`].
pub(crate) fn ask_with_input(
    command: &mut Command,
    name: &str,
    question: &str,
    limit: Duration,
) -> Result<Output, Failure> {
    // Our process group, so that Ctrl-C ends it, too.
    let mut child = command.spawn().cannot(format!("start {name}"))?;
    let stdout = child.stdout.take().map(reader);
    let stderr = child.stderr.take().map(reader);
    let status = to_its_end(&mut child, limit).cannot(format!("wait for {name}"))?;
    let Some(status) = status else {
        if stop_requested() {
            return Err(Failure {
                code: Code::GaveUp,
                message: "stopped before its end".to_owned(),
            });
        }
        return Err(Failure::configuration(format!(
            "{name} was asked for {question} and has not ended after {} s: it was killed; \
             an endless loop, or a thread that does not end, keeps it",
            limit.as_secs_f64()
        )));
    };
    let output = Output {
        status,
        stdout: all_of(stdout),
        stderr: all_of(stderr),
    };
    if status.signal().is_some() {
        return Err(by_signal(name, question, &output));
    }
    Ok(output)
}

/// The failure of a program that a signal ended; the last thing it said is the cause.
fn by_signal(name: &str, question: &str, output: &Output) -> Failure {
    let said = String::from_utf8_lossy(&output.stderr);
    let last = said.lines().rfind(|line| !line.trim().is_empty());
    let last = last.map_or_else(String::new, |line| format!(": {line}"));
    Failure::configuration(format!(
        "{name} was asked for {question} and ended by a signal ({}){last}",
        output.status
    ))
}

/// `None` for a program that was killed: at the limit, or because we stop.
fn to_its_end(child: &mut Child, limit: Duration) -> io::Result<Option<ExitStatus>> {
    let began = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if stop_requested() || began.elapsed() > limit {
            // With its descendants: the children of a build script would run on and keep the pipes
            // open. The kill fails where the program has just ended.
            kill_tree(child.id()).ok();
            child.wait()?;
            return Ok(None);
        }
        // Polled: `Child::wait` has neither a time limit nor an end at a request to stop.
        std::thread::sleep(LOOK);
    }
}

/// Reads a pipe to its end beside the wait: a full pipe would block the program.
fn reader(mut pipe: impl Read + Send + 'static) -> Receiver<Vec<u8>> {
    let (done, bytes) = channel();
    // Never joined: a descendant that holds the pipe must not delay the answer beyond `DRAIN`.
    std::thread::spawn(move || {
        let mut all = Vec::new();
        pipe.read_to_end(&mut all).ok();
        // The receiver is gone if the pipe was open for longer than `DRAIN`.
        done.send(all).ok();
    });
    bytes
}

fn all_of(pipe: Option<Receiver<Vec<u8>>>) -> Vec<u8> {
    let bytes = pipe.and_then(|bytes| bytes.recv_timeout(DRAIN).ok());
    bytes.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str, limit: Duration) -> Result<Output, Failure> {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        ask(&mut command, "task program job.py", "its drawing", limit)
    }

    #[test]
    fn the_answer_is_what_was_printed_whatever_the_exit_code() {
        // More than a pipe holds.
        let said = shell("seq 1 100000; echo no >&2; exit 3", QUICK).unwrap();
        assert_eq!(said.status.code(), Some(3));
        assert!(said.stdout.ends_with(b"\n100000\n"));
        assert_eq!(said.stderr, b"no\n");
    }

    #[test]
    fn a_program_that_does_not_end_is_killed_with_its_children_and_named() {
        let limit = Duration::from_millis(50);
        let failure = shell("sleep 1000 & wait", limit).unwrap_err();
        assert_eq!(failure.code, Code::Configuration);
        let text = failure.to_string();
        let start = "task program job.py was asked for its drawing and has not ended after 0.05 s";
        assert!(text.starts_with(start), "{text}");
    }

    #[test]
    fn a_program_that_a_signal_ended_is_named_with_the_signal_and_its_last_line() {
        let failure = shell("echo no memory >&2; kill -ABRT $$", QUICK).unwrap_err();
        let text = failure.to_string();
        assert!(
            text.contains("task program job.py was asked for its drawing and ended by a signal")
        );
        assert!(
            text.contains("SIGABRT") && text.ends_with(": no memory"),
            "{text}"
        );
    }
}

//! An engine in a separate Python process, stepped on request.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use cell_run::python::interpreter;

/// A Python program that steps a scene. It reads a text, preceded by a line with its length in
/// bytes, and answers with a line: its version. Then it answers each request by a line; a
/// number of steps by their times (ns).
pub(crate) struct PythonStepper {
    child: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
    version: String,
}

impl PythonStepper {
    /// Starts `program` with `text` in the interpreter of task files; `None` without Python, or
    /// without a package that the program needs.
    pub(crate) fn start(program: &str, text: &str) -> Option<Self> {
        let mut child = Command::new(interpreter())
            .args(["-c", program])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            // Discarded: an import error of an optional package is not a message for the user.
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut requests = child.stdin.take()?;
        let answers = BufReader::new(child.stdout.take()?);
        let sent = write!(requests, "{}\n{text}", text.len()).and_then(|()| requests.flush());
        let mut stepper = Self {
            child,
            requests,
            answers,
            version: String::new(),
        };
        sent.ok()?;
        stepper.version = stepper.line()?;
        Some(stepper)
    }

    /// Version of the engine.
    pub(crate) fn version(&self) -> &str {
        &self.version
    }

    /// Steps, and returns the time of each step (ns). `controls` are those of each step, one
    /// after the other; without any the engine keeps its last controls.
    pub(crate) fn step(&mut self, steps: usize, controls: &[f64]) -> Vec<u64> {
        let controls = controls.iter().map(|control| format!(" {control}"));
        let answer = self.ask(&format!("{steps}{}", controls.collect::<String>()));
        times(&answer.unwrap_or_default())
    }

    /// Runs `blocks` blocks of `steps` steps, each in one call; returns the time of each block
    /// (ns).
    pub(crate) fn blocks(&mut self, blocks: usize, steps: usize) -> Vec<u64> {
        let answer = self.ask(&format!("blocks {blocks} {steps}"));
        times(&answer.unwrap_or_default())
    }

    /// Height of a body (m).
    pub(crate) fn height(&mut self, body: &str) -> Option<f64> {
        self.ask(&format!("height {body}"))?.parse().ok()
    }

    fn ask(&mut self, request: &str) -> Option<String> {
        writeln!(self.requests, "{request}").ok()?;
        self.requests.flush().ok()?;
        self.line()
    }

    fn line(&mut self) -> Option<String> {
        let mut line = String::new();
        let read = self.answers.read_line(&mut line).ok()?;
        (read > 0).then(|| line.trim().to_owned())
    }
}

fn times(answer: &str) -> Vec<u64> {
    let times = answer.split(' ').filter_map(|time| time.parse().ok());
    times.collect()
}

impl Drop for PythonStepper {
    fn drop(&mut self) {
        // And waited for, so that no zombie is left for the rest of the bench.
        let _ended = self.child.kill();
        let _waited = self.child.wait();
    }
}

//! An engine in a Python beside this process, stepped on request.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use cell_model::runs::python::interpreter;

use crate::report::Samples;

/// A Python program that steps a scene. It reads a text, preceded by a line with its
/// length in bytes, and answers with a line: its version. Then it answers each line with
/// a number of steps by a line with their times (ns).
pub(crate) struct PythonStepper {
    child: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
    version: String,
}

impl PythonStepper {
    /// Starts `program` with `text` in the interpreter of task files; `None` where there
    /// is no Python, or no package that the program needs.
    pub(crate) fn start(program: &str, text: &str) -> Option<Self> {
        let mut child = Command::new(interpreter())
            .args(["-c", program])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
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

    /// Steps, and takes the times.
    pub(crate) fn step(&mut self, steps: usize, samples: &mut Samples) {
        let asked = writeln!(self.requests, "{steps}").and_then(|()| self.requests.flush());
        let answer = asked.ok().and_then(|()| self.line()).unwrap_or_default();
        let times = answer.split(' ').filter_map(|time| time.parse().ok());
        times.for_each(|time_ns| samples.record(time_ns));
    }

    fn line(&mut self) -> Option<String> {
        let mut line = String::new();
        let read = self.answers.read_line(&mut line).ok()?;
        (read > 0).then(|| line.trim().to_owned())
    }
}

impl Drop for PythonStepper {
    fn drop(&mut self) {
        let _ended = self.child.kill();
        let _waited = self.child.wait();
    }
}

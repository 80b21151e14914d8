//! `robocell record`: asks the recorder in the monitor.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::time::Duration;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use supervisor::failure::{Context, Failure};

use crate::args::{RecordArgs, RecordVerb};
use crate::client::Session;
use crate::run::plan::paths::new_file;
use crate::{output, say};

/// Copying minutes of a recording takes seconds.
const PATIENCE: Duration = Duration::from_secs(60);

/// One request to the recorder.
#[derive(Debug, Serialize)]
#[serde(tag = "ask", rename_all = "snake_case")]
enum Request {
    Start { file: PathBuf },
    Stop,
    Last { seconds: f64, file: PathBuf },
}

/// The result of `robocell record --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Recorded {
    /// `start`, `stop` or `last`.
    #[serde(rename = "do")]
    action: &'static str,
    /// The file that is written; unknown for `stop`.
    #[schemars(with = "Option<String>")]
    file: Option<PathBuf>,
    /// What the recorder answered.
    message: String,
}

impl Recorded {
    fn new(request: Request, message: String) -> Self {
        let (action, file) = match request {
            Request::Start { file } => ("start", Some(file)),
            Request::Stop => ("stop", None),
            Request::Last { file, .. } => ("last", Some(file)),
        };
        Self {
            action,
            file,
            message,
        }
    }
}

#[derive(Debug, Deserialize)]
struct Reply {
    ok: bool,
    message: String,
}

/// Does what the command line says.
pub(crate) fn record(args: &RecordArgs) -> Result<(), Failure> {
    let session = Session::of(args.verb.cell())?;
    let file = |file: &Option<PathBuf>| match file {
        // Made absolute: the recorder, which writes the file, works in `/`.
        Some(file) => new_file(file),
        None => new_file(&made_up(&session.spec.demo)),
    };
    let request = match &args.verb {
        RecordVerb::Start { file: to, .. } => Request::Start { file: file(to)? },
        RecordVerb::Stop(_) => Request::Stop,
        RecordVerb::Last { span, file: to, .. } => Request::Last {
            seconds: *span,
            file: file(to)?,
        },
    };
    let socket = session.dir.record();
    let reply = ask(&socket, &request).cannot(
        "reach the recorder; it is part of the monitor, `robocell status` shows whether that runs",
    )?;
    if !reply.ok {
        return Err(Failure::configuration(reply.message));
    }
    let recorded = Recorded::new(request, reply.message);
    if args.json {
        return output::print(&recorded);
    }
    say::line(recorded.message);
    Ok(())
}

/// `franka-stack.mcap`, or the first of `franka-stack-2.mcap`, ... that is free,
/// in the current directory.
fn made_up(demo: &str) -> PathBuf {
    let name = |number: u32| match number {
        1 => PathBuf::from(format!("{demo}.mcap")),
        _ => PathBuf::from(format!("{demo}-{number}.mcap")),
    };
    let free = (1..10_000).map(name).find(|path| !path.exists());
    // `new_file` then refuses this one, with the reason.
    free.unwrap_or_else(|| name(1))
}

fn ask(socket: &Path, request: &Request) -> io::Result<Reply> {
    let mut stream = UnixStream::connect(socket)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    writeln!(stream, "{}", serde_json::to_string(request)?)?;
    let mut line = String::new();
    // A peer that sends without end must not fill the memory.
    BufReader::new(stream.take(1 << 16)).read_line(&mut line)?;
    Ok(serde_json::from_str(&line)?)
}

//! `robocell record`: asks the recorder in the monitor.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::cli::{RecordArgs, RecordVerb};
use crate::client::Session;
use crate::failure::{Context, Failure};
use crate::run::plan::new_file;
use crate::say;

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

#[derive(Debug, Deserialize)]
struct Reply {
    ok: bool,
    message: String,
}

/// Does what the command line says.
pub(crate) fn record(args: &RecordArgs) -> Result<(), Failure> {
    let session = Session::of(&args.cell.cell)?;
    let file = |file: &Option<PathBuf>| match file {
        Some(file) => new_file(file),
        None => new_file(&made_up(&session.spec.demo)),
    };
    let request = match &args.verb {
        RecordVerb::Start { file: to } => Request::Start { file: file(to)? },
        RecordVerb::Stop => Request::Stop,
        RecordVerb::Last { span, file: to } => Request::Last {
            seconds: *span,
            file: file(to)?,
        },
    };
    let socket = session.dir.record();
    let reply = ask(&socket, &request).cannot(
        "reach the recorder; it lives in the monitor, `robocell status` says whether that runs",
    )?;
    if reply.ok {
        say::line(reply.message);
        Ok(())
    } else {
        Err(Failure::configuration(reply.message))
    }
}

/// `franka-stack.mcap`, or the first of `franka-stack-2.mcap`, ... that is free,
/// in the current directory.
fn made_up(demo: &str) -> PathBuf {
    let name = |number: u32| match number {
        1 => PathBuf::from(format!("{demo}.mcap")),
        _ => PathBuf::from(format!("{demo}-{number}.mcap")),
    };
    let free = (1..10_000).map(name).find(|path| !path.exists());
    free.unwrap_or_else(|| name(1))
}

fn ask(socket: &Path, request: &Request) -> io::Result<Reply> {
    let mut stream = UnixStream::connect(socket)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    writeln!(stream, "{}", serde_json::to_string(request)?)?;
    let mut line = String::new();
    BufReader::new(stream.take(1 << 16)).read_line(&mut line)?;
    Ok(serde_json::from_str(&line)?)
}

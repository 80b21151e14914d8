//! Socket for the command line: one line of JSON in, one out.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

use cell_rt::is_readable;
use serde_json::json;

use super::{RecorderClient, RecorderRequest, lock};

/// Longest request (bytes).
// Two paths and a number; a longer line is not a request.
const MAX_LINE: u64 = 1 << 16;
/// Interval of the check whether the recorder ends.
const CHECK_INTERVAL: Duration = Duration::from_millis(200);
/// Time in which a client has to send its request.
// One client at a time, so a silent one must not hold up the others.
const PATIENCE: Duration = Duration::from_secs(1);

/// Serves requests one after the other until the recorder ends.
pub(super) fn serve(path: &Path, client: &RecorderClient) {
    // An earlier monitor may have been killed.
    let _gone = std::fs::remove_file(path).is_ok();
    let listener = match UnixListener::bind(path) {
        Ok(listener) => listener,
        Err(error) => {
            let path = path.display();
            cell_worker::warn(format_args!(
                "`robocell record` will not work: {path}: {error}"
            ));
            // The cell records without it; the note has the reason.
            lock(&client.shared.status).note = format!("{path}: {error}");
            return;
        }
    };
    while !client.shared.ending.load(Ordering::Acquire) {
        // With a limit: if the socket's file is gone, no connection can wake this thread.
        match is_readable(&listener, CHECK_INTERVAL) {
            Ok(true) => {}
            Ok(false) => continue,
            Err(_) => break,
        }
        let stream = listener.accept().map(|(stream, _)| stream);
        // The connection may be the one of `wake`.
        if client.shared.ending.load(Ordering::Acquire) {
            break;
        }
        // A client that leaves before the answer does not need it.
        let _answered = stream.and_then(|stream| answer(&stream, client)).is_ok();
    }
    let _gone = std::fs::remove_file(path).is_ok();
}

/// Makes [`serve`] check whether it has to end.
pub(super) fn wake(path: &Path) {
    let _woken = UnixStream::connect(path).is_ok();
}

fn answer(stream: &UnixStream, client: &RecorderClient) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut line = String::new();
    BufReader::new(stream.take(MAX_LINE)).read_line(&mut line)?;
    let reply = match serde_json::from_str::<RecorderRequest>(&line) {
        Ok(request) => client.ask(request),
        Err(error) => Err(format!("no request: {error}")),
    };
    let ok = reply.is_ok();
    let message = reply.unwrap_or_else(|why| why);
    let mut out = stream;
    writeln!(out, "{}", json!({ "ok": ok, "message": message }))
}

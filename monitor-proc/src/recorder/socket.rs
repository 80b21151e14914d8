//! For the command line: one line of JSON in, one out.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

use cell_rt::is_readable;
use serde_json::json;

use super::{Desk, RecorderRequest, lock};

/// Longest request (bytes).
const MAX_LINE: u64 = 1 << 16;
/// How often it is looked whether the recorder ends.
const LOOK: Duration = Duration::from_millis(200);
/// A client sends its request within this time.
const PATIENCE: Duration = Duration::from_secs(1);

/// Serves requests one after the other until the recorder ends.
pub(super) fn serve(path: &Path, desk: &Desk) {
    // An earlier monitor may have been killed.
    let _gone = std::fs::remove_file(path).is_ok();
    let listener = match UnixListener::bind(path) {
        Ok(listener) => listener,
        Err(error) => {
            let path = path.display();
            cell_worker::warn(format_args!(
                "`robocell record` will not work: {path}: {error}"
            ));
            lock(&desk.shared.status).note = format!("{path}: {error}");
            return;
        }
    };
    while !desk.shared.ending.load(Ordering::Acquire) {
        // With a limit: without the socket's file no connection can wake this thread.
        match is_readable(&listener, LOOK) {
            Ok(true) => {}
            Ok(false) => continue,
            Err(_) => break,
        }
        let stream = listener.accept().map(|(stream, _)| stream);
        if desk.shared.ending.load(Ordering::Acquire) {
            break;
        }
        // Who goes away before the answer does not want it.
        let _answered = stream.and_then(|stream| answer(&stream, desk)).is_ok();
    }
    let _gone = std::fs::remove_file(path).is_ok();
}

/// Lets [`serve`] look whether it shall end.
pub(super) fn wake(path: &Path) {
    let _woken = UnixStream::connect(path).is_ok();
}

fn answer(stream: &UnixStream, desk: &Desk) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut line = String::new();
    BufReader::new(stream.take(MAX_LINE)).read_line(&mut line)?;
    let reply = match serde_json::from_str::<RecorderRequest>(&line) {
        Ok(request) => desk.ask(request),
        Err(error) => Err(format!("no request: {error}")),
    };
    let ok = reply.is_ok();
    let message = reply.unwrap_or_else(|why| why);
    let mut out = stream;
    writeln!(out, "{}", json!({ "ok": ok, "message": message }))
}

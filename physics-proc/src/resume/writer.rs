//! The thread that writes states.

use std::io;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use cell_rt::RecordFile;

use super::store::Store;

/// A state and its tick; the buffer is returned with the result.
type State = (u64, Vec<u8>);
type Written = (u64, Vec<u8>, Result<(), String>);

/// The store of a process: a file, and a thread that writes it.
pub(crate) struct Writer {
    file: RecordFile,
    states: Option<SyncSender<State>>,
    written: Receiver<Written>,
    thread: Option<JoinHandle<()>>,
    /// Buffer of the previous state: memory that is already mapped is filled faster.
    buffer: Vec<u8>,
    is_idle: bool,
    /// A result that [`Writer::wait`] took.
    waited: Option<Written>,
    /// Reason if the thread could not be started.
    problem: Option<String>,
}

impl Writer {
    pub(super) fn start(file: RecordFile) -> Self {
        // One place each: with one state at a time neither side ever waits for room.
        let (states, to_write) = sync_channel::<State>(1);
        let (results, written) = sync_channel::<Written>(1);
        let own = file.clone();
        let work = move || {
            for (tick, bytes) in to_write {
                let result = file.write(&bytes);
                let result = result.map_err(|error| format!("{}: {error}", file.path().display()));
                // The receiver is dropped with the process; the state is already on the disk.
                if results.send((tick, bytes, result)).is_err() {
                    return;
                }
            }
        };
        let thread = std::thread::Builder::new().name("resume".to_owned());
        let thread = thread.spawn(work);
        let problem = thread.as_ref().err().map(ToString::to_string);
        Self {
            file: own,
            states: Some(states),
            written,
            thread: thread.ok(),
            buffer: Vec::new(),
            is_idle: true,
            waited: None,
            problem,
        }
    }
}

impl Store for Writer {
    fn read(&self) -> io::Result<Option<Vec<u8>>> {
        self.file.read()
    }

    fn read_older(&self) -> io::Result<Option<Vec<u8>>> {
        self.file.read_older()
    }

    fn replace_by_older(&self) -> io::Result<()> {
        self.file.replace_by_older()
    }

    fn name(&self) -> String {
        self.file.path().display().to_string()
    }

    fn is_idle(&self) -> bool {
        self.is_idle
    }

    fn write(&mut self, tick: u64, fill: impl FnOnce(&mut Vec<u8>)) {
        let mut bytes = std::mem::take(&mut self.buffer);
        bytes.clear();
        fill(&mut bytes);
        let Some(states) = &self.states else {
            return;
        };
        // A thread that could not be started is a failed write, so that it is reported as one.
        if let Err(error) = states.try_send((tick, bytes)) {
            let problem = self.problem.clone().unwrap_or_else(|| error.to_string());
            self.waited = Some((tick, Vec::new(), Err(problem)));
        }
        // Also after an error: the result that was put in place sets it back.
        self.is_idle = false;
    }

    fn result(&mut self) -> Option<(u64, Result<(), String>)> {
        let written = self.waited.take().or_else(|| self.written.try_recv().ok());
        let (tick, bytes, result) = written?;
        self.buffer = bytes;
        self.is_idle = true;
        Some((tick, result))
    }

    fn wait(&mut self) {
        if self.waited.is_none() {
            self.waited = self.written.recv().ok();
        }
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        // Closes the channel; the thread ends after the write that is running.
        self.states = None;
        if let Some(thread) = self.thread.take() {
            // The thread has no result.
            thread.join().ok();
        }
    }
}

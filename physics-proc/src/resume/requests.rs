//! Requests that were accepted after the newest saved state, so that a successor of
//! physics obeys them again.

use std::io;
use std::path::Path;

use cell_rt::SlotFile;
use ipc_types::{OperatorRequest, Wire};

use crate::plant::Plant;

/// Name of the file in the run directory.
pub(super) const FILE: &str = "physics.requests";
/// Capacity in requests: more than a page sends between two saved states (60 Hz for 1 s at
/// most). Requests beyond it are reported as lost.
pub(super) const REQUESTS: usize = 64;
/// Bytes before a request: identity of the run.
const HEAD_BYTES: usize = 8;
/// Bytes of a request with its head.
pub(super) const RECORD_BYTES: usize = HEAD_BYTES + size_of::<OperatorRequest>();

/// The file.
pub(super) struct Requests {
    file: SlotFile,
    run: u64,
}

impl Requests {
    pub(super) fn open(run_dir: &Path, run: u64) -> io::Result<Self> {
        let file = SlotFile::with_slots(&run_dir.join(FILE), RECORD_BYTES, REQUESTS)?;
        Ok(Self::of(file, run))
    }

    /// As [`Self::open`], for a `file` with room for [`REQUESTS`] of [`RECORD_BYTES`].
    pub(super) fn of(file: SlotFile, run: u64) -> Self {
        Self { file, run }
    }

    /// Whether records of the process before are lost, because its file is damaged.
    pub(super) fn are_damaged(&self) -> bool {
        self.file.was_damaged()
    }

    /// Records that `request` was accepted with this number. It makes no system call and no
    /// allocation: physics calls it within a tick.
    pub(super) fn note(&mut self, number: u64, request: &OperatorRequest) {
        let mut bytes = [0; RECORD_BYTES];
        bytes[..HEAD_BYTES].copy_from_slice(&self.run.to_le_bytes());
        bytes[HEAD_BYTES..].copy_from_slice(request.as_bytes());
        // The size fits: all records have it.
        self.file.write(number, &bytes).ok();
    }

    /// Obeys again the requests that were accepted after the state to which `plant` was
    /// restored; returns the number of lost ones.
    pub(super) fn repeat(&self, plant: &mut Plant) -> u64 {
        let mut lost = 0;
        // `all` gives the newest first; they have to be obeyed in the order of acceptance.
        let mut noted = self.file.all();
        noted.reverse();
        for (number, bytes) in noted {
            let (run, request) = bytes.split_at(HEAD_BYTES.min(bytes.len()));
            let request = OperatorRequest::from_bytes(request);
            let is_ours = run == self.run.to_le_bytes();
            // Requests with smaller numbers are already part of the restored state.
            let Some(request) = request.filter(|_| is_ours && number > plant.accepted()) else {
                continue;
            };
            // Numbers without a record were overwritten by newer ones.
            lost += number - plant.accepted() - 1;
            // Obeying counts up by one, so that the request gets its old number again.
            plant.set_accepted(number - 1);
            plant.answer_request(&request);
            // A request that is refused now keeps its number: the next one has its own.
            lost += u64::from(plant.accepted() < number);
            plant.set_accepted(number);
        }
        lost
    }
}

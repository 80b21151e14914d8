//! The reader of a topic.
//!
//! What can go wrong: a writer dies in the middle of anything, a replaced writer wakes up and
//! publishes again, a bit flips in shared memory, or a reader is too slow. The rule: a message
//! is used only after its content was validated and the fence has admitted it, and the last
//! good message stays readable until a newer good one replaces it. A reader never waits and
//! never makes a writer wait: it loses the oldest message instead, and counts it.
//!
//! A change must not break: validation comes before any use of a field, also of enumerations
//! and lengths; at most `MAX_BORROWED` (`qos.rs`) samples are held at a time, otherwise the
//! next `receive` fails.

use core::fmt::Debug;
use core::ops::Deref;

use ipc_types::header::Message;
use ipc_types::{Invalid, Validate as _, Wire as _};

use crate::fence::{Admission, Counts, Fence};

/// A reading port of one of the wirings.
pub(crate) trait Inlet: Debug {
    type Message: Message;
    /// A message in its place.
    type Sample: Deref<Target = Self::Message> + Debug;

    /// The next message and the port that sent it, or `None`; an error is of the connection to
    /// one writer.
    fn receive(&mut self) -> Result<Option<(u128, Self::Sample)>, NoConnection>;

    /// Whether a message just taken must be the newest: its writer can have no second one
    /// waiting, and it is the only writer. A `receive` that finds nothing costs more than this
    /// check.
    fn is_the_only_one(&self) -> bool;
}

/// A writer that died while it joined.
#[derive(Debug)]
pub(crate) struct NoConnection;

/// The reader of a topic, with the type of its port hidden.
#[doc(hidden)]
pub trait Subscribe<T>: core::fmt::Debug {
    fn take(&mut self) -> Option<&T>;
    fn current(&self) -> Option<&T>;
    fn take_all(&mut self, each: &mut dyn FnMut(&T)) -> usize;
    fn counts(&self) -> Counts;
    fn writer_generation(&self) -> u32;
    fn take_invalid(&mut self) -> Option<Invalid>;
    fn errors(&self) -> u64;
}

#[derive(Debug)]
pub(crate) struct Reader<I: Inlet> {
    port: I,
    current: Option<I::Sample>,
    fence: Fence,
    invalid: Option<Invalid>,
    errors: u64,
}

impl<I: Inlet> Reader<I> {
    /// The reader of messages of run `run`.
    pub(crate) fn new(port: I, run: u64) -> Self {
        Self {
            port,
            current: None,
            fence: Fence::new(run, I::Message::SCHEMA),
            invalid: None,
            errors: 0,
        }
    }

    /// The next message that may be used.
    fn receive(&mut self) -> Option<I::Sample> {
        loop {
            // An error is of the connection to one writer, e.g. one that died while it joined.
            // The message in use stays valid, so the cycle continues with it.
            let Ok(received) = self.port.receive() else {
                self.errors += 1;
                return None;
            };
            let (port, message) = received?;
            // Validated in place, in shared memory: a copy first
            // would cost the cycle a state of 20 kB.
            let checked = message.validate();
            // The port id is the connection's, not the message's,
            // so a flipped bit cannot forge it.
            let admission = self.fence.judge(port, message.header(), checked.is_ok());
            if admission == Admission::Accept {
                return Some(message);
            }
            // The reason is kept for the log; the drop itself is in the counts.
            self.invalid = checked.err().or(self.invalid);
        }
    }
}

impl<I: Inlet> Subscribe<I::Message> for Reader<I> {
    fn take(&mut self) -> Option<&I::Message> {
        let mut fresh = false;
        // Older messages are judged as well: skipping them would
        // leave gaps in the fence's counts.
        while let Some(sample) = self.receive() {
            self.current = Some(sample);
            fresh = true;
            if self.port.is_the_only_one() {
                break;
            }
        }
        // Without a new message the caller must not act on the old one as if it were new.
        if fresh { self.current() } else { None }
    }

    fn current(&self) -> Option<&I::Message> {
        self.current.as_deref()
    }

    fn take_all(&mut self, each: &mut dyn FnMut(&I::Message)) -> usize {
        let mut taken = 0;
        // The newest stays borrowed as the current message; all
        // before it are returned one by one.
        while let Some(sample) = self.receive() {
            each(&sample);
            taken += 1;
            self.current = Some(sample);
        }
        taken
    }

    fn counts(&self) -> Counts {
        self.fence.counts
    }

    fn writer_generation(&self) -> u32 {
        self.fence.generation()
    }

    fn take_invalid(&mut self) -> Option<Invalid> {
        self.invalid.take()
    }

    fn errors(&self) -> u64 {
        self.errors
    }
}

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

use iceoryx2::port::subscriber::Subscriber as Port;
use iceoryx2::prelude::{PortFactory as _, ipc};
use iceoryx2::sample::Sample;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use ipc_types::Invalid;
use ipc_types::header::Message;

use crate::bus::Bus;
use crate::error::BusError;
use crate::fence::{Admission, Counts, Fence};

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
pub(crate) struct Reader<T: Message> {
    port: Port<ipc::Service, T, ()>,
    service: PortFactory<ipc::Service, T, ()>,
    /// Messages of one writer that can wait.
    depth: usize,
    current: Option<Sample<ipc::Service, T, ()>>,
    fence: Fence,
    invalid: Option<Invalid>,
    errors: u64,
}

impl<T: Message> Reader<T> {
    pub(crate) fn open(bus: &Bus, name: &str) -> Result<Self, BusError> {
        let service = bus.open_topic::<T>(name)?;
        let port = service
            .subscriber_builder()
            .create()
            .map_err(|error| BusError::Port {
                service: name.to_owned(),
                reason: format!("{error:?}"),
            })?;
        Ok(Self {
            depth: port.buffer_size(),
            port,
            service,
            current: None,
            fence: Fence::new(bus.run(), T::SCHEMA),
            invalid: None,
            errors: 0,
        })
    }

    /// Whether a message just taken must be the newest: its writer can have no second one
    /// waiting, and it is the only writer. A `receive` that finds nothing costs more than this
    /// check.
    fn is_the_only_one(&self) -> bool {
        self.depth == 1 && self.service.dynamic_config().number_of_publishers() == 1
    }

    /// The next message that may be used.
    fn receive(&mut self) -> Option<Sample<ipc::Service, T, ()>> {
        loop {
            // An error is of the connection to one writer, e.g. one that died while it joined.
            // The message in use stays valid, so the cycle continues with it.
            let Ok(received) = self.port.receive() else {
                self.errors += 1;
                return None;
            };
            let sample = received?;
            let message = sample.payload();
            // Validated in place, in shared memory: a copy first
            // would cost the cycle a state of 20 kB.
            let checked = message.validate();
            let port = sample.origin().value();
            // The port id is the connection's, not the message's,
            // so a flipped bit cannot forge it.
            let admission = self.fence.judge(port, message.header(), checked.is_ok());
            if admission == Admission::Accept {
                return Some(sample);
            }
            // The reason is kept for the log; the drop itself is in the counts.
            self.invalid = checked.err().or(self.invalid);
        }
    }
}

impl<T: Message> Subscribe<T> for Reader<T> {
    fn take(&mut self) -> Option<&T> {
        let mut fresh = false;
        // Older messages are judged as well: skipping them would
        // leave gaps in the fence's counts.
        while let Some(sample) = self.receive() {
            self.current = Some(sample);
            fresh = true;
            if self.is_the_only_one() {
                break;
            }
        }
        // Without a new message the caller must not act on the old one as if it were new.
        if fresh { self.current() } else { None }
    }

    fn current(&self) -> Option<&T> {
        self.current.as_deref()
    }

    fn take_all(&mut self, each: &mut dyn FnMut(&T)) -> usize {
        let mut taken = 0;
        // The newest stays borrowed as the current message; all
        // before it are returned one by one.
        while let Some(sample) = self.receive() {
            each(sample.payload());
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

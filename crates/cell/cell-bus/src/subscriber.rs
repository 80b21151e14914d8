//! What a reader of a topic sees: messages in place, or a copy of the newest.

use ipc_types::Invalid;

use crate::bus::Bus;
use crate::error::BusError;
use crate::fence::Counts;
use crate::message::TopicMessage;
use crate::reader::Subscribe;

/// Takes messages and reads them in place. Every message is judged once: of
/// this run, of the newest generation of its writer, not used before, and
/// valid in every field. What fails is dropped and counted; the last good one
/// stays.
#[derive(Debug)]
pub struct Subscriber<T: TopicMessage>(Box<dyn Subscribe<T>>);

impl<T: TopicMessage> Subscriber<T> {
    pub(crate) fn open(bus: &Bus, name: &str) -> Result<Self, BusError> {
        T::subscribe_to(bus, name).map(Self)
    }

    /// The newest message, if one arrived since the last call. It is in shared memory and stays
    /// there until a newer one is taken.
    pub fn take(&mut self) -> Option<&T> {
        self.0.take()
    }

    /// The last good message, however old.
    pub fn current(&self) -> Option<&T> {
        self.0.current()
    }

    /// Passes every waiting message to `each`, oldest first; returns their number. Gaps are in
    /// [`Counts::late`].
    pub fn take_all(&mut self, mut each: impl FnMut(&T)) -> usize {
        self.0.take_all(&mut each)
    }

    /// Numbers of messages accepted and dropped since the topic was opened.
    pub fn counts(&self) -> Counts {
        self.0.counts()
    }

    /// Generation of the newest writer; 0 before its first message.
    pub fn writer_generation(&self) -> u32 {
        self.0.writer_generation()
    }

    /// The newest reason for a rejection; the next call returns `None`.
    pub fn take_invalid(&mut self) -> Option<Invalid> {
        self.0.take_invalid()
    }

    /// Times the transport could not read from a writer, such as one that died
    /// while it joined.
    pub fn errors(&self) -> u64 {
        self.0.errors()
    }
}

/// Keeps its own copy of the newest message: for readers that use it for long, or after its
/// writer is gone.
#[derive(Debug)]
pub struct Latest<T: TopicMessage> {
    subscriber: Subscriber<T>,
    copy: Option<Box<T>>,
}

impl<T: TopicMessage> Latest<T> {
    pub(crate) fn new(subscriber: Subscriber<T>) -> Self {
        Self {
            subscriber,
            copy: None,
        }
    }

    /// Reads a newer message; true if there was one.
    pub fn refresh(&mut self) -> bool {
        let Some(message) = self.subscriber.take() else {
            return false;
        };
        // The box is reused: only the first message allocates, not the cycle.
        match &mut self.copy {
            Some(copy) => **copy = *message,
            None => self.copy = Some(Box::new(*message)),
        }
        true
    }

    /// The newest message seen by [`Self::refresh`].
    pub fn get(&self) -> Option<&T> {
        self.copy.as_deref()
    }

    /// As [`Subscriber::take_invalid`].
    pub fn take_invalid(&mut self) -> Option<Invalid> {
        self.subscriber.take_invalid()
    }

    /// The reading end underneath, for its counts.
    pub fn subscriber(&self) -> &Subscriber<T> {
        &self.subscriber
    }
}

//! The ports of topics that a process opens on its bus.

use ipc_types::topic::TopicId;

use crate::bus::Bus;
use crate::error::BusError;
use crate::message::TopicMessage;
use crate::publisher::Publisher;
use crate::subscriber::{Latest, Subscriber};

impl Bus {
    /// The writer of a topic, and of its tap if it has one (ADR 0012).
    pub fn publisher<T: TopicMessage>(&self, topic: TopicId) -> Result<Publisher<T>, BusError> {
        let tap = topic.tap().map(TopicId::service);
        Publisher::open(self, &topic.service(), tap.as_deref())
    }

    /// A reader of a topic: the newest message, read in place.
    pub fn subscriber<T: TopicMessage>(&self, topic: TopicId) -> Result<Subscriber<T>, BusError> {
        self.subscriber_of(&topic.service())
    }

    /// As [`Self::publisher`], for a topic added by
    /// [`crate::Keeper::add_topic`].
    pub fn publisher_of<T: TopicMessage>(&self, name: &str) -> Result<Publisher<T>, BusError> {
        Publisher::open(self, name, None)
    }

    /// As [`Self::subscriber`], for a topic added by
    /// [`crate::Keeper::add_topic`].
    pub fn subscriber_of<T: TopicMessage>(&self, name: &str) -> Result<Subscriber<T>, BusError> {
        Subscriber::open(self, name)
    }

    /// A reader that keeps a copy of the newest message.
    pub fn latest<T: TopicMessage>(&self, topic: TopicId) -> Result<Latest<T>, BusError> {
        Ok(Latest::new(self.subscriber(topic)?))
    }
}

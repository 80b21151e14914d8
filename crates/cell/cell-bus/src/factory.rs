//! Creates services, with the settings of `qos`.

use std::any::Any;

use iceoryx2::prelude::{Node, ServiceName, ipc};
use iceoryx2::service::builder::Builder;
use ipc_types::header::Message;
use ipc_types::topic::TopicId;

use crate::error::BusError;
use crate::hidden::Hidden;
use crate::qos;

/// Limits with which a topic is created.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    pub(crate) depth: usize,
    pub(crate) readers: usize,
    /// Newest messages a late joiner gets.
    pub(crate) history: usize,
}

impl Limits {
    pub(crate) fn of(topic: TopicId) -> Self {
        Self {
            depth: topic.depth(),
            readers: qos::max_subscribers(topic),
            history: qos::history(topic),
        }
    }
}

/// Creates services as one node of the transport.
#[doc(hidden)]
#[derive(Debug)]
pub struct Factory(Hidden<Node<ipc::Service>>);

impl Factory {
    pub(crate) fn new(node: Node<ipc::Service>) -> Self {
        Self(Hidden::new(node))
    }

    pub(crate) fn create_service<T: Message>(
        &self,
        name: &str,
        limits: Limits,
    ) -> Result<Box<dyn Any>, BusError> {
        let service = self
            .builder(name)?
            .publish_subscribe::<T>()
            // More publishers than the one writer: a slot of a
            // writer killed while it started is lost.
            .max_publishers(qos::MAX_PUBLISHERS)
            .max_subscribers(limits.readers)
            .max_nodes(qos::MAX_NODES)
            .history_size(limits.history)
            .subscriber_max_buffer_size(limits.depth)
            .subscriber_max_borrowed_samples(qos::MAX_BORROWED)
            // Without overflow a publisher waits for a stopped
            // reader: 2.0 s in one send were measured.
            .enable_safe_overflow(true)
            .create()
            .map_err(|error| create_error(name, error))?;
        Ok(Box::new(service))
    }

    pub(crate) fn builder(&self, name: &str) -> Result<Builder<ipc::Service>, BusError> {
        let name = ServiceName::new(name).map_err(|error| create_error(name, error))?;
        Ok(self.0.service_builder(&name))
    }
}

pub(crate) fn create_error(service: &str, reason: impl core::fmt::Debug) -> BusError {
    BusError::Create {
        service: service.to_owned(),
        reason: format!("{reason:?}"),
    }
}

//! The wiring between processes: services of iceoryx2, opened as one node of the transport.
//!
//! A change must not make a process *create* a service: only the keeper does.

use std::time::Duration;

use cell_rt::{monotonic_ns, sleep_until};
use iceoryx2::prelude::{
    Config, LogLevel, MessagingPattern, Node, NodeBuilder, NodeName, Service, ServiceName,
    SignalHandlingMode, ipc, set_log_level,
};
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError as OpenError;
use iceoryx2::service::port_factory::event::PortFactory as Bell;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use ipc_types::header::Message;
use ipc_types::topic::OPERATOR_SERVICE;
use ipc_types::{OperatorReply, OperatorRequest};

use crate::bell::{Ring, Sleep};
use crate::error::BusError;
use crate::hidden::Hidden;
use crate::operator::{Ask, Serve};
use crate::site::RunSite;

mod bell;
mod cause;
pub(crate) mod operator;
mod topic;

use topic::Inlet;
pub(crate) use topic::Outlet;

/// How long a service that should exist may take to be opened: another process
/// may be cleaning up after a dead one at this moment.
const OPEN_LIMIT: Duration = Duration::from_secs(2);
// Short against the limit, long against an attempt (0.1 ms on tmpfs): 400 attempts at most.
const RETRY_PAUSE_NS: u64 = 5_000_000;

/// A node of the transport.
#[derive(Debug)]
pub(crate) struct Shared {
    node: Hidden<Node<ipc::Service>>,
    config: Config,
    site: RunSite,
}

impl Shared {
    /// Joins the run at `site` as the process called `name`. Signals stay with the caller.
    pub(crate) fn join(site: &RunSite, name: &str) -> Result<Self, BusError> {
        // Before the first call into the transport: it logs its
        // missing configuration file as well.
        // The transport reports expected races as errors on the terminal.
        set_log_level(LogLevel::Fatal);
        let config = site.config()?;
        let failed = |reason: String| BusError::Join {
            root: site.root.clone(),
            reason,
        };
        let name = NodeName::new(name).map_err(|error| failed(format!("{error:?}")))?;
        // The process handles signals itself: handlers of the transport would replace them, and
        // a SIGTERM would then not bring the arm to rest first.
        let node = NodeBuilder::new()
            .name(&name)
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(|error| failed(format!("{error:?}")))?;
        Ok(Self {
            node: Hidden::new(node),
            config,
            site: site.clone(),
        })
    }

    pub(crate) fn outlet<T: Message>(&self, name: &str) -> Result<Outlet<T>, BusError> {
        Outlet::new(&self.open_topic(name)?, name, &self.site)
    }

    pub(crate) fn inlet<T: Message>(&self, name: &str) -> Result<Inlet<T>, BusError> {
        Inlet::new(self.open_topic(name)?, name, &self.site)
    }

    pub(crate) fn ring(&self, name: &str) -> Result<Box<dyn Ring>, BusError> {
        bell::ring(&self.open_bell(name)?, name, &self.site)
    }

    pub(crate) fn sleep(&self, name: &str) -> Result<Box<dyn Sleep>, BusError> {
        bell::sleep(&self.open_bell(name)?, name, &self.site)
    }

    pub(crate) fn ask(&self) -> Result<Box<dyn Ask>, BusError> {
        operator::ask(&self.open_operator()?, &self.site)
    }

    pub(crate) fn serve(&self) -> Result<Box<dyn Serve>, BusError> {
        operator::serve(&self.open_operator()?, &self.site)
    }

    fn open_bell(&self, name: &str) -> Result<Bell<ipc::Service>, BusError> {
        open(name, || self.builder(name)?.event().open().map_err(text))
    }

    fn open_operator(&self) -> Result<operator::Factory, BusError> {
        open(OPERATOR_SERVICE, || {
            self.builder(OPERATOR_SERVICE)?
                .request_response::<OperatorRequest, OperatorReply>()
                .open()
                .map_err(text)
        })
    }

    fn open_topic<T: Message>(
        &self,
        name: &str,
    ) -> Result<PortFactory<ipc::Service, T, ()>, BusError> {
        open(name, || {
            // Other types are final: a retry would delay the same error by 2 s.
            match self.builder(name)?.publish_subscribe::<T>().open() {
                Ok(service) => Ok(service),
                Err(OpenError::IncompatibleTypes) => Err(self.version_error::<T>(name)),
                Err(error) => Err(text(error)),
            }
        })
    }

    fn builder(
        &self,
        name: &str,
    ) -> Result<iceoryx2::service::builder::Builder<ipc::Service>, Refusal> {
        Ok(self
            .node
            .service_builder(&ServiceName::new(name).map_err(text)?))
    }

    // The type of the running cell is looked up so that the message names both versions.
    fn version_error<T: Message>(&self, name: &str) -> Refusal {
        let path = core::any::type_name::<T>();
        let short = path.rsplit("::").next().unwrap_or(path);
        let ours = format!("{short}#{:016x}", T::SCHEMA);
        let theirs = ServiceName::new(name).ok().and_then(|service| {
            let pattern = MessagingPattern::PublishSubscribe;
            let details = ipc::Service::details(&service, &self.config, pattern).ok()??;
            let types = details
                .static_details
                .publish_subscribe()
                .message_type_details();
            Some(types.payload.type_name().to_string())
        });
        Refusal::Final(BusError::Version {
            service: name.to_owned(),
            theirs: theirs.unwrap_or_else(|| "another type".to_owned()),
            ours,
        })
    }
}

/// Reason why an attempt to open failed.
enum Refusal {
    Passing(String),
    Final(BusError),
}

fn text(error: impl core::fmt::Debug) -> Refusal {
    Refusal::Passing(format!("{error:?}"))
}

/// Tries until it works, the error is final, or the time is over.
fn open<S>(name: &str, mut open: impl FnMut() -> Result<S, Refusal>) -> Result<S, BusError> {
    // A dead process's files may be under removal at this moment, which fails an attempt
    // without a fault of this cell; hence the retries.
    let start_ns = monotonic_ns();
    loop {
        let reason = match open() {
            Ok(service) => return Ok(service),
            Err(Refusal::Final(error)) => return Err(error),
            Err(Refusal::Passing(reason)) => reason,
        };
        let waited = Duration::from_nanos(monotonic_ns().saturating_sub(start_ns));
        // The limit is checked after an attempt, so that even a late caller gets one.
        if waited >= OPEN_LIMIT {
            let waited_ms = u64::try_from(waited.as_millis()).unwrap_or(u64::MAX);
            return Err(BusError::Open {
                service: name.to_owned(),
                reason,
                waited_ms,
            });
        }
        sleep_until(monotonic_ns() + RETRY_PAUSE_NS);
    }
}

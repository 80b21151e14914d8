//! Doorbells of processes that sleep.

use std::time::Duration;

use cell_rt::{monotonic_ns, sleep_until};
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::ipc;
use iceoryx2::service::port_factory::event::PortFactory;

use crate::error::BusError;
use crate::hidden::Hidden;

fn port_error(service: &str, reason: impl core::fmt::Debug) -> BusError {
    BusError::Port {
        service: service.to_owned(),
        reason: format!("{reason:?}"),
    }
}

/// Wakes a sleeping process. Carries nothing: what there is to read lies in the
/// topics.
#[derive(Debug)]
pub struct Doorbell {
    port: Hidden<Notifier<ipc::Service>>,
    errors: u64,
}

impl Doorbell {
    pub(crate) fn new(service: &PortFactory<ipc::Service>, name: &str) -> Result<Self, BusError> {
        let port = service
            .notifier_builder()
            .create()
            .map_err(|error| port_error(name, error))?;
        Ok(Self {
            port: Hidden::new(port),
            errors: 0,
        })
    }

    /// Rings. Costs little when no one sleeps; never blocks.
    pub fn ring(&mut self) {
        if self.port.notify().is_err() {
            self.errors += 1;
        }
    }

    /// Rings that failed.
    pub fn errors(&self) -> u64 {
        self.errors
    }
}

/// Sleeps until it rings.
#[derive(Debug)]
pub struct Sleeper {
    port: Hidden<Listener<ipc::Service>>,
}

impl Sleeper {
    pub(crate) fn new(service: &PortFactory<ipc::Service>, name: &str) -> Result<Self, BusError> {
        let port = service
            .listener_builder()
            .create()
            .map_err(|error| port_error(name, error))?;
        Ok(Self {
            port: Hidden::new(port),
        })
    }

    /// Sleeps until a ring, a signal, or `timeout`; true for a ring. Rings that
    /// came before count, and any number of rings is one. The caller looks at
    /// its topics in either case.
    pub fn wait(&mut self, timeout: Duration) -> bool {
        match self.port.timed_wait(|_| {}, timeout) {
            Ok(rings) => rings > 0,
            Err(iceoryx2::port::listener::ListenerWaitError::InterruptSignal) => false,
            Err(_) => {
                // A broken bell must not turn a sleeper into a spinner.
                let pause = timeout.min(Duration::from_millis(1));
                sleep_until(monotonic_ns() + u64::try_from(pause.as_nanos()).unwrap_or(0));
                false
            }
        }
    }

    /// Forgets rings so far, without sleeping.
    pub fn drain(&mut self) -> bool {
        self.port.try_wait(|_| {}).is_ok_and(|rings| rings > 0)
    }
}

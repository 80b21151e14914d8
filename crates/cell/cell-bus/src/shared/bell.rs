//! Doorbells of iceoryx2.

use std::time::Duration;

use cell_rt::{monotonic_ns, sleep_until};
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::ipc;
use iceoryx2::service::port_factory::event::PortFactory;

use crate::bell::{Ring, Sleep};
use crate::error::BusError;

// Both ends fail in the same two ways: all ports are taken, or files of the cell are damaged.
fn port_error(service: &str, reason: impl core::fmt::Debug) -> BusError {
    BusError::Port {
        service: service.to_owned(),
        reason: format!("{reason:?}"),
    }
}

pub(super) fn ring(
    service: &PortFactory<ipc::Service>,
    name: &str,
) -> Result<Box<dyn Ring>, BusError> {
    let port = service.notifier_builder().create();
    Ok(Box::new(port.map_err(|error| port_error(name, error))?))
}

pub(super) fn sleep(
    service: &PortFactory<ipc::Service>,
    name: &str,
) -> Result<Box<dyn Sleep>, BusError> {
    let port = service.listener_builder().create();
    Ok(Box::new(port.map_err(|error| port_error(name, error))?))
}

impl Ring for Notifier<ipc::Service> {
    fn ring(&self) -> bool {
        self.notify().is_ok()
    }
}

impl Sleep for Listener<ipc::Service> {
    fn wait(&self, timeout: Duration) -> bool {
        match self.timed_wait(|_| {}, timeout) {
            Ok(rings) => rings > 0,
            // A signal ends the wait early, so that a process
            // that has to stop does not sleep on.
            Err(ListenerWaitError::InterruptSignal) => false,
            Err(_) => {
                // A broken bell must not turn a sleeper into a spinner.
                let pause = timeout.min(Duration::from_millis(1));
                sleep_until(monotonic_ns() + u64::try_from(pause.as_nanos()).unwrap_or(0));
                false
            }
        }
    }

    fn drain(&self) -> bool {
        // Costs 1.6 us even without a ring, so it is not for a 1
        // kHz cycle: that polls its topics.
        self.try_wait(|_| {}).is_ok_and(|rings| rings > 0)
    }
}

//! Doorbells of iceoryx2.

use std::time::Duration;

use cell_rt::{monotonic_ns, sleep_until};
use iceoryx2::port::listener::{Listener, ListenerCreateError, ListenerWaitError};
use iceoryx2::port::notifier::{Notifier, NotifierCreateError};
use iceoryx2::prelude::{PortFactory as _, ipc};
use iceoryx2::service::port_factory::event::PortFactory;

use super::cause::{no_place, port_error};
use crate::bell::{Ring, Sleep};
use crate::error::BusError;
use crate::site::RunSite;

pub(super) fn ring(
    service: &PortFactory<ipc::Service>,
    name: &str,
    site: &RunSite,
) -> Result<Box<dyn Ring>, BusError> {
    let limit = service.static_config().max_notifiers();
    let port = service.notifier_builder().create();
    Ok(Box::new(port.map_err(|error| match error {
        NotifierCreateError::ExceedsMaxSupportedNotifiers => no_place(name, "ringers", limit),
        error => port_error(name, error, site),
    })?))
}

pub(super) fn sleep(
    service: &PortFactory<ipc::Service>,
    name: &str,
    site: &RunSite,
) -> Result<Box<dyn Sleep>, BusError> {
    let limit = service.static_config().max_listeners();
    let port = service.listener_builder().create();
    Ok(Box::new(port.map_err(|error| match error {
        ListenerCreateError::ExceedsMaxSupportedListeners => no_place(name, "sleepers", limit),
        error => port_error(name, error, site),
    })?))
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

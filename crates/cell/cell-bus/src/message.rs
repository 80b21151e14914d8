//! The messages that topics carry.

use core::any::Any;

use ipc_types::header::Message;
use ipc_types::probe::{Probe1K, Probe4K, Probe16K, Probe64};
use ipc_types::{
    ArmCommand, ArmStatus, ClientInput, Contacts, Decision, Health, Keyframe, TraceLine,
    WorldPiece, WorldState,
};

use crate::bus::{Bus, Wiring};
use crate::error::BusError;
use crate::factory::{Factory, Limits};
use crate::reader::{Reader, Subscribe};
use crate::writer::{Publish, Writer};

/// A message that topics carry. Its ports are compiled in this crate and handed
/// out as trait objects, so that no other crate compiles iceoryx2 again.
pub trait TopicMessage: Message {
    #[doc(hidden)]
    fn create(factory: &Factory, name: &str, limits: Limits) -> Result<Box<dyn Any>, BusError>;

    #[doc(hidden)]
    fn publish_on(
        bus: &Bus,
        name: &str,
        tap: Option<&str>,
    ) -> Result<Box<dyn Publish<Self>>, BusError>;

    #[doc(hidden)]
    fn subscribe_to(bus: &Bus, name: &str) -> Result<Box<dyn Subscribe<Self>>, BusError>;
}

// One macro for all types: a generic function would be compiled again in every crate using it.
macro_rules! topic_messages {
    ($($message:ty),* $(,)?) => {$(
        impl TopicMessage for $message {
            fn create(
                factory: &Factory,
                name: &str,
                limits: Limits,
            ) -> Result<Box<dyn Any>, BusError> {
                factory.create_service::<Self>(name, limits)
            }

            fn publish_on(
                bus: &Bus,
                name: &str,
                tap: Option<&str>,
            ) -> Result<Box<dyn Publish<Self>>, BusError> {
                let id = bus.identity();
                Ok(match bus.wiring() {
                    Wiring::Shared(at) => {
                        Box::new(Writer::open(id, name, tap, |name| at.outlet::<Self>(name))?)
                    }
                    Wiring::Memory(at) => {
                        Box::new(Writer::open(id, name, tap, |name| at.outlet::<Self>(name))?)
                    }
                })
            }

            fn subscribe_to(
                bus: &Bus,
                name: &str,
            ) -> Result<Box<dyn Subscribe<Self>>, BusError> {
                Ok(match bus.wiring() {
                    Wiring::Shared(at) => {
                        Box::new(Reader::new(at.inlet::<Self>(name)?, bus.run()))
                    }
                    Wiring::Memory(at) => {
                        Box::new(Reader::new(at.inlet::<Self>(name)?, bus.run()))
                    }
                })
            }
        }
    )*};
}

topic_messages!(
    WorldState,
    Contacts,
    WorldPiece,
    Keyframe,
    ClientInput,
    ArmCommand,
    ArmStatus,
    Decision,
    TraceLine,
    Health,
    Probe64,
    Probe1K,
    Probe4K,
    Probe16K,
);

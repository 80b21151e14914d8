//! The header every message starts with.

use crate::wire::wire;
use crate::{MAX_INPUTS, Wire};

wire! {
    /// One message this message was computed from.
    pub struct Input {
        /// [`crate::topic::TopicId`] of the input; 0 marks an unused entry.
        pub topic: u32,
        /// Generation of the input's writer.
        pub generation: u32,
        /// Sequence number of the input.
        pub seq: u64,
        /// Age of the input that was used in the computation, in ticks: own
        /// state tick minus the tick that caused the input.
        pub age_ticks: u64,
    }
}

wire! {
    /// The sender of this message, its time, and its inputs.
    pub struct Header {
        /// [`Wire::SCHEMA`] of the message.
        pub schema: u64,
        /// Identity of the cell run, chosen by the launcher, never 0.
        pub run: u64,
        /// Start number of the writing process, from 1 up. Readers drop messages of an older
        /// generation than the newest they have seen.
        pub generation: u32,
        /// Number of valid entries in `inputs`.
        pub input_count: u32,
        /// Counts this writer's messages on this topic, from 1 up.
        pub seq: u64,
        /// The tick that caused this message: for a state the tick it ends, for
        /// a command or a decision the tick of the state it answers.
        pub tick: u64,
        /// Simulated time of `tick` in nanoseconds.
        pub sim_time_ns: u64,
        /// `CLOCK_MONOTONIC` at publication in nanoseconds; for latency figures, and to tell an
        /// older message from one with a damaged number; never for a result.
        pub publish_ns: u64,
        /// What this message was computed from.
        pub inputs: [Input; MAX_INPUTS],
    }
}

impl Header {
    /// The header of the message of type `T` that answers `tick`; the publisher
    /// adds seq and time.
    pub fn caused_by<T: Wire>(tick: u64) -> Self {
        Self {
            schema: T::SCHEMA,
            tick,
            sim_time_ns: tick * crate::TICK_NS,
            ..Self::zeroed()
        }
    }

    /// Names one more input; beyond [`MAX_INPUTS`] the input is left out.
    // A wrong lineage is worse than a short one, so nothing is overwritten.
    pub fn push_input(&mut self, input: Input) {
        if let Some(slot) = self.inputs.get_mut(self.input_count as usize) {
            *slot = input;
            self.input_count += 1;
        }
    }

    /// Whether the message was computed from a state of physics' `generation`: a message caused
    /// by an earlier start of physics is about another world.
    pub fn answers(&self, generation: u32) -> bool {
        self.answered() == Some(generation)
    }

    /// The start of physics whose state the message was computed from.
    pub fn answered(&self) -> Option<u32> {
        let state = crate::topic::TopicId::WorldState.code();
        let mut inputs = self.inputs().iter();
        inputs
            .find(|input| input.topic == state)
            .map(|input| input.generation)
    }

    /// The inputs named.
    pub fn inputs(&self) -> &[Input] {
        // Bounded: the count comes from shared memory.
        &self.inputs[..(self.input_count as usize).min(MAX_INPUTS)]
    }
}

/// Requirement of the bus for a message: with feature `iceoryx2` that iceoryx2 can send it,
/// else none.
#[cfg(feature = "iceoryx2")]
pub trait OnBus: iceoryx2::prelude::ZeroCopySend {}
#[cfg(feature = "iceoryx2")]
impl<T: iceoryx2::prelude::ZeroCopySend> OnBus for T {}

/// Requirement of the bus for a message: with feature `iceoryx2` that iceoryx2 can send it,
/// else none.
#[cfg(not(feature = "iceoryx2"))]
pub trait OnBus {}
#[cfg(not(feature = "iceoryx2"))]
impl<T> OnBus for T {}

/// Messages that start with a [`Header`].
pub trait Message: Wire + crate::Validate + OnBus + core::fmt::Debug {
    /// The header.
    fn header(&self) -> &Header;
    /// The header, for the writer.
    fn header_mut(&mut self) -> &mut Header;
}

macro_rules! message {
    ($($t:ty),* $(,)?) => {$(
        impl Message for $t {
            fn header(&self) -> &Header { &self.header }
            fn header_mut(&mut self) -> &mut Header { &mut self.header }
        }
        // At the start of every message, so that it is found without knowing the type.
        const _: () = assert!(core::mem::offset_of!($t, header) == 0);
    )*};
}
message!(
    crate::WorldState,
    crate::Contacts,
    crate::ArmCommand,
    crate::ArmStatus,
    crate::Decision,
    crate::TraceLine,
    crate::Health,
    crate::OperatorRequest,
    crate::OperatorReply,
    crate::WorldPiece,
    crate::Keyframe,
    crate::ClientInput,
);

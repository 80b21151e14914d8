//! Ways to pass a message to another process. Each writes every byte of the payload and reads
//! every byte of it.

use std::io::{Read, Write};

use cell_bus::{Bus, Publisher, Subscriber, TopicMessage};
use cell_rt::monotonic_ns;
use cell_rt::seqlock::Seqlock;
use iceoryx2::port::publisher::Publisher as BarePublisher;
use iceoryx2::port::subscriber::Subscriber as BareSubscriber;
use iceoryx2::prelude::{Node, ServiceName, ipc};
use ipc_types::probe::Probe;

use super::site::{BenchRun, PATIENCE_NS};
use super::{BenchError, bus, io};

/// One way, both directions.
pub(crate) trait Channel {
    /// Writes and sends message number `number`.
    fn send(&mut self, number: u64) -> Result<(), BenchError>;
    /// Waits for message number `number` and reads it.
    fn receive(&mut self, number: u64) -> Result<(), BenchError>;
}

/// First value of message `number`; small, as the cell's values are.
fn first_value(number: u64) -> f64 {
    (number % 1000) as f64
}

fn fill(values: &mut [f64], number: u64) {
    let first = first_value(number);
    for (index, value) in values.iter_mut().enumerate() {
        *value = first + f64::from(u32::try_from(index).unwrap_or(0));
    }
}

/// Reads every value, and compares the first one.
fn check(values: &[f64], number: u64) -> Result<(), BenchError> {
    let sum = values
        .iter()
        .fold(0_u64, |sum, value| sum.wrapping_add(value.to_bits()));
    // The sum is used, or the compiler could skip the reading.
    core::hint::black_box(sum);
    let (sent, got) = (
        first_value(number),
        values.first().copied().unwrap_or(f64::NAN),
    );
    if sent.to_bits() == got.to_bits() {
        Ok(())
    } else {
        Err(BenchError::Wrong { sent, got })
    }
}

/// Spins until `poll` returns a value, with a limit.
fn spin<T>(mut poll: impl FnMut() -> Option<T>) -> Result<T, BenchError> {
    let mut end_ns = None;
    loop {
        // The clock is read rarely: it would add to the round trip.
        for _ in 0..10_000 {
            if let Some(value) = poll() {
                return Ok(value);
            }
            core::hint::spin_loop();
        }
        let now_ns = monotonic_ns();
        if now_ns > *end_ns.get_or_insert(now_ns + PATIENCE_NS) {
            return Err(BenchError::Silent);
        }
    }
}

/// The cell's own topic layer.
pub(crate) struct Topic<T: Probe + TopicMessage> {
    publisher: Publisher<T>,
    subscriber: Subscriber<T>,
    /// False: only the header is written and read, the payload stays untouched.
    whole: bool,
}

/// Names of a pair of topics, seen from either side.
pub(crate) fn names(kind: &str, payload: usize, first: bool) -> (String, String) {
    let name = |direction: &str| format!("bench/{kind}/{payload}/{direction}");
    if first {
        (name("there"), name("back"))
    } else {
        (name("back"), name("there"))
    }
}

impl<T: Probe + TopicMessage> Topic<T> {
    pub(crate) fn open(bus: &Bus, first: bool, whole: bool) -> Result<Self, BenchError> {
        let (to, from) = names(if whole { "topic" } else { "header" }, T::PAYLOAD, first);
        Ok(Self {
            publisher: bus.publisher_of(&to).map_err(super::bus)?,
            subscriber: bus.subscriber_of(&from).map_err(super::bus)?,
            whole,
        })
    }
}

impl<T: Probe + TopicMessage> Channel for Topic<T> {
    fn send(&mut self, number: u64) -> Result<(), BenchError> {
        let whole = self.whole;
        let sent = self.publisher.publish(|message| {
            if whole {
                fill(message.values_mut(), number);
                message.set_used(T::PAYLOAD / 8);
            } else {
                message.set_used(0);
            }
        });
        sent.map(|_| ()).map_err(bus)
    }

    fn receive(&mut self, number: u64) -> Result<(), BenchError> {
        let (subscriber, whole) = (&mut self.subscriber, self.whole);
        spin(|| {
            let message = subscriber.take()?;
            Some(if whole {
                check(message.values(), number)
            } else {
                Ok(())
            })
        })?
    }
}

/// iceoryx2 without a layer: the same message type and nothing else.
pub(crate) struct Bare<T: Probe> {
    publisher: BarePublisher<ipc::Service, T, ()>,
    subscriber: BareSubscriber<ipc::Service, T, ()>,
}

impl<T: Probe> Bare<T> {
    /// With the settings of the cell's topics.
    pub(crate) fn open(node: &Node<ipc::Service>, first: bool) -> Result<Self, BenchError> {
        let (to, from) = names("bare", T::PAYLOAD, first);
        let service = |name: &str| {
            let name = ServiceName::new(name).map_err(bus)?;
            node.service_builder(&name)
                .publish_subscribe::<T>()
                // As `qos` has them: other limits would give the
                // bare row another memory layout.
                .max_publishers(8)
                .max_subscribers(16)
                .max_nodes(32)
                .history_size(1)
                .subscriber_max_buffer_size(1)
                .subscriber_max_borrowed_samples(2)
                .enable_safe_overflow(true)
                .open_or_create()
                .map_err(bus)
        };
        Ok(Self {
            publisher: service(&to)?.publisher_builder().create().map_err(bus)?,
            subscriber: service(&from)?.subscriber_builder().create().map_err(bus)?,
        })
    }
}

impl<T: Probe> Channel for Bare<T> {
    fn send(&mut self, number: u64) -> Result<(), BenchError> {
        let mut sample = ipc_types::loan::loan(&self.publisher).map_err(bus)?;
        let message = sample.payload_mut();
        // The least that any user of the transport sends: a number and a time.
        message.header_mut().seq = number;
        message.header_mut().publish_ns = monotonic_ns();
        fill(message.values_mut(), number);
        sample.send().map(|_| ()).map_err(bus)
    }

    fn receive(&mut self, number: u64) -> Result<(), BenchError> {
        let subscriber = &self.subscriber;
        spin(|| {
            let sample = subscriber.receive().transpose()?;
            Some(
                sample
                    .map_err(bus)
                    .and_then(|sample| check(sample.payload().values(), number)),
            )
        })?
    }
}

/// A counter and the values in a mapped file.
pub(crate) struct Raw {
    to: Seqlock,
    from: Seqlock,
    copy: Vec<u64>,
    values: Vec<f64>,
}

impl Raw {
    pub(crate) fn open(place: &BenchRun, payload: usize, first: bool) -> Result<Self, BenchError> {
        let (to, from) = names("raw", payload, first);
        let open = |name: &str| {
            let path = place.dir.join(name.replace('/', "-"));
            Seqlock::open(&path, payload / 8).map_err(io("map its memory"))
        };
        let copy = vec![0; payload / 8];
        Ok(Self {
            to: open(&to)?,
            from: open(&from)?,
            copy,
            values: vec![0.0; payload / 8],
        })
    }
}

impl Channel for Raw {
    fn send(&mut self, number: u64) -> Result<(), BenchError> {
        let first = first_value(number);
        self.to.write(number, |index| {
            (first + f64::from(u32::try_from(index).unwrap_or(0))).to_bits()
        });
        Ok(())
    }

    fn receive(&mut self, number: u64) -> Result<(), BenchError> {
        let Self {
            from, copy, values, ..
        } = self;
        spin(|| from.read(number, copy).then_some(()))?;
        // The conversion costs nothing; it makes the reading the same as in the other rows.
        for (value, word) in values.iter_mut().zip(copy.iter()) {
            *value = f64::from_bits(*word);
        }
        check(values, number)
    }
}

/// Bytes through a descriptor: a pipe or a socket.
pub(crate) struct Stream<R, W> {
    pub(crate) from: R,
    pub(crate) to: W,
    bytes: Vec<u8>,
    values: Vec<f64>,
}

impl<R: Read, W: Write> Stream<R, W> {
    pub(crate) fn new(from: R, to: W, payload: usize) -> Self {
        Self {
            from,
            to,
            bytes: vec![0; payload],
            values: vec![0.0; payload / 8],
        }
    }
}

impl<R: Read, W: Write> Channel for Stream<R, W> {
    fn send(&mut self, number: u64) -> Result<(), BenchError> {
        fill(&mut self.values, number);
        for (bytes, value) in self.bytes.chunks_exact_mut(8).zip(&self.values) {
            bytes.copy_from_slice(&value.to_le_bytes());
        }
        self.to
            .write_all(&self.bytes)
            .map_err(io("write to its second process"))
    }

    fn receive(&mut self, number: u64) -> Result<(), BenchError> {
        self.from
            .read_exact(&mut self.bytes)
            .map_err(io("read from its second process"))?;
        for (value, bytes) in self.values.iter_mut().zip(self.bytes.chunks_exact(8)) {
            *value = f64::from_le_bytes(bytes.try_into().unwrap_or_default());
        }
        check(&self.values, number)
    }
}

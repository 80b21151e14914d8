//! Reads the taps.
//!
//! Order matters: states are read before the commands and decisions that answer them, and
//! decisions before the statuses that name them, so that latencies find their cause; `Batch`
//! restores the order of publication for the file. Every message that a tap overwrote is
//! counted and written as a gap on its channel.

use cell_bus::{Bus, BusError, Subscriber, TopicMessage};
use cell_record::{Channel, foxglove, wire_bytes};
use ipc_types::topic::{Process, TopicId};
use ipc_types::trace::TraceKind;
use ipc_types::world::FLAG_LOCKSTEP;
use ipc_types::{
    ArmCommand, ArmStatus, ClientInput, Decision, Header, Health, Keyframe, TraceLine, WorldPiece,
    WorldState,
};
use serde_json::Value;

use super::assembler::StateAssembler;
use super::batch::Batch;
use super::hops::Hops;
use super::sink::Sink;

/// Ticks between two `foxglove.FrameTransforms`.
// 50 Hz: enough for a viewer, and a twentieth of the states.
const TRANSFORM_TICKS: u64 = 20;
/// Interval of the health lines (ns of the monotonic clock).
// The figures in it are those of a second.
const HEALTH_NS: u64 = 1_000_000_000;

/// One topic and its missed messages.
struct Tap<T: TopicMessage> {
    port: Subscriber<T>,
    channel: Channel,
    /// Its number in a [`Batch`].
    source: usize,
    late: u64,
}

impl<T: TopicMessage> Tap<T> {
    /// Passes on all waiting messages and records a gap if some were missed; returns their
    /// number.
    fn drain(&mut self, batch: &mut Batch, mut each: impl FnMut(&mut Batch, usize, &T)) -> usize {
        let source = self.source;
        let taken = self.port.take_all(|message| each(batch, source, message));
        let late = self.port.counts().late;
        if late > self.late {
            let seq = self.port.current().map_or(0, |m| m.header().seq);
            batch.put_gap(source, self.channel, late - self.late, seq);
            self.late = late;
        }
        taken
    }
}

/// Opens and numbers taps.
struct Opener<'a> {
    bus: &'a Bus,
    sources: usize,
}

impl Opener<'_> {
    fn tap<T: TopicMessage>(
        &mut self,
        topic: TopicId,
        channel: Channel,
    ) -> Result<Tap<T>, BusError> {
        let port = self.bus.subscriber(topic)?;
        self.sources += 1;
        Ok(Tap {
            port,
            channel,
            source: self.sources - 1,
            late: 0,
        })
    }
}

struct Arm {
    clients: Tap<ClientInput>,
    commands: Tap<ArmCommand>,
    status: Tap<ArmStatus>,
}

/// All topics that the recorder reads.
pub(super) struct Taps {
    world: Tap<WorldPiece>,
    arms: Vec<Arm>,
    decisions: Tap<Decision>,
    trace: Tap<TraceLine>,
    keyframes: Vec<Tap<Keyframe>>,
    healths: Vec<(Process, Subscriber<Health>)>,
    batch: Batch,
    /// Number of the health messages in the batch.
    rest: usize,
    missed: u64,
    names: foxglove::Names,
    assembler: StateAssembler,
    /// Whether a `foxglove.FrameTransforms` with all frames was written.
    all_sent: bool,
    epoch: Option<u32>,
    health_ns: u64,
}

impl Taps {
    pub(super) fn new(bus: &Bus, arms: u8, scene: &Value) -> Result<Self, BusError> {
        let mut open = Opener { bus, sources: 0 };
        let world = open.tap(TopicId::WorldTap, Channel::World)?;
        let decisions = open.tap(TopicId::DecisionTap, Channel::Decision)?;
        let trace = open.tap(TopicId::Trace, Channel::Trace)?;
        let (mut taps, mut keyframes) = (Vec::new(), Vec::new());
        for arm in 0..arms {
            taps.push(Arm {
                clients: open.tap(TopicId::ClientTap(arm), Channel::Client(arm))?,
                commands: open.tap(TopicId::ArmCommandTap(arm), Channel::Command(arm))?,
                status: open.tap(TopicId::ArmStatusTap(arm), Channel::Status(arm))?,
            });
        }
        let keepers = (0..arms).map(Process::Controller).chain([Process::Task]);
        for process in keepers {
            let topic = TopicId::Keyframe(process);
            keyframes.push(open.tap(topic, Channel::Keyframe(process))?);
        }
        let health = |process| Ok((process, bus.subscriber(TopicId::Health(process))?));
        Ok(Self {
            world,
            arms: taps,
            decisions,
            trace,
            keyframes,
            healths: Process::all(arms)
                .into_iter()
                .map(health)
                .collect::<Result<_, BusError>>()?,
            batch: Batch::new(open.sources + 1),
            rest: open.sources,
            missed: 0,
            names: foxglove::Names::of(scene),
            assembler: StateAssembler::new(),
            all_sent: false,
            epoch: None,
            health_ns: 0,
        })
    }

    /// Whether physics waits for the recorder.
    pub(super) fn is_lockstep(&self) -> bool {
        let piece = self.world.port.current();
        piece.is_some_and(|piece| piece.flags & FLAG_LOCKSTEP != 0)
    }

    /// Header of the newest recorded state.
    pub(super) fn newest(&self) -> Option<&Header> {
        self.world.port.current().map(|piece| &piece.state)
    }

    /// Records all waiting messages; returns the fill of the fullest buffer, 0 to 1.
    pub(super) fn drain(&mut self, sink: &mut Sink, hops: &mut Hops, now_ns: u64) -> f64 {
        let mut fill = self.drain_world(hops);
        let mut note = |taken: usize, topic: TopicId| {
            fill = fill.max(taken as f64 / topic.depth() as f64);
        };
        let batch = &mut self.batch;
        for (arm, taps) in self.arms.iter_mut().enumerate() {
            let channel = taps.clients.channel;
            let taken = taps.clients.drain(batch, |batch, source, input| {
                batch.put(source, channel, &input.header, wire_bytes(input));
            });
            note(taken, TopicId::ClientTap(0));
            let channel = taps.commands.channel;
            let taken = taps.commands.drain(batch, |batch, source, command| {
                batch.put(source, channel, &command.header, wire_bytes(command));
                hops.command(arm, command);
            });
            note(taken, TopicId::ArmCommandTap(0));
        }
        let taken = self.decisions.drain(batch, |batch, source, decision| {
            let bytes = wire_bytes(decision);
            batch.put(source, Channel::Decision, &decision.header, bytes);
            hops.decision(decision);
        });
        note(taken, TopicId::DecisionTap);
        for (arm, taps) in self.arms.iter_mut().enumerate() {
            let channel = taps.status.channel;
            let taken = taps.status.drain(batch, |batch, source, status| {
                batch.put(source, channel, &status.header, wire_bytes(status));
                hops.status(arm, status);
            });
            note(taken, TopicId::ArmStatusTap(0));
        }
        note(self.trace.drain(batch, put_line), TopicId::Trace);
        for tap in &mut self.keyframes {
            let channel = tap.channel;
            tap.drain(batch, |batch, source, keyframe| {
                batch.put(source, channel, &keyframe.header, wire_bytes(keyframe));
            });
        }
        self.put_health(now_ns);
        hops.settle();
        self.batch.hand_over(|message| sink.put(message));
        self.count_missed(sink);
        fill
    }

    fn drain_world(&mut self, hops: &mut Hops) -> f64 {
        let (assembler, names, epoch) = (&mut self.assembler, &self.names, &mut self.epoch);
        let all_sent = &mut self.all_sent;
        let taken = self.world.drain(&mut self.batch, |batch, source, piece| {
            let of = piece.state.generation;
            // Before the first state of a new physics: the time of what follows is set back.
            if epoch.replace(of) != Some(of) {
                batch.put_epoch(source, &piece.header, of);
            }
            batch.put(source, Channel::World, &piece.header, wire_bytes(piece));
            // Once per state, not per piece.
            if piece.piece == 0 {
                hops.state(piece);
            }
            if let Some(state) = assembler.take(piece) {
                put_foxglove(batch, source, names, state, all_sent);
            }
        });
        taken as f64 / TopicId::WorldTap.depth() as f64
    }

    fn put_health(&mut self, now_ns: u64) {
        // Health is published at 100 Hz; the file needs its figures once a second.
        if now_ns < self.health_ns {
            return;
        }
        self.health_ns = now_ns + HEALTH_NS;
        for (process, port) in &mut self.healths {
            if let Some(health) = port.take() {
                let channel = Channel::Health(*process);
                let value = foxglove::health(health).to_string();
                self.batch
                    .put_json(self.rest, channel, &health.header, |out| {
                        out.extend_from_slice(value.as_bytes());
                    });
            }
        }
    }

    fn count_missed(&mut self, sink: &mut Sink) {
        let arms = self.arms.iter();
        let late: u64 = arms
            .map(|arm| arm.clients.late + arm.commands.late + arm.status.late)
            .sum();
        let late = late + self.world.late + self.decisions.late + self.trace.late;
        let late = late + self.keyframes.iter().map(|tap| tap.late).sum::<u64>();
        // All gaps are counted here, so that the sum on the page equals that of the file.
        sink.missed(late - self.missed);
        self.missed = late;
    }
}

fn put_line(batch: &mut Batch, source: usize, line: &TraceLine) {
    let kind = TraceKind::from_code(line.kind);
    let channel = if kind.is_some_and(TraceKind::is_for_people) {
        Channel::Log
    } else {
        Channel::Trace
    };
    batch.put(source, channel, &line.header, wire_bytes(line));
    if let Some(log) = foxglove::log(line) {
        batch.put_json(source, Channel::FoxgloveLog, &line.header, |out| {
            out.extend_from_slice(log.to_string().as_bytes());
        });
    }
}

/// Messages for other tools. A paused cell would repeat the same ones.
fn put_foxglove(
    batch: &mut Batch,
    source: usize,
    names: &foxglove::Names,
    world: &WorldState,
    all_sent: &mut bool,
) {
    if world.has(ipc_types::world::FLAG_PAUSED) {
        return;
    }
    let header = &world.header;
    for arm in 0..world.arms().len() {
        let channel = Channel::JointStates(u8::try_from(arm).unwrap_or(u8::MAX));
        batch.put_json(source, channel, header, |out| {
            foxglove::joint_states(names, world, arm, out);
        });
    }
    if header.tick.is_multiple_of(TRANSFORM_TICKS) {
        for arm in 0..world.arms().len() {
            let channel = Channel::Tracking(u8::try_from(arm).unwrap_or(u8::MAX));
            batch.put_json(source, channel, header, |out| {
                foxglove::tracking_errors(names, world, arm, out);
            });
        }
        batch.put_json(source, Channel::Transforms, header, |out| {
            // The first one names all frames, so that a viewer knows resting objects at once.
            foxglove::transforms(names, world, !std::mem::replace(all_sent, true), out);
        });
    }
}

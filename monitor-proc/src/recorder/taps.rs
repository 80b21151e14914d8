//! Empties the taps.

use cell_bus::{Bus, BusError, Subscriber};
use cell_record::{Channel, Message, foxglove, wire_bytes};
use ipc_types::header::Message as BusMessage;
use ipc_types::topic::{Process, TopicId};
use ipc_types::trace::TraceKind;
use ipc_types::{
    ArmCommand, ArmStatus, Decision, Header, Health, Keyframe, TICK_NS, TraceLine, Wire,
    WorldPiece, WorldState,
};
use serde_json::Value;

use super::hops::Hops;
use super::sink::Sink;

/// Ticks between two `foxglove.FrameTransforms`.
const TRANSFORM_TICKS: u64 = 20;
/// Time between two lines of health (ns of the clock on the wall).
const HEALTH_NS: u64 = 1_000_000_000;

/// One topic and what is missing of it.
struct Tap<T: BusMessage> {
    port: Subscriber<T>,
    channel: Channel,
    late: u64,
}

impl<T: BusMessage> Tap<T> {
    fn new(bus: &Bus, topic: TopicId, channel: Channel) -> Result<Self, BusError> {
        let port = bus.subscriber(topic)?;
        Ok(Self {
            port,
            channel,
            late: 0,
        })
    }

    /// Hands on what waits; says what was missed. How many there were.
    fn drain(&mut self, sink: &mut Sink, mut each: impl FnMut(&mut Sink, &T)) -> usize {
        let taken = self.port.take_all(|message| each(sink, message));
        let late = self.port.counts().late;
        if late > self.late {
            let seq = self.port.current().map_or(0, |m| m.header().seq);
            sink.gap(self.channel, late - self.late, seq);
            self.late = late;
        }
        taken
    }
}

struct Arm {
    commands: Tap<ArmCommand>,
    status: Tap<ArmStatus>,
}

/// All the recorder listens to.
pub(super) struct Taps {
    world: Tap<WorldPiece>,
    arms: Vec<Arm>,
    decisions: Tap<Decision>,
    trace: Tap<TraceLine>,
    keyframes: Vec<Tap<Keyframe>>,
    healths: Vec<(Process, Subscriber<Health>)>,
    names: foxglove::Names,
    whole: Box<WorldState>,
    health_ns: u64,
}

impl Taps {
    pub(super) fn new(bus: &Bus, arms: u8, scene: &Value) -> Result<Self, BusError> {
        let arm = |arm| {
            Ok(Arm {
                commands: Tap::new(bus, TopicId::ArmCommandTap(arm), Channel::Command(arm))?,
                status: Tap::new(bus, TopicId::ArmStatusTap(arm), Channel::Status(arm))?,
            })
        };
        let keepers = (0..arms).map(Process::Controller).chain([Process::Task]);
        let keyframe = |p| Tap::new(bus, TopicId::Keyframe(p), Channel::Keyframe(p));
        let health = |p| Ok((p, bus.subscriber(TopicId::Health(p))?));
        Ok(Self {
            world: Tap::new(bus, TopicId::WorldTap, Channel::World)?,
            arms: (0..arms).map(arm).collect::<Result<_, BusError>>()?,
            decisions: Tap::new(bus, TopicId::DecisionTap, Channel::Decision)?,
            trace: Tap::new(bus, TopicId::Trace, Channel::Trace)?,
            keyframes: keepers.map(keyframe).collect::<Result<_, _>>()?,
            healths: Process::all(arms)
                .into_iter()
                .map(health)
                .collect::<Result<_, BusError>>()?,
            names: foxglove::Names::of(scene),
            whole: Box::new(WorldState::zeroed()),
            health_ns: 0,
        })
    }

    /// Writes down all that waits; how full the fullest buffer was, 0 to 1.
    pub(super) fn drain(&mut self, sink: &mut Sink, hops: &mut Hops, now_ns: u64) -> f64 {
        let mut fill = self.drain_world(sink, hops);
        let mut note = |taken: usize, topic: TopicId| {
            fill = fill.max(taken as f64 / topic.depth() as f64);
        };
        for (arm, taps) in self.arms.iter_mut().enumerate() {
            let channel = taps.commands.channel;
            let taken = taps.commands.drain(sink, |sink, command| {
                sink.put(&wire(channel, &command.header, wire_bytes(command)));
                hops.command(arm, command);
            });
            note(taken, TopicId::ArmCommandTap(0));
        }
        let taken = self.decisions.drain(sink, |sink, decision| {
            let bytes = wire_bytes(decision);
            sink.put(&wire(Channel::Decision, &decision.header, bytes));
            hops.decision(decision);
        });
        note(taken, TopicId::DecisionTap);
        for (arm, taps) in self.arms.iter_mut().enumerate() {
            let channel = taps.status.channel;
            let taken = taps.status.drain(sink, |sink, status| {
                sink.put(&wire(channel, &status.header, wire_bytes(status)));
                hops.status(arm, status);
            });
            note(taken, TopicId::ArmStatusTap(0));
        }
        note(self.trace.drain(sink, put_line), TopicId::Trace);
        for tap in &mut self.keyframes {
            let channel = tap.channel;
            tap.drain(sink, |sink, keyframe| {
                sink.put(&wire(channel, &keyframe.header, wire_bytes(keyframe)));
            });
        }
        self.put_health(sink, now_ns);
        hops.settle();
        fill
    }

    fn drain_world(&mut self, sink: &mut Sink, hops: &mut Hops) -> f64 {
        let (whole, names) = (&mut self.whole, &self.names);
        let taken = self.world.drain(sink, |sink, piece| {
            sink.put(&wire(Channel::World, &piece.header, wire_bytes(piece)));
            if piece.piece == 0 {
                hops.state(piece);
            }
            if piece.all_objects == 1 {
                piece.put(whole);
                if piece.piece + 1 == piece.pieces {
                    put_foxglove(sink, names, whole);
                }
            }
        });
        taken as f64 / TopicId::WorldTap.depth() as f64
    }

    fn put_health(&mut self, sink: &mut Sink, now_ns: u64) {
        if now_ns < self.health_ns {
            return;
        }
        self.health_ns = now_ns + HEALTH_NS;
        for (process, port) in &mut self.healths {
            if let Some(health) = port.take() {
                let value = foxglove::health(health);
                sink.put_json(Channel::Health(*process), health.header.sim_time_ns, &value);
            }
        }
    }
}

fn wire<'a>(channel: Channel, header: &Header, bytes: &'a [u8]) -> Message<'a> {
    Message {
        channel,
        time_ns: header.tick * TICK_NS,
        publish_ns: header.publish_ns,
        seq: header.seq,
        bytes,
    }
}

fn put_line(sink: &mut Sink, line: &TraceLine) {
    let kind = TraceKind::from_code(line.kind);
    let channel = if kind.is_some_and(TraceKind::is_for_people) {
        Channel::Log
    } else {
        Channel::Trace
    };
    sink.put(&wire(channel, &line.header, wire_bytes(line)));
    if let Some(log) = foxglove::log(line) {
        sink.put_json(Channel::FoxgloveLog, line.header.tick * TICK_NS, &log);
    }
}

/// For other tools. A paused cell says the same again and again.
fn put_foxglove(sink: &mut Sink, names: &foxglove::Names, world: &WorldState) {
    if world.has(ipc_types::world::FLAG_PAUSED) {
        return;
    }
    let time_ns = world.header.sim_time_ns;
    for arm in 0..world.arms().len() {
        let channel = Channel::JointStates(u8::try_from(arm).unwrap_or(u8::MAX));
        if let Some(joints) = foxglove::joint_states(names, world, arm) {
            sink.put_json(channel, time_ns, &joints);
        }
    }
    if world.header.tick.is_multiple_of(TRANSFORM_TICKS) {
        let transforms = foxglove::transforms(names, world);
        sink.put_json(Channel::Transforms, time_ns, &transforms);
    }
}

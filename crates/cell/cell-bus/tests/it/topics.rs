//! Messages that a reader of a topic gets or does not get.

use core::mem::offset_of;
use std::os::unix::fs::FileExt as _;

use crate::common;

use common::{RUN, TestRun, decision};
use ipc_types::header::{Header, Message};
use ipc_types::tap::{PIECE_OBJECTS, Pieces};
use ipc_types::topic::{Process, TopicId};
use ipc_types::{Decision, MAX_OBJECTS, TraceLine, Wire, WorldPiece, WorldState};

const TOPIC: TopicId = TopicId::Decision;

#[test]
fn the_newest_message_is_taken_and_the_others_are_counted() {
    let run = TestRun::new();
    let bus = run.join(3);
    let mut publisher = bus.publisher::<Decision>(TOPIC).unwrap();
    let mut subscriber = bus.subscriber::<Decision>(TOPIC).unwrap();
    assert!(subscriber.take().is_none() && subscriber.current().is_none());
    for tick in 1..=5 {
        assert_eq!(publisher.publish_copy(&decision(tick * 10, 4)), Ok(tick));
    }
    let message = subscriber.take().expect("the newest");
    let header = *message.header();
    assert_eq!(
        (header.tick, header.sim_time_ns, header.seq),
        (50, 50_000_000, 5)
    );
    assert_eq!(
        (header.run, header.generation, header.schema),
        (RUN, 3, Decision::SCHEMA)
    );
    assert!(header.publish_ns > 0 && header.publish_ns <= cell_rt::monotonic_ns());
    assert!(subscriber.take().is_none(), "nothing new");
    assert_eq!(
        subscriber.current().unwrap().drops,
        4,
        "the last good one stays"
    );
    // Two decisions are kept: the third pushes the first out.
    for tick in [60, 70, 80] {
        publisher.publish_copy(&decision(tick, 6)).unwrap();
    }
    assert_eq!(subscriber.take().unwrap().header.tick, 80);
    assert_eq!(subscriber.counts().late, 1);
    assert_eq!(subscriber.counts().accepted, 2 + 2);
}

#[test]
fn a_late_joiner_gets_the_last_message_when_the_writer_lets_it_in() {
    let run = TestRun::new();
    let bus = run.join(1);
    let mut publisher = bus.publisher::<Decision>(TOPIC).unwrap();
    publisher.publish_copy(&decision(10, 1)).unwrap();
    publisher.publish_copy(&decision(20, 2)).unwrap();
    let mut late = run.join(1).subscriber::<Decision>(TOPIC).unwrap();
    assert!(late.take().is_none());
    publisher.update_connections();
    assert_eq!(late.take().expect("the history").header().tick, 20);
    assert_eq!(
        late.counts().late,
        0,
        "what was before it joined is not lost"
    );
}

/// Lockstep waits for a recorder until it has the first state, which physics sends before
/// the recorder joins.
#[test]
fn a_recorder_that_joins_late_gets_a_whole_state_and_the_tap_of_a_topic() {
    let run = TestRun::new();
    let bus = run.join(1);
    let mut state = WorldState::zeroed();
    state.object_count = u32::try_from(MAX_OBJECTS).unwrap();
    for object in &mut state.objects {
        object.pose.orientation_wxyz = [1.0, 0.0, 0.0, 0.0];
    }
    let (mut pieces, mut sent) = (Pieces::of(&state, &[]), 0);
    let mut world = bus.publisher::<WorldPiece>(TopicId::WorldTap).unwrap();
    while pieces.has_more() {
        let write = |piece: &mut WorldPiece| {
            pieces.write_next(&state, piece);
        };
        world.publish(write).unwrap();
        sent += 1;
    }
    assert_eq!(sent, MAX_OBJECTS.div_ceil(PIECE_OBJECTS));
    let mut decisions = bus.publisher::<Decision>(TOPIC).unwrap();
    decisions.publish_copy(&decision(10, 1)).unwrap();

    let recorder = run.join(1);
    let mut late = recorder
        .subscriber::<WorldPiece>(TopicId::WorldTap)
        .unwrap();
    let mut tap = recorder
        .subscriber::<Decision>(TopicId::DecisionTap)
        .unwrap();
    world.update_connections();
    decisions.update_connections();
    assert_eq!(late.take_all(|_| {}), sent);
    assert_eq!(tap.take_all(|_| {}), 1);
}

#[test]
fn an_older_start_of_the_writer_is_fenced() {
    let run = TestRun::new();
    let mut old = run.join(1).publisher::<Decision>(TOPIC).unwrap();
    let mut subscriber = run.join(1).subscriber::<Decision>(TOPIC).unwrap();
    old.publish_copy(&decision(10, 1)).unwrap();
    assert_eq!(subscriber.take().unwrap().drops, 1);
    let mut new = run.join(2).publisher::<Decision>(TOPIC).unwrap();
    new.publish_copy(&decision(20, 2)).unwrap();
    old.publish_copy(&decision(20, 99)).unwrap();
    assert_eq!(subscriber.take().unwrap().drops, 2);
    let before = subscriber.counts().fenced;
    old.publish_copy(&decision(30, 99)).unwrap();
    assert!(subscriber.take().is_none());
    assert_eq!(subscriber.current().unwrap().drops, 2);
    assert_eq!(subscriber.counts().fenced, before + 1);
    assert_eq!(subscriber.writer_generation(), 2);
}

#[test]
fn nonsense_is_dropped_with_its_reason_and_the_last_good_one_stays() {
    let run = TestRun::new();
    let bus = run.join(1);
    let mut publisher = bus.publisher::<Decision>(TOPIC).unwrap();
    let mut subscriber = bus.subscriber::<Decision>(TOPIC).unwrap();
    publisher.publish_copy(&decision(10, 1)).unwrap();
    assert!(subscriber.take().is_some());
    let mut bad = decision(20, 2);
    bad.arm_count = 1;
    bad.goals[0].target.position = [f64::NAN; 3];
    publisher.publish_copy(&bad).unwrap();
    assert!(subscriber.take().is_none());
    assert_eq!(subscriber.current().unwrap().drops, 1);
    assert_eq!(subscriber.counts().rejected, 1);
    assert!(subscriber.take_invalid().unwrap().value.is_nan());
    assert!(subscriber.take_invalid().is_none());
}

#[test]
fn a_message_of_another_run_is_rejected() {
    let run = TestRun::new();
    let stranger = cell_bus::Bus::join(&run.site, RUN + 1, 9, "stranger").unwrap();
    let mut publisher = stranger.publisher::<Decision>(TOPIC).unwrap();
    let mut subscriber = run.join(1).subscriber::<Decision>(TOPIC).unwrap();
    publisher.publish_copy(&decision(10, 1)).unwrap();
    assert!(subscriber.take().is_none());
    assert_eq!(subscriber.counts().rejected, 1);
}

#[test]
fn another_type_is_refused_with_both_named() {
    let run = TestRun::new();
    let error = run
        .join(1)
        .subscriber::<WorldState>(TOPIC)
        .unwrap_err()
        .to_string();
    let theirs = format!("Decision#{:016x}", Decision::SCHEMA);
    let ours = format!("WorldState#{:016x}", WorldState::SCHEMA);
    assert!(error.contains(&theirs) && error.contains(&ours), "{error}");
}

#[test]
fn the_trace_is_read_line_by_line_up_to_its_depth() {
    let run = TestRun::new();
    let bus = run.join(1);
    let mut publisher = bus.publisher::<TraceLine>(TopicId::Trace).unwrap();
    let mut subscriber = bus.subscriber::<TraceLine>(TopicId::Trace).unwrap();
    let mut publish = |count: u64| {
        for tick in 0..count {
            publisher
                .publish_copy(&TraceLine {
                    header: Header::caused_by::<TraceLine>(tick),
                    ..TraceLine::zeroed()
                })
                .unwrap();
        }
    };
    publish(1000);
    let mut seqs = Vec::new();
    assert_eq!(subscriber.take_all(|line| seqs.push(line.header.seq)), 1000);
    assert_eq!(seqs, (1..=1000).collect::<Vec<_>>());
    publish(1100);
    assert_eq!(subscriber.take_all(|_| {}), 1024);
    assert_eq!(subscriber.counts().late, 76, "the gap is counted");
}

#[test]
fn a_copy_stays_after_its_writer_is_gone() {
    let run = TestRun::new();
    let bus = run.join(1);
    let mut latest = bus.latest::<Decision>(TOPIC).unwrap();
    let mut publisher = bus.publisher::<Decision>(TOPIC).unwrap();
    publisher.publish_copy(&decision(10, 7)).unwrap();
    assert!(latest.refresh());
    drop(publisher);
    assert!(!latest.refresh());
    assert_eq!(latest.get().unwrap().drops, 7);
}

#[test]
fn a_ring_wakes_a_sleeper_once() {
    let run = TestRun::new();
    let bus = run.join(1);
    let mut sleeper = bus.sleeper(Process::Task).unwrap();
    let mut bell = bus.doorbell(Process::Task).unwrap();
    bell.ring();
    bell.ring();
    assert!(sleeper.wait(std::time::Duration::from_secs(10)));
    assert!(!sleeper.wait(std::time::Duration::from_millis(1)));
    bell.ring();
    assert!(sleeper.drain() && !sleeper.drain());
    assert_eq!(bell.errors(), 0);
}

/// Flips a bit of the message `seq` of a topic in the shared memory of the run.
fn flip(run: &TestRun, seq: u64, field: usize, bit: usize) {
    let mut flipped = 0;
    for entry in std::fs::read_dir("/dev/shm").unwrap().flatten() {
        let name = entry.file_name().into_string().unwrap_or_default();
        if !name.starts_with(&run.site.prefix) {
            continue;
        }
        let mut bytes = std::fs::read(entry.path()).unwrap();
        let start = [Decision::SCHEMA.to_ne_bytes(), RUN.to_ne_bytes()].concat();
        let is_it = |at: &usize| {
            let rest = &bytes[*at..];
            let numbered = rest.get(offset_of!(Header, seq)..).unwrap_or_default();
            rest.starts_with(&start) && numbered.starts_with(&seq.to_ne_bytes())
        };
        let found: Vec<usize> = (0..bytes.len()).step_by(8).filter(is_it).collect();
        for at in found {
            let byte = &mut bytes[at + field + bit / 8];
            *byte ^= 1 << (bit % 8);
            let file = std::fs::File::options().write(true).open(entry.path());
            let place = (at + field + bit / 8) as u64;
            file.unwrap().write_all_at(&[*byte], place).unwrap();
            flipped += 1;
        }
    }
    assert!(flipped > 0, "the message {seq} is in shared memory");
}

#[test]
fn a_flipped_bit_of_a_header_in_shared_memory_costs_one_message_at_most() {
    let fields = [
        (offset_of!(Header, generation), u32::BITS),
        (offset_of!(Header, seq), u64::BITS),
    ];
    for (field, bits) in fields {
        for bit in (0..bits as usize).step_by(5) {
            let run = TestRun::new();
            let mut publisher = run.join(2).publisher::<Decision>(TOPIC).unwrap();
            let mut subscriber = run.join(2).subscriber::<Decision>(TOPIC).unwrap();
            let mut heard = |publisher: &mut cell_bus::Publisher<Decision>, tick| {
                let seq = publisher.publish_copy(&decision(tick, 1)).unwrap();
                if tick == 30 {
                    flip(&run, seq, field, bit);
                }
                subscriber.take().map(|message| message.header.tick)
            };
            assert_eq!(heard(&mut publisher, 10), Some(10));
            assert_eq!(heard(&mut publisher, 20), Some(20));
            let (damaged, next) = (heard(&mut publisher, 30), heard(&mut publisher, 40));
            assert!(
                damaged.is_some() || next.is_some(),
                "field at {field}, bit {bit}"
            );
            assert_eq!(heard(&mut publisher, 50), Some(50), "{field} {bit}");
            assert_eq!(heard(&mut publisher, 60), Some(60), "{field} {bit}");
        }
    }
}

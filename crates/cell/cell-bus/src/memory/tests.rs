//! What happens to messages and turns of a model.

use ipc_types::topic::{Process, TopicId};
use ipc_types::{Decision, WorldState};

use super::{Disturbance, Kept, MemorySite};
use crate::{Bus, Publisher, Subscriber};

const TOPIC: TopicId = TopicId::Decision;

fn open(site: &MemorySite) -> (Publisher<Decision>, Subscriber<Decision>) {
    let bus = Bus::in_memory(site, 1, 1);
    let writer = bus.publisher(TOPIC).unwrap();
    (writer, bus.subscriber(TOPIC).unwrap())
}

/// The ticks that a reader uses of five messages, to the third of which something happens.
fn used(disturbance: Disturbance) -> (Vec<u64>, Subscriber<Decision>) {
    let site = MemorySite::new(1);
    let (mut writer, mut reader) = open(&site);
    let mut observer: Subscriber<Decision> = Bus::in_memory(&site.faithful(), 1, 1)
        .subscriber(TOPIC)
        .unwrap();
    let mut used = Vec::new();
    for tick in 1..=5 {
        if tick == 3 {
            assert!(site.disturb(TOPIC, disturbance));
        }
        writer
            .publish(|message| message.header.tick = tick)
            .unwrap();
        reader.take_all(|message| used.push(message.header.tick));
        assert_eq!(
            observer.take().unwrap().header.tick,
            tick,
            "{disturbance:?}"
        );
    }
    (used, reader)
}

#[test]
fn every_damaged_bit_of_a_message_that_a_reader_can_tell_costs_that_message() {
    for draw in (0..8 * size_of::<Decision>() as u64).step_by(61) {
        let (used, reader) = used(Disturbance::Damage { draw });
        assert_eq!(used, [1, 2, 4, 5], "bit {draw}");
        assert_eq!(reader.counts().rejected, 1, "bit {draw}");
    }
}

#[test]
fn a_message_that_comes_again_is_used_once_and_a_late_one_not_at_all() {
    for (after, count) in [(0, 1), (1, 1), (2, 1), (0, 3), (1, 3)] {
        let (used, reader) = used(Disturbance::Again { after, count });
        assert_eq!(used, [1, 2, 3, 4, 5]);
        let came_again = u64::from(count.min(3 - after));
        assert_eq!(reader.counts().fenced, came_again, "{count} after {after}");
    }
    for after in 1..3 {
        assert_eq!(used(Disturbance::Late { after }).0, [1, 2, 4, 5]);
    }
}

#[test]
fn no_port_has_nothing_to_disturb() {
    let site = MemorySite::new(1);
    let again = Disturbance::Again { after: 0, count: 1 };
    assert!(!site.disturb(TopicId::WorldState, again));
    assert!(!site.disturb(TopicId::ArmStatus(1), again));
    let bus = Bus::in_memory(&site, 1, 1);
    let _reader: Subscriber<WorldState> = bus.subscriber(TopicId::WorldState).unwrap();
    assert!(site.disturb(TopicId::WorldState, again));
}

#[test]
fn what_a_turn_does_after_its_interruption_happens_later_in_its_order() {
    use cell_rt::Clock as _;
    let site = MemorySite::new(1);
    let (mut writer, mut reader) = open(&site);
    let bus = Bus::in_memory(&site, 1, 1);
    let mut bell = bus.doorbell(Process::Task).unwrap();
    let mut sleeper = bus.sleeper(Process::Task).unwrap();
    site.set_now_ns(1_000);
    site.cut_after(1, 500);
    bell.ring();
    assert_eq!(site.now_ns(), 1_000);
    writer.publish(|message| message.header.tick = 7).unwrap();
    bell.ring();
    assert_eq!(site.now_ns(), 1_500, "it continues later");
    let kept = site.end_cut();
    // The message, its copy for a recorder, and the ring.
    assert_eq!(kept.len(), 3);
    assert!(sleeper.drain() && reader.take().is_none());
    kept.into_iter().for_each(Kept::happen);
    assert!(sleeper.drain());
    assert_eq!(reader.take().unwrap().header.tick, 7);
    // The next turn is not interrupted.
    writer.publish(|message| message.header.tick = 8).unwrap();
    assert_eq!(reader.take().unwrap().header.tick, 8);
}

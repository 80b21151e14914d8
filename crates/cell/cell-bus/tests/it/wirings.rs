//! The same rules over iceoryx2 and in the memory of a model.

use cell_bus::{Answered, Bus, MemorySite};
use cell_rt::Clock as _;
use ipc_types::header::Header;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::topic::{Process, TopicId};
use ipc_types::{ArmCommand, Decision, OperatorReply, OperatorRequest, Pose, Wire};

use crate::common::{RUN, TestRun, decision};

const TOPIC: TopicId = TopicId::Decision;

/// Calls `check` with a function that joins a run, for each wiring.
fn over_both(check: impl Fn(&dyn Fn(u32) -> Bus)) {
    let run = TestRun::new();
    check(&|generation| run.join(generation));
    let site = MemorySite::new(1);
    check(&|generation| Bus::in_memory(&site, RUN, generation));
}

#[test]
fn a_late_reader_gets_the_history_when_the_writer_lets_it_in() {
    over_both(|join| {
        let mut publisher = join(1).publisher::<Decision>(TOPIC).unwrap();
        for tick in [10, 20, 30] {
            publisher.publish_copy(&decision(tick, 1)).unwrap();
        }
        let mut late = join(1).subscriber::<Decision>(TOPIC).unwrap();
        let mut tap = join(1)
            .subscriber::<Decision>(TopicId::DecisionTap)
            .unwrap();
        assert!(late.take().is_none());
        publisher.update_connections();
        let mut ticks = Vec::new();
        late.take_all(|decision| ticks.push(decision.header.tick));
        assert_eq!(ticks, [20, 30]);
        assert_eq!(late.counts().late, 0);
        assert_eq!(tap.take_all(|_| {}), 2);
    });
}

#[test]
fn a_reader_that_is_behind_loses_the_oldest() {
    over_both(|join| {
        let mut publisher = join(1).publisher::<Decision>(TOPIC).unwrap();
        let mut reader = join(1).subscriber::<Decision>(TOPIC).unwrap();
        for tick in [10, 20, 30, 40] {
            publisher.publish_copy(&decision(tick, 1)).unwrap();
        }
        assert_eq!(reader.take().unwrap().header.seq, 4);
        assert_eq!(reader.counts().accepted, 2);
        let topic = TopicId::ArmCommand(0);
        let mut publisher = join(1).publisher::<ArmCommand>(topic).unwrap();
        let mut reader = join(1).subscriber::<ArmCommand>(topic).unwrap();
        for tick in 1..=3 {
            let write = |command: &mut ArmCommand| {
                command.header = Header::caused_by::<ArmCommand>(tick);
            };
            publisher.publish(write).unwrap();
        }
        assert_eq!(reader.take_all(|_| {}), topic.depth().min(3));
    });
}

#[test]
fn a_stale_start_of_the_writer_and_an_invalid_message_are_refused() {
    over_both(|join| {
        let mut reader = join(1).subscriber::<Decision>(TOPIC).unwrap();
        let mut old = join(1).publisher::<Decision>(TOPIC).unwrap();
        old.publish_copy(&decision(10, 1)).unwrap();
        assert_eq!(reader.take().unwrap().header.generation, 1);
        let mut new = join(2).publisher::<Decision>(TOPIC).unwrap();
        new.publish_copy(&decision(20, 2)).unwrap();
        new.publish_copy(&decision(30, 2)).unwrap();
        assert_eq!(reader.take().unwrap().drops, 2);
        old.publish_copy(&decision(40, 99)).unwrap();
        assert!(reader.take().is_none());
        assert_eq!(reader.counts().fenced, 1);
        let mut invalid = decision(40, 2);
        invalid.outcome = 99;
        new.publish_copy(&invalid).unwrap();
        assert!(reader.take().is_none());
        assert_eq!(reader.counts().rejected, 1);
        assert!(reader.take_invalid().is_some());
        assert_eq!(reader.current().unwrap().header.tick, 30);
    });
}

#[test]
fn a_message_of_a_writer_that_ended_can_be_read() {
    over_both(|join| {
        let mut reader = join(1).subscriber::<Decision>(TOPIC).unwrap();
        let mut first = join(1).publisher::<Decision>(TOPIC).unwrap();
        reader.take();
        first.publish_copy(&decision(10, 1)).unwrap();
        reader.take();
        first.publish_copy(&decision(20, 1)).unwrap();
        drop(first);
        assert_eq!(reader.take().unwrap().header.tick, 20);
    });
}

#[test]
fn a_bell_counts_rings_before_the_sleep_as_one() {
    over_both(|join| {
        let mut sleeper = join(1).sleeper(Process::Task).unwrap();
        let mut bell = join(1).doorbell(Process::Task).unwrap();
        assert!(!sleeper.drain());
        bell.ring();
        bell.ring();
        assert!(sleeper.wait(core::time::Duration::from_secs(1)));
        assert!(!sleeper.drain());
        assert_eq!(bell.errors(), 0);
    });
}

fn request(count: u32) -> OperatorRequest {
    OperatorRequest {
        action: OperatorAction::Step.code(),
        count,
        pose: Pose::IDENTITY,
        ..OperatorRequest::zeroed()
    }
}

fn reply(request: &OperatorRequest) -> OperatorReply {
    OperatorReply {
        header: Header::caused_by::<OperatorReply>(u64::from(request.count) * 100),
        code: ReplyCode::Accepted.code(),
        ..OperatorReply::zeroed()
    }
}

#[test]
fn a_request_is_answered_withdrawn_or_lost() {
    over_both(|join| {
        let mut client = join(1).operator_client().unwrap();
        assert!(client.send(request(1)).unwrap().is_none(), "no server");
        let mut server = join(1).operator_server().unwrap();
        let pending = client.send(request(2)).unwrap().unwrap();
        assert!(matches!(pending.take(), Answered::Waiting));
        assert_eq!(server.poll(8, reply), 1);
        let Answered::Reply(answer) = pending.take() else {
            panic!("no reply");
        };
        assert_eq!((answer.header.tick, answer.header.run), (200, RUN));
        drop(client.send(request(3)).unwrap());
        assert_eq!(server.poll(8, reply), 0, "withdrawn");
        let pending = client.send(request(4)).unwrap().unwrap();
        drop(server);
        let mut next = join(2).operator_server().unwrap();
        assert_eq!(next.poll(8, reply), 0, "lost with its server");
        assert!(matches!(pending.take(), Answered::Waiting));
    });
}

#[test]
fn messages_in_memory_are_stamped_with_virtual_time() {
    let site = MemorySite::new(1);
    site.set_now_ns(7_000_000);
    let bus = Bus::in_memory(&site, RUN, 3);
    let mut publisher = bus.publisher::<Decision>(TOPIC).unwrap();
    let mut reader = bus.subscriber::<Decision>(TOPIC).unwrap();
    publisher.publish_copy(&decision(10, 1)).unwrap();
    let header = reader.take().unwrap().header;
    assert_eq!((header.publish_ns, header.generation), (7_000_000, 3));
    assert_eq!(site.now_ns(), 7_000_000);
    let other = bus.subscriber::<ArmCommand>(TOPIC);
    assert!(other.is_err(), "another type");
    assert!(bus.subscriber_of::<Decision>("none").is_err());
}

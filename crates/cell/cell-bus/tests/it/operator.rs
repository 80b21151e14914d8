//! Requests and answers between people and physics.

use crate::common;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use cell_bus::{Bus, RequestError, RunSite};
use common::{RUN, TestRun};
use ipc_types::header::Header;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::{OperatorReply, OperatorRequest, Pose, Wire};

const LONG: Duration = Duration::from_secs(20);

/// For threads: ports stay on the thread that opened them.
fn join(site: &RunSite) -> Bus {
    Bus::join(site, RUN, 1, "thread").unwrap()
}

fn request(action: OperatorAction, count: u32) -> OperatorRequest {
    OperatorRequest {
        action: action.code(),
        count,
        pose: Pose::IDENTITY,
        ..OperatorRequest::zeroed()
    }
}

fn reply(tick: u64) -> OperatorReply {
    OperatorReply {
        header: Header::caused_by::<OperatorReply>(tick),
        code: ReplyCode::Accepted.code(),
        ..OperatorReply::zeroed()
    }
}

#[test]
fn every_request_is_answered_with_the_tick_it_took_effect() {
    let run = TestRun::new();
    let site = &run.site;
    let mut client = run.join(1).operator_client().unwrap();
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let answering = scope.spawn(|| {
            let mut server = join(site).operator_server().unwrap();
            let mut seen = Vec::new();
            while !stop.load(Ordering::Relaxed) {
                server.poll(8, |request| {
                    seen.push(request.count);
                    reply(u64::from(request.count) * 100)
                });
                std::thread::yield_now();
            }
            seen
        });
        for count in 1..=20 {
            let answer = client
                .request(request(OperatorAction::Step, count), LONG)
                .unwrap();
            assert_eq!(answer.header.tick, u64::from(count) * 100);
        }
        stop.store(true, Ordering::Relaxed);
        assert_eq!(
            answering.join().unwrap(),
            (1..=20).collect::<Vec<_>>(),
            "each exactly once"
        );
    });
}

#[test]
fn a_request_nobody_hears_says_so() {
    let run = TestRun::new();
    let mut client = run.join(1).operator_client().unwrap();
    let error = client.request(request(OperatorAction::Pause, 0), Duration::from_millis(20));
    assert_eq!(error.unwrap_err(), RequestError::NoAnswer(20));
}

#[test]
fn a_request_given_up_is_not_carried_out_later() {
    let run = TestRun::new();
    let mut server = run.join(1).operator_server().unwrap();
    let mut client = run.join(1).operator_client().unwrap();
    let error = client.request(request(OperatorAction::Reset, 0), Duration::from_millis(20));
    assert!(error.is_err());
    assert_eq!(server.poll(8, |_| reply(1)), 0);
}

#[test]
fn a_request_waits_for_physics_to_come_up() {
    let run = TestRun::new();
    let site = &run.site;
    std::thread::scope(|scope| {
        let asking = scope.spawn(|| {
            let mut client = join(site).operator_client().unwrap();
            client.request(request(OperatorAction::Pause, 0), LONG)
        });
        let mut server = run.join(1).operator_server().unwrap();
        while server.poll(8, |_| reply(5)) == 0 {
            std::thread::yield_now();
        }
        assert_eq!(asking.join().unwrap().unwrap().header.tick, 5);
    });
}

#[test]
fn nonsense_is_refused_before_it_is_sent() {
    let run = TestRun::new();
    let mut client = run.join(1).operator_client().unwrap();
    let mut bad = request(OperatorAction::Drag, 0);
    bad.pose.position[1] = f64::INFINITY;
    assert!(matches!(
        client.request(bad, LONG),
        Err(RequestError::Invalid(_))
    ));
}

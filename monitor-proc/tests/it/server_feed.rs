//! Messages to a page, and its commands.

use crate::server_bench;

use ipc_types::trace::{TraceEvent, TraceKind};
use ipc_types::{Text, TraceLine, Wire};
use monitor_proc::feed::broadcast::RecordedSpan;
use monitor_proc::page::command::Order;
use serde_json::json;
use server_bench::{Bench, OPERATOR, VIEWER, ask, closing, frame, text};

fn line(kind: TraceKind, to: u32, words: &str) -> TraceLine {
    let mut line = TraceLine::zeroed();
    (line.kind, line.to) = (kind.code(), to);
    line.text = Text::new(words);
    line
}

#[test]
fn a_late_joiner_is_told_everything_and_then_what_is_new() {
    let bench = Bench::start();
    let node = "tree\u{1f}root\u{1f}selector\u{1f}<b>Root\u{1f}";
    bench.broadcast.take_line(&line(TraceKind::Node, 1, node));
    bench
        .broadcast
        .take_line(&line(TraceKind::Statuses, 0, "R"));
    bench
        .broadcast
        .take_line(&line(TraceKind::Key, 0, "local.cube=red"));
    let mut drop = line(TraceKind::Log, 0, "[drop] red_cube left the gripper");
    drop.event = TraceEvent::Drop.code();
    bench.broadcast.take_line(&drop);
    bench.broadcast.publish_trace();
    bench
        .broadcast
        .publish_status(&json!({ "t": "status", "rt": "fifo" }));
    bench.broadcast.publish_recorded_span(&RecordedSpan {
        from_s: 0.5,
        to_s: 1.5,
        epochs: Vec::new(),
    });
    bench.broadcast.frame(b"first".to_vec());
    let mut late = bench.socket(VIEWER).unwrap();
    let hello = text(&mut late, "hello");
    assert_eq!(
        (&hello["live"], &hello["run"]["demo"]),
        (&json!(true), &json!("d"))
    );
    let scene = text(&mut late, "scene");
    assert_eq!(
        scene["scene"]["objects"][0]["name"],
        "<script>alert(1)</script>"
    );
    assert_eq!(
        text(&mut late, "graphs")["graphs"][0]["nodes"][0]["name"],
        "<b>Root"
    );
    assert_eq!(text(&mut late, "statuses")["letters"], "R");
    assert_eq!(text(&mut late, "keys")["values"]["local.cube"], "red");
    assert_eq!(text(&mut late, "log")["lines"][0]["mark"], "drop");
    assert_eq!(text(&mut late, "status")["rt"], "fifo");
    assert_eq!(text(&mut late, "timeline")["to_s"], 1.5);
    assert_eq!(frame(&mut late), b"first");
    bench
        .broadcast
        .take_line(&line(TraceKind::Statuses, 0, "S"));
    bench.broadcast.publish_trace();
    assert_eq!(text(&mut late, "statuses")["letters"], "S");
    late.send(tungstenite::Message::text(r#"{"id": 1, "do": "again"}"#))
        .unwrap();
    assert_eq!(text(&mut late, "graphs")["graphs"][0]["name"], "tree");
    assert_eq!(
        text(&mut late, "log")["lines"][0]["text"],
        "[drop] red_cube left the gripper"
    );
}

#[test]
fn a_slow_reader_gets_the_newest_frame_and_holds_nobody_up() {
    let bench = Bench::start();
    let mut slow = bench.socket(VIEWER).unwrap();
    text(&mut slow, "hello");
    // Far more than the sockets' buffers hold, while no client reads.
    let frames = 4000_u32;
    for number in 1..=frames {
        let mut bytes = vec![0; 16 << 10];
        bytes[..4].copy_from_slice(&number.to_le_bytes());
        bench.broadcast.frame(bytes);
        std::thread::sleep(std::time::Duration::from_micros(200));
    }
    let number = |frame: &[u8]| u32::from_le_bytes(frame[..4].try_into().unwrap());
    let mut seen = Vec::new();
    while seen.last() != Some(&frames) {
        seen.push(number(&frame(&mut slow)));
    }
    assert!(seen.windows(2).all(|pair| pair[0] < pair[1]), "in order");
    assert!(
        seen.len() < frames as usize,
        "{} frames were kept for it",
        seen.len()
    );
}

/// After an interruption of ten seconds a page showed the frame of before with the lanes of now.
#[test]
fn a_page_that_joins_is_not_shown_a_frame_of_before() {
    let bench = Bench::start();
    bench.broadcast.frame(b"before".to_vec());
    bench.broadcast.forget_frame();
    let mut page = bench.socket(VIEWER).unwrap();
    text(&mut page, "hello");
    bench.broadcast.frame(b"now".to_vec());
    assert_eq!(frame(&mut page), b"now");
}

/// The clock of a page that read slowly was seconds behind its log: messages came first, frames
/// when no message waited.
#[test]
fn a_slow_reader_gets_a_frame_after_each_message() {
    let bench = Bench::start();
    let mut slow = bench.socket(VIEWER).unwrap();
    text(&mut slow, "hello");
    // More than the sockets' buffers hold, and fewer messages than are kept for a page.
    let count = 400_u32;
    let padding = "x".repeat(32 << 10);
    for number in 1..=count {
        bench.broadcast.frame(number.to_le_bytes().to_vec());
        let status = json!({ "t": "status", "number": number, "padding": padding });
        bench.broadcast.publish_status(&status);
    }
    let (mut message, mut frame) = (0, 0);
    while message < u64::from(count) {
        match slow.read().unwrap() {
            tungstenite::Message::Binary(bytes) => {
                frame = u64::from(u32::from_le_bytes(bytes[..4].try_into().unwrap()));
            }
            tungstenite::Message::Text(text) => {
                let text: serde_json::Value = serde_json::from_str(text.as_str()).unwrap();
                if text["t"] == "status" {
                    assert!(frame >= message, "frame {frame} after message {message}");
                    message = text["number"].as_u64().unwrap();
                }
            }
            _ => {}
        }
    }
}

#[test]
fn hostile_commands_are_answered_with_the_field_that_is_wrong() {
    let bench = Bench::start();
    let mut page = bench.socket(OPERATOR).unwrap();
    let huge = "9".repeat(400);
    let deep = "[".repeat(20_000);
    let cases: Vec<(String, &str)> = vec![
        (r#"{"id": 1}"#.to_owned(), "'do'"),
        (r#"{"do": "pause"}"#.to_owned(), "'id'"),
        (r#"{"id": -1, "do": "pause"}"#.to_owned(), "'id'"),
        (r#"{"id": "1", "do": "pause"}"#.to_owned(), "'id'"),
        (r#"{"id": 1, "do": "explode"}"#.to_owned(), "'do'"),
        (r#"{"id": 1, "do": ["pause"]}"#.to_owned(), "'do'"),
        (r#"{"id": 1, "do": "step", "count": 0}"#.to_owned(), "'count'"),
        (r#"{"id": 1, "do": "step", "count": 1.5}"#.to_owned(), "'count'"),
        (r#"{"id": 1, "do": "step", "count": 4294967297}"#.to_owned(), "'count'"),
        (r#"{"id": 1, "do": "drag", "to": [0, 0, 0]}"#.to_owned(), "'object'"),
        (r#"{"id": 1, "do": "drag", "object": "no_cube", "to": [0, 0, 0]}"#.to_owned(), "'object'"),
        (r#"{"id": 1, "do": "drag", "object": "red_cube"}"#.to_owned(), "'to'"),
        (r#"{"id": 1, "do": "drag", "object": "red_cube", "to": [0, 0]}"#.to_owned(), "'to'"),
        (r#"{"id": 1, "do": "drag", "object": "red_cube", "to": [0, 0, "NaN"]}"#.to_owned(), "'to'"),
        (r#"{"id": 1, "do": "drag", "object": "red_cube", "to": [0, 0, null]}"#.to_owned(), "'to'"),
        (r#"{"id": 1, "do": "drag", "object": "red_cube", "to": [0, 0, 1e300]}"#.to_owned(), "'to'"),
        (r#"{"id": 1, "do": "drag", "object": "red_cube", "to": [0, 0, 1], "for_s": -1}"#.to_owned(), "'for_s'"),
        (r#"{"id": 1, "do": "target", "position": [0, 0, 1], "orientation_wxyz": [0, 0, 0, 0]}"#.to_owned(), "'orientation_wxyz'"),
        (r#"{"id": 1, "do": "target", "arm": 5, "position": [0, 0, 1], "orientation_wxyz": [1, 0, 0, 0]}"#.to_owned(), "'arm'"),
        (r#"{"id": 1, "do": "gripper", "to": "squeeze"}"#.to_owned(), "'to'"),
        (r#"{"id": 1, "do": "add_bin", "flipped": "yes"}"#.to_owned(), "'flipped'"),
        (r#"{"id": 1, "do": "restart", "process": "init"}"#.to_owned(), "'process'"),
        (r#"{"id": 1, "do": "restart", "process": "task", "policy": "../../x"}"#.to_owned(), "'policy'"),
        (r#"{"id": 1, "do": "load", "demo": "a b", "seed": 1, "speed": "1"}"#.to_owned(), "'demo'"),
        (r#"{"id": 1, "do": "load", "demo": "d", "seed": 1, "speed": "warp"}"#.to_owned(), "'speed'"),
        (r#"{"id": 1, "do": "load", "demo": "d", "seed": -1, "speed": "1"}"#.to_owned(), "'seed'"),
        (r#"{"id": 1, "do": "record", "what": "last", "seconds": 0}"#.to_owned(), "'seconds'"),
        (r#"{"id": 1, "do": "seek", "time_s": -5}"#.to_owned(), "'time_s'"),
        ("[]".to_owned(), "object"),
        ("null".to_owned(), "object"),
        ("pause".to_owned(), "not JSON"),
        (String::new(), "not JSON"),
        (deep, "not JSON"),
        (format!(r#"{{"id": 1, "do": "seek", "time_s": {huge}}}"#), "not JSON"),
    ];
    for (command, named) in cases {
        let ack = ask(&mut page, &command);
        let message = ack["message"].as_str().unwrap();
        let shown: String = command.chars().take(120).collect();
        assert!(
            !ack["ok"].as_bool().unwrap() && message.contains(named),
            "{shown}: {message}"
        );
        assert!(message.len() < 400, "{message}");
    }
    assert!(bench.queue.0.lock().unwrap().is_empty());
}

#[test]
fn good_commands_arrive_as_they_were_meant() {
    let bench = Bench::start();
    let mut page = bench.socket(OPERATOR).unwrap();
    let commands = [
        r#"{"id": 1, "do": "drag", "object": "<script>alert(1)</script>", "to": [0.5, -0.2, 0.1], "for_s": 0.5}"#,
        r#"{"id": 2, "do": "target", "arm": 0, "position": [0.4, 0, 0.5], "orientation_wxyz": [0, 1.0005, 0, 0]}"#,
        r#"{"id": 3, "do": "gripper", "arm": 0, "to": "close"}"#,
        r#"{"id": 4, "do": "restart", "process": "task", "policy": null}"#,
        r#"{"id": 5, "do": "load", "demo": "franka-stack", "seed": 3, "speed": "max"}"#,
    ];
    for (command, id) in commands.iter().zip(1_u64..) {
        let ack = ask(&mut page, command);
        assert_eq!(
            (ack["id"].as_u64(), ack["ok"].as_bool()),
            (Some(id), Some(true)),
            "{ack}"
        );
    }
    let taken = bench.queue.0.lock().unwrap();
    let Order::Operate(drag) = &taken[0].0 else {
        panic!("{:?}", taken[0])
    };
    assert_eq!(
        (drag.object, drag.pose.position, drag.seconds),
        (1, [0.5, -0.2, 0.1], 0.5)
    );
    let Order::Operate(target) = &taken[1].0 else {
        panic!("{:?}", taken[1])
    };
    assert_eq!(target.pose.orientation_wxyz, [0.0, 1.0, 0.0, 0.0]);
    let Order::Operate(gripper) = &taken[2].0 else {
        panic!("{:?}", taken[2])
    };
    assert_eq!((gripper.count, taken[2].1.as_str()), (2, "gripper close"));
    let restart = json!({ "ask": "restart", "process": "task", "policy": null });
    assert_eq!(taken[3].0, Order::Launch(restart));
    let Order::Launch(load) = &taken[4].0 else {
        panic!("{:?}", taken[4])
    };
    assert_eq!(
        (&load["demo"], &load["seed"]),
        (&json!("franka-stack"), &json!(3))
    );
}

#[test]
fn one_page_looks_back_while_another_sees_what_is_live() {
    let bench = Bench::start();
    let (mut back, mut live) = (bench.socket(VIEWER).unwrap(), bench.socket(VIEWER).unwrap());
    bench.broadcast.frame(b"live 1".to_vec());
    assert_eq!(
        (frame(&mut back), frame(&mut live)),
        (b"live 1".to_vec(), b"live 1".to_vec())
    );
    back.send(tungstenite::Message::text(
        r#"{"id": 1, "do": "seek", "time_s": 2.5}"#,
    ))
    .unwrap();
    // The present is shown until the past is available; its messages follow with it.
    assert_eq!(text(&mut back, "past")["time_s"], 2.5);
    assert_eq!(frame(&mut back), b"past 2.5");
    bench.broadcast.frame(b"live 2".to_vec());
    assert_eq!(frame(&mut live), b"live 2");
    let ack = ask(&mut back, r#"{"id": 2, "do": "seek", "time_s": 99}"#);
    assert!(!ack["ok"].as_bool().unwrap());
    back.send(tungstenite::Message::text(
        r#"{"id": 3, "do": "seek", "time_s": null}"#,
    ))
    .unwrap();
    text(&mut back, "now");
    assert_eq!(text(&mut back, "log")["all"], true);
    assert_eq!(frame(&mut back), b"live 2");
}

#[test]
fn whoever_leaves_says_why() {
    let bench = Bench::start();
    let mut page = bench.socket(VIEWER).unwrap();
    text(&mut page, "hello");
    bench.broadcast.close("restart");
    bench.broadcast.close("end");
    assert_eq!(closing(&mut page).as_deref(), Some("restart"));
}

//! A policy behind a socket in a cell of four processes.

use std::net::TcpListener;

use robocell_tests::cell::base;
use robocell_tests::program::{finish, robocell};
use serde_json::Value;
use tungstenite::Message;

/// The address of a server that sends the arm to one point, in eight equal actions.
fn server() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("ws://{}", listener.local_addr().unwrap());
    let number = |value: f64| [&[0xcb][..], &value.to_be_bytes()].concat();
    let row = [
        vec![0x94],
        number(0.45),
        number(0.2),
        number(0.3),
        number(0.0),
    ]
    .concat();
    let answer = [b"\x81\xa7actions\x98".to_vec(), row.repeat(8)].concat();
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let answer = answer.clone();
            std::thread::spawn(move || {
                let mut socket = tungstenite::accept(stream).unwrap();
                socket.send(Message::binary(b"\x80".to_vec())).unwrap();
                while socket.read().is_ok_and(|message| message.is_binary()) {
                    socket.send(Message::binary(answer.clone())).unwrap();
                }
            });
        }
    });
    address
}

fn run(words: &[&str]) -> Value {
    let base = base();
    let options = [
        "--seed",
        "1",
        "--timeout",
        "1.5",
        "--latency-ms",
        "100",
        "--json",
    ];
    let words = [
        &["run", "cube", "--headless", "--speed", "max"],
        words,
        &options,
    ]
    .concat();
    let said = finish(robocell(base.path(), &words));
    assert_eq!(
        said.code, 5,
        "the run ends at its time limit: {}",
        said.stderr
    );
    serde_json::from_str(said.stdout.lines().last().unwrap()).unwrap()
}

#[test]
fn a_killed_task_asks_its_server_again_and_the_arm_moves_as_without() {
    let address = server();
    let dir = tempfile::tempdir().unwrap();
    let script = dir.path().join("kill.jsonl");
    let line = r#"{"at_s": 0.62, "do": "kill", "process": "task"}"#;
    std::fs::write(&script, line).unwrap();
    let one = run(&["--policy", &address, "--one-process"]);
    let four = run(&["--policy", &address]);
    let killed = run(&[
        "--policy",
        &address,
        "--script",
        &script.display().to_string(),
    ]);
    assert_eq!(killed["task_restarts"], 1);
    for other in [four, killed] {
        assert_eq!(other["state_hash"], one["state_hash"]);
    }
}

#[test]
fn an_evaluation_that_reached_no_server_is_not_a_result() {
    let (reached, base) = (server(), base());
    let rows = base.path().join("rows.jsonl");
    let rows = rows.display().to_string();
    // A port that is closed again.
    let closed = TcpListener::bind("127.0.0.1:0").unwrap();
    let none = format!("ws://{}", closed.local_addr().unwrap());
    drop(closed);
    let eval = |address: &str, more: &[&str]| {
        let words = [
            "eval",
            "cube",
            "--seeds",
            "1..2",
            "--timeout",
            "0.5",
            "--policy",
            address,
        ];
        finish(robocell(base.path(), &[&words[..], more].concat()))
    };
    // The third time all rows are there.
    let cases: [&[&str]; 3] = [&[], &["--out", &rows], &["--out", &rows]];
    for more in cases {
        let said = eval(&none, more);
        assert_eq!(said.code, 3, "{more:?}: {}{}", said.stdout, said.stderr);
        let wanted = format!("no episode reached the policy server {none}");
        assert!(said.stderr.contains(&wanted), "{}", said.stderr);
    }
    let said = eval(&reached, &[]);
    assert_eq!(said.code, 0, "{}{}", said.stdout, said.stderr);
}

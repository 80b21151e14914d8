//! Answers that are kept, and used in place of a server.

use std::sync::atomic::{AtomicU64, Ordering};

use cell_model::cells::sweep::Sweep;
use cell_model::runs::policy_server::PolicyServer;
use cell_sim::eval::{Plan, evaluate, template};
use cell_sim::{Program, episodes};

use crate::episodes::{cube, program, put_it_on_the_mark};
use crate::server::{Reply, openpi, rows};

fn server_with(keep: Option<&std::path::Path>, answers: Option<&std::path::Path>) -> PolicyServer {
    PolicyServer {
        keep: keep.map(Into::into),
        answers: answers.map(Into::into),
        ..PolicyServer::default()
    }
}

#[test]
fn kept_answers_give_the_same_episode_without_a_server() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("deep/one.answers.jsonl");
    let server = openpi(|_, seen| Reply::Bytes(rows(&put_it_on_the_mark(seen))));
    let one = cube(&server.address, server_with(Some(&file), None), 60.0);
    let asked = server.requests.load(Ordering::Relaxed);
    let other = cube(&server.address, server_with(None, Some(&file)), 60.0);
    assert_eq!(server.requests.load(Ordering::Relaxed), asked);
    assert_eq!(one.state_hash, other.state_hash);
    assert_eq!(one.policy_server, other.policy_server);
    // Of another scene.
    let text = std::fs::read_to_string(&file).unwrap();
    let (before, after) = text.split_once("\"request\":\"").unwrap();
    let changed = format!("{before}\"request\":\"{}{}", "0".repeat(16), &after[16..]);
    std::fs::write(&file, changed).unwrap();
    let other = cube(&server.address, server_with(None, Some(&file)), 60.0);
    assert_eq!(other.reason.as_deref(), Some("policy_answer_not_kept"));
    let message = other.message.unwrap();
    assert!(
        message.contains("request 1 has other observations"),
        "{message}"
    );
    std::fs::write(&file, "{}\n").unwrap();
    let other = cube(&server.address, server_with(None, Some(&file)), 60.0);
    let message = other.message.unwrap();
    assert!(
        message.contains("one.answers.jsonl: line 1: missing field"),
        "{message}"
    );
}

/// Two evaluations of one seed; the warnings of both.
fn warnings(program: &Program, address: &str, keep: &std::path::Path) -> Vec<String> {
    let mut spec = template("cube", address);
    (spec.policy_server, spec.time_limit_s) = (Some(server_with(Some(keep), None)), Some(1.0));
    let plan = Plan {
        cases: episodes::cases(program, &spec, Sweep::default()).unwrap(),
        spec,
        seeds: 1..=1,
        jobs: 1,
        record: None,
    };
    let all = std::sync::Mutex::new(Vec::new());
    evaluate(program, &plan, |ended| {
        all.lock().unwrap().extend(ended.warnings.clone());
    })
    .unwrap();
    all.into_inner().unwrap()
}

#[test]
fn a_server_that_answers_one_request_in_two_ways_is_reported() {
    let dir = tempfile::tempdir().unwrap();
    let calls = AtomicU64::new(0);
    let server = openpi(move |_, _| {
        let call = calls.fetch_add(1, Ordering::Relaxed);
        Reply::Bytes(rows(&[vec![0.4, 0.0, 0.4 + 1.0e-3 * call as f32, 0.0]]))
    });
    // A new program each time: the file is all that is known of the first evaluation.
    assert_eq!(
        warnings(&program(), &server.address, dir.path()),
        Vec::<String>::new()
    );
    let said = warnings(&program(), &server.address, dir.path());
    assert!(
        said.iter().any(|line| line.contains("in two ways")),
        "{said:?}"
    );
}

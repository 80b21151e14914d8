//! Access to the server of the page, and its limits.

use crate::server_bench;

use std::io::Read;

use cell_run::secrets::PageSecrets;
use monitor_proc::web::files::Files;
use server_bench::{Bench, OPERATOR, VIEWER, ask, closing, status, text};
use tungstenite::Message;

fn bearer(token: &str) -> String {
    format!("Authorization: Bearer {token}\r\n")
}

fn built_page() -> (tempfile::TempDir, Files) {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(dir.path().join("dist/assets")).unwrap();
    std::fs::write(dir.path().join("secret.txt"), "secret").unwrap();
    std::fs::write(dir.path().join("dist/index.html"), "the page").unwrap();
    std::fs::write(dir.path().join("dist/assets/main-1.js"), "1").unwrap();
    std::fs::write(dir.path().join("dist/assets/main-1.js.gz"), "packed").unwrap();
    std::os::unix::fs::symlink(dir.path(), dir.path().join("dist/up")).unwrap();
    std::os::unix::fs::symlink("../secret.txt", dir.path().join("dist/link.txt")).unwrap();
    let files = Files::page(Some(&dir.path().join("dist")), "");
    (dir, files)
}

#[test]
fn a_name_that_was_given_is_answered_and_no_other() {
    let bench = Bench::with_host("lab-3.local");
    let port = bench.address.port();
    for (host, expected) in [
        (format!("lab-3.local:{port}"), 200),
        (format!("LAB-3.local:{port}"), 200),
        ("lab-3.local".to_owned(), 403),
        (format!("lab-4.local:{port}"), 403),
    ] {
        let head = format!(
            "GET /api/scene HTTP/1.1\r\nHost: {host}\r\n{}",
            bearer(OPERATOR)
        );
        assert_eq!(status(&bench.raw(&head, "")), expected, "{host}");
    }
}

#[test]
fn another_host_name_is_refused_before_tokens_and_files() {
    let bench = Bench::start();
    for host in ["evil.example", "localhost:1", "127.0.0.1.evil.example:80"] {
        for path in [
            "/",
            "/ws",
            "/api/scene",
            "/nothing",
            &format!("/?token={OPERATOR}"),
        ] {
            let head = format!(
                "GET {path} HTTP/1.1\r\nHost: {host}\r\n{}",
                bearer(OPERATOR)
            );
            let answer = bench.raw(&head, "");
            assert_eq!(status(&answer), 403, "{host} {path}");
            assert!(!answer.contains("set-cookie"));
        }
    }
    assert_eq!(
        status(&bench.raw("GET / HTTP/1.0\r\n", "")),
        403,
        "no host at all"
    );
    assert_eq!(status(&bench.get("/api/scene", &bearer(OPERATOR))), 200);
}

#[test]
fn a_token_is_exchanged_for_a_strict_cookie_which_opens_the_page() {
    let (_dir, files) = built_page();
    let bench = Bench::with(files, true);
    assert_eq!(status(&bench.get("/", "")), 401);
    assert_eq!(status(&bench.get("/assets/main-1.js", "")), 401);
    assert_eq!(status(&bench.get("/?token=wrong", "")), 403);
    let answer = bench.get(&format!("/?token={OPERATOR}"), "");
    assert_eq!(status(&answer), 303);
    assert!(answer.contains("\r\nlocation: /\r\n"));
    assert!(answer.contains("; Path=/; HttpOnly; SameSite=Strict\r\n"));
    assert!(!answer.contains(OPERATOR), "a cookie is not the token");
    let page = bench.get("/", &bench.cookie(OPERATOR));
    assert!(page.ends_with("the page"), "{page}");
    for line in [
        "content-security-policy: default-src 'self';",
        "frame-ancestors 'none'",
        "x-content-type-options: nosniff",
        "referrer-policy: no-referrer",
        "cache-control: no-store",
    ] {
        assert!(page.contains(line), "{line}");
    }
    let script = bench.get("/assets/main-1.js", &bench.cookie(VIEWER));
    assert!(script.contains("content-type: text/javascript") && script.contains("immutable"));
}

#[test]
fn a_file_is_sent_compressed_to_who_reads_it() {
    let (_dir, files) = built_page();
    let bench = Bench::with(files, true);
    let get = |path: &str, accepted: &str| {
        let accept = format!("{}Accept-Encoding: {accepted}\r\n", bench.cookie(VIEWER));
        bench.get(path, &accept)
    };
    for accepted in ["gzip", "br, GZIP;q=0.5", "deflate,gzip;q=1.0"] {
        let script = get("/assets/main-1.js", accepted);
        assert!(script.ends_with("\r\n\r\npacked"), "{accepted}: {script}");
        assert!(script.contains("content-encoding: gzip\r\n"));
        assert!(script.contains("vary: accept-encoding\r\n"));
        assert!(script.contains("content-type: text/javascript") && script.contains("immutable"));
    }
    for accepted in ["", "br", "gzip;q=0", "gzip;q=0.0"] {
        let script = get("/assets/main-1.js", accepted);
        assert!(script.ends_with("\r\n\r\n1"), "{accepted}: {script}");
        assert!(!script.contains("content-encoding"));
    }
    // A file without a gzip beside it.
    assert!(get("/", "gzip").ends_with("the page"));
}

#[test]
fn no_path_leads_out_of_the_page() {
    let (_dir, files) = built_page();
    let bench = Bench::with(files, true);
    let cookie = bench.cookie(OPERATOR);
    for path in [
        "/../secret.txt",
        "/..%2fsecret.txt",
        "/%2e%2e/secret.txt",
        "/%2e%2e%2fsecret.txt",
        "/..%5csecret.txt",
        "/assets/../../secret.txt",
        "/assets/..%2f..%2fsecret.txt",
        "//secret.txt",
        "/./index.html",
        "/up/secret.txt",
        "/link.txt",
        "/index.html%00.js",
        "/meshes/..%2f..%2fsecret.txt",
        "/meshes/../index.html",
        "/etc/passwd",
        "/%",
    ] {
        let answer = bench.get(path, &cookie);
        assert!(matches!(status(&answer), 400 | 404), "{path}: {answer}");
        assert!(
            !answer.contains("secret\r\n") && !answer.ends_with("secret"),
            "{path}"
        );
    }
    assert_eq!(
        status(&bench.raw(
            &format!("DELETE / HTTP/1.1\r\nHost: {}\r\n", bench.host()),
            ""
        )),
        405
    );
}

#[test]
fn without_a_built_page_it_is_said_how_to_get_one() {
    let bench = Bench::start();
    let page = bench.get("/", &bench.cookie(VIEWER));
    assert_eq!(status(&page), 200);
    assert!(page.contains("id=\"hint\">install &lt;Node&gt;"), "{page}");
}

#[test]
fn a_page_of_another_origin_changes_nothing_and_opens_nothing() {
    let bench = Bench::start();
    let body = format!("{{\"token\": \"{OPERATOR}\"}}");
    let ours = format!("Origin: http://{}\r\n", bench.host());
    for origin in ["http://evil.example", "http://localhost:1", "null", ""] {
        let line = format!("Origin: {origin}\r\n");
        assert_eq!(
            status(&bench.post("/api/token", &line, &body)),
            403,
            "{origin}"
        );
        let (cookie, token) = (bench.cookie(OPERATOR), format!("Bearer {OPERATOR}"));
        let cookie = cookie.trim()["Cookie: ".len()..].to_owned();
        let refused = bench.upgrade(&[("origin", origin), ("cookie", &cookie)]);
        assert_eq!(refused.err(), Some(403), "{origin}");
        let refused = bench.upgrade(&[("origin", origin), ("authorization", &token)]);
        assert_eq!(refused.err(), Some(403), "{origin} with a token");
    }
    assert_eq!(
        status(&bench.post("/api/token", "", &body)),
        403,
        "no origin"
    );
    assert_eq!(
        status(&bench.post("/api/token", &bearer(VIEWER), &body)),
        204,
        "a program"
    );
    assert_eq!(status(&bench.post("/api/token", &ours, &body)), 204);
    assert_eq!(
        status(&bench.post("/api/token", &ours, "{\"token\": \"x\"}")),
        403
    );
    assert_eq!(status(&bench.post("/api/token", &ours, "token")), 400);
    assert_eq!(
        status(&bench.post("/api/token", &ours, &"x".repeat(100_000))),
        400
    );
    assert_eq!(
        status(&bench.get("/api/token", &ours)),
        405,
        "no GET has an effect"
    );
    let refused = bench.upgrade(&[("origin", &format!("http://{}", bench.host()))]);
    assert_eq!(refused.err(), Some(401), "our page without a cookie");
    assert_eq!(bench.socket("wrong").err(), Some(403));
}

#[test]
fn a_viewer_looks_and_becomes_an_operator_with_the_token() {
    let bench = Bench::start();
    let mut viewer = bench.socket(VIEWER).unwrap();
    assert_eq!(text(&mut viewer, "hello")["role"], "viewer");
    let ack = ask(&mut viewer, r#"{"id": 3, "do": "pause"}"#);
    assert_eq!(
        (ack["id"].as_u64(), ack["ok"].as_bool()),
        (Some(3), Some(false))
    );
    assert!(
        ack["message"]
            .as_str()
            .unwrap()
            .contains("operator's token")
    );
    assert!(
        ask(&mut viewer, r#"{"id": 4, "do": "again"}"#)["ok"]
            .as_bool()
            .unwrap()
    );
    assert!(bench.queue.0.lock().unwrap().is_empty());
    let ours = format!(
        "Origin: http://{}\r\n{}",
        bench.host(),
        bench.cookie(VIEWER)
    );
    let answer = bench.post(
        "/api/token",
        &ours,
        &format!("{{\"token\": \"{OPERATOR}\"}}"),
    );
    let cookie = answer
        .lines()
        .find_map(|l| l.strip_prefix("set-cookie: "))
        .unwrap();
    let cookie = cookie.split(';').next().unwrap();
    let origin = format!("http://{}", bench.host());
    let mut page = bench
        .upgrade(&[("origin", &origin), ("cookie", cookie)])
        .unwrap();
    assert_eq!(text(&mut page, "hello")["role"], "operator");
    let ack = ask(&mut page, r#"{"id": 5, "do": "pause"}"#);
    assert_eq!(
        (ack["ok"].as_bool(), ack["tick"].as_u64()),
        (Some(true), Some(7))
    );
}

#[test]
fn an_oversized_message_closes_its_sender_alone() {
    let bench = Bench::start();
    let mut honest = bench.socket(OPERATOR).unwrap();
    let mut sender = bench.socket(OPERATOR).unwrap();
    let fits = format!(
        "{{\"id\": 1, \"do\": \"pause\", \"x\": \"{}\"}}",
        "x".repeat(60_000)
    );
    assert!(ask(&mut sender, &fits)["ok"].as_bool().unwrap());
    // It may be closed before everything is written.
    let _sent = sender.send(Message::text("x".repeat(70_000)));
    assert!(matches!(
        closing(&mut sender).as_deref(),
        None | Some("too large")
    ));
    assert!(
        ask(&mut honest, r#"{"id": 1, "do": "pause"}"#)["ok"]
            .as_bool()
            .unwrap()
    );
}

#[test]
fn a_flood_is_closed_and_the_others_are_answered() {
    let bench = Bench::start();
    let mut honest = bench.socket(OPERATOR).unwrap();
    let mut flood = bench.socket(OPERATOR).unwrap();
    for _ in 0..2000 {
        if flood
            .send(Message::text(r#"{"id": 1, "do": "pause"}"#))
            .is_err()
        {
            break;
        }
    }
    assert!(matches!(
        closing(&mut flood).as_deref(),
        None | Some("flood")
    ));
    assert!(bench.queue.0.lock().unwrap().len() <= 250);
    assert!(
        ask(&mut honest, r#"{"id": 1, "do": "pause"}"#)["ok"]
            .as_bool()
            .unwrap()
    );
}

#[test]
fn sixteen_pages_are_served_and_no_more() {
    let bench = Bench::start();
    let pages: Vec<_> = (0..16).map(|_| bench.socket(VIEWER).unwrap()).collect();
    assert_eq!(bench.socket(OPERATOR).err(), Some(503));
    drop(pages);
    let again = (0..200).any(|_| {
        std::thread::yield_now();
        bench.socket(OPERATOR).is_ok()
    });
    assert!(again, "places come free");
}

#[test]
fn a_thousand_connections_are_survived() {
    let bench = Bench::start();
    let mut page = bench.socket(OPERATOR).unwrap();
    let idle: Vec<_> = (0..1000).map(|_| bench.connect()).collect();
    assert!(
        ask(&mut page, r#"{"id": 1, "do": "pause"}"#)["ok"]
            .as_bool()
            .unwrap()
    );
    // Those closed for a newer one get the reason.
    let busy = idle.into_iter().filter(|stream| {
        let mut answer = String::new();
        let mut stream = stream;
        let _read = stream.read_to_string(&mut answer);
        answer.starts_with("HTTP/1.1 503")
    });
    assert!(busy.count() >= 900);
    assert_eq!(status(&bench.get("/api/scene", &bearer(VIEWER))), 200);
    assert!(
        ask(&mut page, r#"{"id": 2, "do": "pause"}"#)["ok"]
            .as_bool()
            .unwrap()
    );
}

#[test]
fn silent_connections_do_not_lock_the_page() {
    let bench = Bench::start();
    let _idle: Vec<_> = (0..110).map(|_| bench.connect()).collect();
    assert_eq!(status(&bench.get("/api/scene", &bearer(VIEWER))), 200);
    assert_eq!(status(&bench.get("/", "")), 401);
}

#[test]
fn the_link_of_an_operator_works_once_and_the_next_one_is_in_the_file() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("page.json");
    let bench = Bench::with_one_time_links(&file);
    let link = |token: &str, lines: &str| bench.get(&format!("/?token={token}"), lines);
    assert_eq!(status(&link(OPERATOR, "")), 303);
    let again = link(OPERATOR, "");
    assert_eq!(status(&again), 403);
    assert!(again.contains("used already") && again.contains("robocell status"));
    let body = format!("{{\"token\": \"{OPERATOR}\"}}");
    let ours = format!("Origin: http://{}\r\n", bench.host());
    assert_eq!(status(&bench.post("/api/token", &ours, &body)), 403);
    assert_eq!(bench.socket(OPERATOR).err(), Some(403));
    // The browser with the cookie opens its bookmark.
    let cookie = format!(
        "Cookie: robocell_{}={}\r\n",
        bench.address.port(),
        "c".repeat(32)
    );
    let reloaded = link(OPERATOR, &cookie);
    assert!(reloaded.contains("\r\nlocation: /\r\n") && !reloaded.contains("set-cookie"));
    let next = PageSecrets::load(&file).unwrap();
    assert_ne!(next.operator_token, OPERATOR);
    assert!(
        bench.socket(&next.operator_token).is_ok(),
        "programs read the file"
    );
    assert_eq!(status(&link(&next.operator_token, "")), 303);
    for _ in 0..2 {
        assert_eq!(status(&link(VIEWER, "")), 303, "for several viewers");
    }
}

#[test]
fn a_span_of_the_past_is_read_by_who_may_look_and_has_limits() {
    let bench = Bench::start();
    let span = "/api/past?from_s=1&to_s=2&count=3";
    assert_eq!(status(&bench.get(span, "")), 401);
    let read = bench.get(span, &bearer(VIEWER));
    assert_eq!(status(&read), 200);
    assert!(read.ends_with("1 1.5 2"), "{read}");
    for wrong in [
        "",
        "from_s=2&to_s=1&count=3",
        "from_s=0&to_s=601&count=3",
        "from_s=NaN&to_s=2&count=3",
        "from_s=0&to_s=1&count=1",
        "from_s=0&to_s=1&count=1001",
        "from_s=0&to_s=1&count=3&epoch=-1",
    ] {
        let answer = bench.get(&format!("/api/past?{wrong}"), &bearer(OPERATOR));
        assert_eq!(status(&answer), 400, "{wrong}");
    }
}

#[test]
fn an_incident_is_shown_to_who_may_look_and_nothing_else_is_read() {
    let bench = Bench::start();
    assert_eq!(status(&bench.get("/api/incidents/3", "")), 401);
    let shown = bench.get("/api/incidents/3", &bearer(VIEWER));
    assert_eq!(status(&shown), 200);
    assert!(shown.ends_with("what was kept"), "{shown}");
    for path in ["4", "-1", "3/incident.json", "..%2F3", "4294967296"] {
        let answer = bench.get(&format!("/api/incidents/{path}"), &bearer(OPERATOR));
        assert_eq!(status(&answer), 404, "{path}");
    }
    let replay = Bench::with(Files::default(), false);
    let answer = replay.get("/api/incidents/3", &bearer(OPERATOR));
    assert_eq!(status(&answer), 404, "a recording has its own");
    let shown = replay.get("/api/incidents/7", &bearer(VIEWER));
    assert!(shown.ends_with("of a recording"), "{shown}");
}

#[test]
fn grasps_are_shown_to_who_may_look_and_only_of_a_live_cell() {
    let bench = Bench::start();
    assert_eq!(status(&bench.get("/api/grasps/0/1", "")), 401);
    let shown = bench.get("/api/grasps/0/1", &bearer(VIEWER));
    assert!(shown.ends_with(r#"{"arm":"panda"}"#), "{shown}");
    for path in ["7/1", "0", "-1/1", "0/1/2", "0/x"] {
        let answer = bench.get(&format!("/api/grasps/{path}"), &bearer(OPERATOR));
        assert_eq!(status(&answer), 404, "{path}");
    }
    let replay = Bench::with(Files::default(), false);
    let answer = replay.get("/api/grasps/0/1", &bearer(OPERATOR));
    assert_eq!(status(&answer), 404, "a recording has none");
}

#[test]
fn joints_of_a_pose_need_an_arm_and_a_pose_of_seven_numbers() {
    let bench = Bench::start();
    let pose = "0.4,0,0.3,0,1,0,0";
    assert_eq!(
        status(&bench.get(&format!("/api/joints/0/{pose}"), "")),
        401
    );
    let shown = bench.get(&format!("/api/joints/0/{pose}"), &bearer(VIEWER));
    assert!(shown.ends_with(r#"{"joints":[0.3]}"#), "{shown}");
    for path in [
        format!("1/{pose}"),
        format!("0/{pose},0"),
        "0/0.4,0,0.3,0,2,0,0".to_owned(),
        "0/0.4,0,inf,0,1,0,0".to_owned(),
        "0".to_owned(),
    ] {
        let answer = bench.get(&format!("/api/joints/{path}"), &bearer(OPERATOR));
        assert_eq!(status(&answer), 404, "{path}");
    }
}

//! The page as a running cell serves it: access to it, and its contents with and without
//! Node.js.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use robocell_tests::cell::{TestCell, base};
use robocell_tests::http::{Answer, ask, parts, post};
use robocell_tests::program::{built, wait_for};

/// The page behind the link of a cell, with the cookie of its token.
fn page(link: &str) -> Answer {
    let (address, token) = parts(link);
    let exchange = format!("GET /?token={token}");
    let answer = wait_for("the page", || ask(&address, &exchange, &[]));
    assert_eq!((answer.code, answer.header("location")), (303, Some("/")));
    let set = answer.header("set-cookie").unwrap();
    assert!(set.contains("HttpOnly") && set.contains("SameSite=Strict"));
    ask(&address, "GET /", &[("Cookie", &cookie(&answer))]).unwrap()
}

/// A paused cell with its page; `ui` has the sources of the page.
fn cell(ui: &Path, path: Option<&str>) -> (TestCell, String) {
    let arguments = ["franka-stack", "--paused"];
    let cell = TestCell::start_with(base(), &arguments, |command: &mut Command| {
        command.env("ROBOCELL_UI_DIR", ui);
        if let Some(path) = path {
            command.env("PATH", path);
        }
    });
    let link = cell.link();
    (cell, link)
}

/// Sources of a page that count how often they are built.
fn sources() -> tempfile::TempDir {
    let ui = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(ui.path().join(name), text).unwrap();
    write(
        "package.json",
        r#"{"name": "p", "private": true, "scripts": {"build": "node build.mjs"}}"#,
    );
    write("index.html", "<title>sources</title>");
    write(
        "build.mjs",
        r#"import fs from "node:fs";
        const out = process.argv[process.argv.indexOf("--outDir") + 1];
        fs.mkdirSync(out, { recursive: true });
        fs.writeFileSync(`${out}/index.html`, "<title>the built page</title>");
        fs.appendFileSync("count", "x");"#,
    );
    ui
}

fn has_node() -> bool {
    let said = Command::new("npm")
        .arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    said.is_ok_and(|status| status.success())
}

#[test]
fn without_node_the_page_says_what_to_install_and_the_cell_runs() {
    let ui = sources();
    // A path with nothing on it.
    let (cell, link) = cell(ui.path(), Some("/nowhere"));
    assert_eq!(cell.wait_up()["page"], link.as_str());
    let page = page(&link);
    assert_eq!(page.code, 200);
    assert!(page.body.contains("Node.js 20"), "{page:?}");
    assert!(!page.body.contains("the built page"));
    let said = fs::read_to_string(cell.base().join("stdout")).unwrap();
    assert!(said.contains("note: The page is not built"), "{said}");
}

#[test]
fn with_node_the_page_is_built_once() {
    if !has_node() {
        eprintln!("skipped: Node.js is missing");
        return;
    }
    let ui = sources();
    for _ in 0..2 {
        let (cell, link) = cell(ui.path(), None);
        assert!(page(&link).body.contains("the built page"));
        drop(cell);
    }
    assert_eq!(fs::read_to_string(ui.path().join("count")).unwrap(), "x");
}

#[test]
fn who_has_no_token_or_comes_from_elsewhere_stays_outside() {
    let ui = sources();
    let (cell, link) = cell(ui.path(), Some("/nowhere"));
    let (address, token) = parts(&link);
    let without = wait_for("the page", || ask(&address, "GET /", &[]));
    assert!(matches!(without.code, 401 | 403), "{without:?}");
    let wrong = ask(&address, &format!("GET /?token={}", "0".repeat(32)), &[]).unwrap();
    assert!(matches!(wrong.code, 401 | 403), "{wrong:?}");
    // A name that leads here from elsewhere, with the right token.
    let forged = format!("GET /?token={token}");
    let host = [("Host", "cell.example")];
    assert_eq!(ask(&address, &forged, &host).unwrap().code, 403);
    // Another page in the same browser.
    let upgrade = [
        ("Upgrade", "websocket"),
        ("Connection", "Upgrade"),
        ("Sec-WebSocket-Version", "13"),
        ("Sec-WebSocket-Key", "AAAAAAAAAAAAAAAAAAAAAA=="),
        ("Origin", "http://cell.example"),
    ];
    assert_eq!(ask(&address, "GET /ws", &upgrade).unwrap().code, 403);
    let mode = fs::metadata(cell.run_dir().join("page.json")).unwrap();
    assert_eq!(
        std::os::unix::fs::MetadataExt::mode(&mode) & 0o777,
        0o600,
        "the secrets are their owner's"
    );
}

/// First part of the cookie that `answer` sets.
fn cookie(answer: &Answer) -> String {
    let cookie = answer.header("set-cookie").expect("a cookie");
    cookie.split(';').next().unwrap_or_default().to_owned()
}

#[test]
fn a_viewer_becomes_an_operator_by_the_operators_token_alone() {
    let ui = sources();
    let (cell, link) = cell(ui.path(), Some("/nowhere"));
    let (address, token) = parts(&link);
    wait_for("the page", || ask(&address, "GET /", &[]));
    let secrets = fs::read_to_string(cell.run_dir().join("page.json")).unwrap();
    let secrets: serde_json::Value = serde_json::from_str(&secrets).unwrap();
    let viewer_token = secrets["viewer_token"].as_str().unwrap();
    let entered = ask(&address, &format!("GET /?token={viewer_token}"), &[]).unwrap();
    let viewer = cookie(&entered);
    assert_eq!(
        ask(&address, "GET /", &[("Cookie", &viewer)]).unwrap().code,
        200
    );
    let own = format!("http://{address}");
    let present = |token: &str, origin: &str| {
        let body = format!(r#"{{"token": "{token}"}}"#);
        let length = body.len().to_string();
        let headers = [
            ("Cookie", viewer.as_str()),
            ("Origin", origin),
            ("Content-Type", "application/json"),
            ("Content-Length", &length),
        ];
        post(&address, "/api/token", &headers, &body).unwrap()
    };
    assert_eq!(present(&"0".repeat(32), &own).code, 403);
    assert_eq!(present(&token, "http://cell.example").code, 403);
    // His own token leaves him what he is.
    assert_eq!(cookie(&present(viewer_token, &own)), viewer);
    let now = present(&token, &own);
    assert_eq!(now.code, 204, "{now:?}");
    let entered = ask(&address, &format!("GET /?token={token}"), &[]).unwrap();
    assert_eq!(cookie(&now), cookie(&entered));
    assert_ne!(cookie(&now), viewer);
}

#[test]
fn a_link_that_was_used_opens_nothing_and_status_prints_the_next_one() {
    let ui = sources();
    let (cell, link) = cell(ui.path(), Some("/nowhere"));
    assert_eq!(page(&link).code, 200);
    let (address, token) = parts(&link);
    let again = ask(&address, &format!("GET /?token={token}"), &[]).unwrap();
    assert_eq!(again.code, 403, "{again:?}");
    assert!(again.body.contains("robocell status"), "{again:?}");
    let mut links = vec![link];
    for change in ["restart monitor", "load franka-stack"] {
        let next = cell.wait_up()["page"].as_str().unwrap().to_owned();
        assert!(!links.contains(&next));
        let words: Vec<&str> = change.split(' ').collect();
        assert_eq!(cell.ask(&words).code, 0, "{change}");
        let same = || (cell.status()?["page"] == next.as_str()).then_some(());
        wait_for("the same link as before", same);
        assert_eq!(page(&next).code, 200, "{change}");
        links.push(next);
    }
}

#[test]
fn another_scene_comes_onto_the_same_page() {
    let ui = sources();
    let (cell, link) = cell(ui.path(), Some("/nowhere"));
    let before = cell.wait_up();
    let said = cell.ask(&["load", "franka-pyramid", "--seed", "3"]);
    assert_eq!(said.code, 0, "{said:?}");
    let after = cell.wait_up();
    assert_eq!(
        (
            &after["demo"],
            &after["seed"],
            &after["page"],
            &after["paused"]
        ),
        (
            &"franka-pyramid".into(),
            &3.into(),
            &before["page"],
            &true.into()
        )
    );
    assert_eq!(page(&link).code, 200);
    let wrong = cell.ask(&["load", "franka-stak"]);
    assert_eq!(wrong.code, 3, "{wrong:?}");
    assert!(wrong.stderr.contains("franka-stack"), "{wrong:?}");
    assert_eq!(
        cell.wait_up()["demo"],
        "franka-pyramid",
        "and nothing stopped"
    );
}

#[test]
fn a_port_that_was_asked_for_and_is_taken_is_named() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let base = base();
    let said = Command::new(built("robocell"))
        .args(["run", "franka-stack", "--listen", &address])
        .env("ROBOCELL_RUN_DIR", base.path())
        .env("ROBOCELL_UI_DIR", base.path())
        .output()
        .unwrap();
    assert_eq!(said.status.code(), Some(3));
    let text = String::from_utf8_lossy(&said.stderr).into_owned();
    assert!(text.contains(&address), "{text}");
}

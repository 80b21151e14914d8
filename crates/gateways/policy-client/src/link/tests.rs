//! Servers that accept a connection and then say nothing.

use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use std::time::Duration;

use tungstenite::Message;

use super::Connection;
use crate::codec::Convention;
use crate::failure::{Failure, reason};
use crate::kept::Seen;

/// In place of ten seconds.
const LIMIT: Duration = Duration::from_millis(200);

/// The address of a server that leaves each connection to `talk`.
fn server(talk: impl FnOnce(TcpStream) + Send + 'static) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("ws://{}", listener.local_addr().unwrap());
    std::thread::spawn(move || talk(listener.accept().unwrap().0));
    address
}

fn open(address: &str, seen: &Arc<Seen>, limit: Duration) -> Result<Convention, Failure> {
    let opened = Connection::open(address, [].into(), seen, limit);
    opened.map(|connection| connection.convention)
}

/// Keeps what it is given until the sender is dropped.
fn keep<T>() -> (Sender<()>, impl FnOnce(T)) {
    let (over, wait) = channel::<()>();
    let keep = move |kept: T| {
        wait.recv().ok();
        drop(kept);
    };
    (over, keep)
}

#[test]
fn a_server_that_accepts_and_stays_mute_is_unreachable_within_the_limit_of_a_greeting() {
    for in_websocket in [false, true] {
        let (_over, wait) = keep();
        let address = server(move |stream| {
            if in_websocket {
                let socket = tungstenite::accept(stream).unwrap();
                wait(Box::new(socket) as Box<dyn Send>);
            } else {
                wait(Box::new(stream) as Box<dyn Send>);
            }
        });
        let failure = open(&address, &Arc::default(), LIMIT).unwrap_err();
        assert_eq!(failure.reason, reason::UNREACHABLE);
        let wanted = "was accepted, but no policy server greeted within 0.2 s";
        assert!(failure.message.contains(wanted), "{}", failure.message);
    }
}

#[test]
fn a_server_that_another_connection_has_found_has_the_time_of_an_answer() {
    let (seen, none) = (Arc::new(Seen::default()), Duration::ZERO);
    let greets = |stream| {
        if let Ok(mut socket) = tungstenite::accept(stream) {
            socket.send(Message::binary(b"\x80".to_vec())).ok();
            socket.read().ok();
        }
    };
    let address = server(greets);
    let failure = open(&address, &seen, none).unwrap_err();
    assert_eq!(failure.reason, reason::UNREACHABLE);
    let address = server(greets);
    seen.found(&address, Convention::OpenPi);
    assert_eq!(open(&address, &seen, none), Ok(Convention::OpenPi));
}

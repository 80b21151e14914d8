//! Policy servers of the tests.

use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use rmpv::Value;
use tungstenite::{Message, WebSocket};

/// What a server does with a request.
pub(crate) enum Reply {
    /// Sends these bytes.
    Bytes(Vec<u8>),
    /// Sends text.
    Text(String),
    /// Ends the connection without a word.
    Close,
}

/// A server that is there until its test ends.
pub(crate) struct Server {
    pub(crate) address: String,
    /// Requests so far, of all connections.
    pub(crate) requests: Arc<AtomicU64>,
}

fn bytes(value: &Value) -> Vec<u8> {
    let mut bytes = Vec::new();
    rmpv::encode::write_value(&mut bytes, value).unwrap();
    bytes
}

pub(crate) fn map(entries: Vec<(&str, Value)>) -> Value {
    Value::Map(
        entries
            .into_iter()
            .map(|(key, value)| (key.into(), value))
            .collect(),
    )
}

/// An answer with rows of actions, in the form of openpi.
pub(crate) fn rows(rows: &[Vec<f32>]) -> Vec<u8> {
    bytes(&map(vec![("actions", array(rows, true))]))
}

fn array(rows: &[Vec<f32>], with_bytes: bool) -> Value {
    let key = |name: &str| {
        if with_bytes {
            Value::Binary(name.as_bytes().to_vec())
        } else {
            name.into()
        }
    };
    let width = rows.first().map_or(0, Vec::len);
    let data = rows
        .iter()
        .flatten()
        .flat_map(|number| number.to_le_bytes());
    Value::Map(vec![
        (key("__ndarray__"), true.into()),
        (key("data"), Value::Binary(data.collect())),
        (key("dtype"), "<f4".into()),
        (
            key("shape"),
            Value::Array(vec![rows.len().into(), width.into()]),
        ),
    ])
}

/// The numbers of an array in a request.
pub(crate) fn numbers(request: &Value, name: &str) -> Vec<f32> {
    let entry = |map: &Value, key: &str| -> Value {
        let entries = map.as_map().unwrap();
        let is_key = |known: &Value| match known {
            Value::Binary(bytes) => bytes == key.as_bytes(),
            known => known.as_str() == Some(key),
        };
        let found = entries.iter().find(|(known, _)| is_key(known));
        found
            .unwrap_or_else(|| panic!("no {key} in {map}"))
            .1
            .clone()
    };
    let data = entry(&entry(request, name), "data");
    let data = data.as_slice().unwrap();
    data.as_chunks::<4>()
        .0
        .iter()
        .map(|bytes| f32::from_le_bytes(*bytes))
        .collect()
}

/// A server in the convention of openpi; `answer` gets the number of the request of its
/// connection, and the request.
pub(crate) fn openpi(answer: impl Fn(u64, &Value) -> Reply + Send + Sync + 'static) -> Server {
    serve(move |socket, count| {
        let about = bytes(&map(vec![("name", "test".into())]));
        socket.send(Message::binary(about)).ok();
        for number in 0.. {
            let Ok(Message::Binary(request)) = socket.read() else {
                return;
            };
            count.fetch_add(1, Ordering::Relaxed);
            let request = rmpv::decode::read_value(&mut &request[..]).unwrap();
            if !reply(socket, answer(number, &request)) {
                return;
            }
        }
    })
}

/// A server in the convention of vla-eval, which waits for a hello; `answer` gets the payload.
/// The kinds of its messages are written to `kinds`.
pub(crate) fn vla_eval(
    answer: impl Fn(&Value) -> Vec<Vec<f32>> + Send + Sync + 'static,
    kinds: std::sync::mpsc::Sender<String>,
) -> Server {
    serve(move |socket, count| {
        while let Ok(Message::Binary(message)) = socket.read() {
            let message = rmpv::decode::read_value(&mut &message[..]).unwrap();
            let entry = |key: &str| {
                let entries = message.as_map().unwrap().iter();
                let mut found = entries.filter(|(known, _)| known.as_str() == Some(key));
                found.next().unwrap().1.clone()
            };
            let kind = entry("type").as_str().unwrap().to_owned();
            let send = |kind: &str, payload: Value| {
                let seq = entry("seq");
                bytes(&map(vec![
                    ("type", kind.into()),
                    ("payload", payload),
                    ("seq", seq),
                    ("timestamp", 1.0.into()),
                ]))
            };
            let sent = match kind.as_str() {
                "hello" => Some(send("hello", map(vec![]))),
                "observation" => {
                    count.fetch_add(1, Ordering::Relaxed);
                    let actions = array(&answer(&entry("payload")), false);
                    Some(send("action", map(vec![("actions", actions)])))
                }
                _ => None,
            };
            kinds.send(kind).ok();
            if sent.is_some_and(|sent| socket.send(Message::binary(sent)).is_err()) {
                return;
            }
        }
    })
}

fn reply(socket: &mut WebSocket<TcpStream>, reply: Reply) -> bool {
    let message = match reply {
        Reply::Bytes(bytes) => Message::binary(bytes),
        Reply::Text(text) => Message::text(text),
        Reply::Close => return false,
    };
    socket.send(message).is_ok()
}

fn serve(talk: impl Fn(&mut WebSocket<TcpStream>, &AtomicU64) + Send + Sync + 'static) -> Server {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("ws://{}", listener.local_addr().unwrap());
    let requests = Arc::new(AtomicU64::new(0));
    let (talk, count) = (Arc::new(talk), requests.clone());
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let (talk, count) = (talk.clone(), count.clone());
            std::thread::spawn(move || {
                if let Ok(mut socket) = tungstenite::accept(stream) {
                    talk(&mut socket, &count);
                }
            });
        }
    });
    Server { address, requests }
}

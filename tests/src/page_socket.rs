//! The websocket of a page, as the operator's browser has it.

use std::net::TcpStream;
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::{ClientRequestBuilder, Message, WebSocket};

use crate::cell::TestCell;
use crate::http::parts;
use crate::program::wait_for;

/// See the module.
#[derive(Debug)]
pub struct PageSocket {
    socket: WebSocket<TcpStream>,
    asked: u64,
}

impl PageSocket {
    /// Of the page of `cell`, as soon as it is served.
    ///
    /// # Panics
    /// Where the page has no secrets.
    pub fn open(cell: &TestCell) -> Self {
        let (address, _) = parts(&cell.link());
        let socket = wait_for("the page's socket", || {
            let secrets = std::fs::read(cell.run_dir().join("page.json")).ok()?;
            let secrets: Value = serde_json::from_slice(&secrets).expect("secrets");
            let token = secrets["operator_token"].as_str().expect("a token");
            let stream = TcpStream::connect(&address).ok()?;
            stream
                .set_read_timeout(Some(Duration::from_millis(100)))
                .ok()?;
            let uri = format!("ws://{address}/ws").parse().expect("an address");
            let request = ClientRequestBuilder::new(uri)
                .with_header("Authorization", format!("Bearer {token}"));
            Some(tungstenite::client(request, stream).ok()?.0)
        });
        Self { socket, asked: 0 }
    }

    /// Sends the command `what`; what the page is answered.
    ///
    /// # Panics
    /// Without an answer.
    pub fn ask(&mut self, mut what: Value) -> Value {
        self.asked += 1;
        what["id"] = json!(self.asked);
        let sent = self.socket.send(Message::text(what.to_string()));
        sent.expect("the page takes a command");
        let id = what["id"].clone();
        self.wait(|message| message["t"] == "ack" && message["id"] == id)
    }

    /// The first message with `text` in a line of the log.
    pub fn wait_log(&mut self, text: &str) -> Value {
        self.wait(|message| {
            let lines = message["lines"].as_array().into_iter().flatten();
            let mut texts = lines.filter_map(|line| line["text"].as_str());
            // A long line is continued on the next.
            let all = texts
                .by_ref()
                .map(|text| text.strip_prefix("  ... ").unwrap_or(text));
            message["t"] == "log" && all.collect::<String>().contains(text)
        })
    }

    fn wait(&mut self, is_wanted: impl Fn(&Value) -> bool) -> Value {
        wait_for("a message of the page", || {
            let Ok(Message::Text(text)) = self.socket.read() else {
                return None;
            };
            let message: Value = serde_json::from_str(&text).expect("JSON");
            is_wanted(&message).then_some(message)
        })
    }
}

//! The least of HTTP: one request, its whole answer.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// An answer.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Status code.
    pub code: u16,
    /// The lines of the head.
    pub head: String,
    /// What came after it.
    pub body: String,
}

impl Answer {
    /// Value of the header `name`.
    pub fn header(&self, name: &str) -> Option<&str> {
        let lines = self.head.lines().skip(1);
        lines
            .filter_map(|line| line.split_once(':'))
            .find_map(|(key, value)| key.eq_ignore_ascii_case(name).then(|| value.trim()))
    }
}

/// Sends `METHOD PATH` with more `headers` to `address` (`127.0.0.1:8600`);
/// `None` without an answer.
pub fn ask(address: &str, method_and_path: &str, headers: &[(&str, &str)]) -> Option<Answer> {
    send(address, method_and_path, headers, "")
}

/// As [`ask`], a POST of `body` to `path`; `headers` tell its length and type.
pub fn post(address: &str, path: &str, headers: &[(&str, &str)], body: &str) -> Option<Answer> {
    send(address, &format!("POST {path}"), headers, body)
}

fn send(
    address: &str,
    method_and_path: &str,
    headers: &[(&str, &str)],
    body: &str,
) -> Option<Answer> {
    let mut stream = TcpStream::connect(address).ok()?;
    stream
        .set_read_timeout(Some(Duration::from_secs(10)))
        .ok()?;
    let mut lines = vec![
        format!("{method_and_path} HTTP/1.1"),
        "Connection: close".to_owned(),
    ];
    if !headers.iter().any(|(key, _)| *key == "Host") {
        lines.push(format!("Host: {address}"));
    }
    lines.extend(headers.iter().map(|(key, value)| format!("{key}: {value}")));
    let request = lines.join("\r\n") + "\r\n\r\n" + body;
    stream.write_all(request.as_bytes()).ok()?;
    let mut bytes = Vec::new();
    stream.read_to_end(&mut bytes).ok()?;
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let (head, body) = text.split_once("\r\n\r\n")?;
    Some(Answer {
        code: head.split_whitespace().nth(1)?.parse().ok()?,
        head: head.to_owned(),
        body: body.to_owned(),
    })
}

/// Address and token of a link to a page.
///
/// # Panics
/// Where it is none.
pub fn parts(link: &str) -> (String, String) {
    let rest = link.strip_prefix("http://").expect("a link");
    let (address, query) = rest.split_once("/?token=").expect("a token");
    (address.to_owned(), query.to_owned())
}

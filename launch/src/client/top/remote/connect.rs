//! The way to a monitor.

use std::fmt;
use std::io::ErrorKind;
use std::net::{TcpStream, ToSocketAddrs as _};
use std::time::Duration;

use tungstenite::WebSocket;
use tungstenite::client::IntoClientRequest as _;
use tungstenite::http::HeaderValue;

use crate::failure::{Context as _, Failure};

/// Longest wait for a connection, and for its first answer.
const PATIENCE: Duration = Duration::from_secs(5);
/// Where `robocell run` serves the page, if that port is free.
const PORT: u16 = 8600;

/// Host and port of a monitor, and the token that lets one in.
pub(super) struct Address {
    host: String,
    token: String,
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.host)
    }
}

impl Address {
    /// Of a link that `robocell run --listen` prints.
    pub(super) fn of(url: &str) -> Result<Self, Failure> {
        let wrong = || {
            Failure::usage(format!(
                "`{url}` is no link to a page; `robocell run --listen ADDRESS` and `robocell status` \
                 print it: http://HOST:PORT/?token=TOKEN"
            ))
        };
        let rest = url.strip_prefix("http://").unwrap_or(url);
        let (host, query) = rest.split_once('?').ok_or_else(wrong)?;
        let host = host.trim_end_matches('/');
        let token = query
            .split('&')
            .find_map(|part| part.strip_prefix("token="));
        let token = token.filter(|token| token.chars().all(|c| c.is_ascii_alphanumeric()));
        let (Some(token), false) = (token, host.is_empty() || host.contains('/')) else {
            return Err(wrong());
        };
        // The port is what follows the brackets of an IPv6 address.
        let after = host
            .rfind(']')
            .map_or(host, |at| host.get(at..).unwrap_or(host));
        let host = if after.contains(':') {
            host.to_owned()
        } else {
            format!("{host}:{PORT}")
        };
        Ok(Self {
            host,
            token: token.to_owned(),
        })
    }

    /// A websocket to the monitor.
    pub(super) fn connect(&self) -> Result<WebSocket<TcpStream>, Failure> {
        let what = || format!("connect to {self}");
        let mut found = self.host.to_socket_addrs().cannot(what())?;
        let no_address = || Failure::configuration(format!("cannot {}: no such host", what()));
        let address = found.next().ok_or_else(no_address)?;
        let stream = TcpStream::connect_timeout(&address, PATIENCE).cannot(what())?;
        stream.set_read_timeout(Some(PATIENCE)).cannot(what())?;
        let url = format!("ws://{}/ws", self.host);
        let mut request = url.into_client_request().cannot(what())?;
        let bearer = HeaderValue::from_str(&format!("Bearer {}", self.token));
        request
            .headers_mut()
            .insert("Authorization", bearer.cannot(what())?);
        match tungstenite::client(request, stream) {
            Ok((socket, _)) => Ok(socket),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
                let status = answer.status();
                Err(Failure::configuration(format!(
                    "{self} refuses the token ({status}): each run has its own, and a link for \
                     operators works once; `robocell status` on its host prints the link"
                )))
            }
            Err(error) => Err(Failure::configuration(format!(
                "cannot {}: {error}",
                what()
            ))),
        }
    }

    /// Why there is no connection any more.
    pub(super) fn gone(&self, why: impl fmt::Display) -> Failure {
        Failure::configuration(format!("no connection to {self} any more: {why}"))
    }
}

/// Nothing came in time, or a signal arrived.
pub(super) fn is_no_end(kind: ErrorKind) -> bool {
    let no_end = [
        ErrorKind::WouldBlock,
        ErrorKind::TimedOut,
        ErrorKind::Interrupted,
    ];
    no_end.contains(&kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_names_a_host_and_a_token() {
        for (link, host) in [
            ("http://10.0.0.1:8601/?token=ab12", "10.0.0.1:8601"),
            ("10.0.0.1?token=ab12", "10.0.0.1:8600"),
            ("http://[fe80::1]/?token=ab12", "[fe80::1]:8600"),
            ("http://cell.lab:80/?view=x&token=ab12", "cell.lab:80"),
        ] {
            let found = Address::of(link).unwrap();
            assert_eq!((found.host.as_str(), found.token.as_str()), (host, "ab12"));
        }
        for wrong in [
            "",
            "http://host",
            "http://?token=ab",
            "http://h/x?token=a",
            "h?token=a b",
        ] {
            let said = Address::of(wrong).err().unwrap().message;
            assert!(said.contains("?token=TOKEN"), "{wrong}: {said}");
        }
    }
}

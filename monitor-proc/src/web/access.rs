//! Decides which requests are answered: by the name of the server, the origin of the request,
//! its token and its cookie.
//!
//! What can go wrong: any page in the user's browser can send requests to this machine, and
//! one of another port of it with the cookie; another name may resolve to this address (DNS
//! rebinding); another user of the machine can connect. The rules: a request must name this
//! server by one of its own names; a request that changes something or stays open must come
//! from our own page, or show the token; everything needs a role. Secrets are 128 random bits
//! (ADR 0013) and compared in constant time.
//!
//! A change must not break: Host and Origin must not appear twice; an empty secret matches
//! nothing; a request without an origin needs the token itself, as another port of this host
//! is the same site, whose requests have the cookie.

use std::io;
use std::mem;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::http::header::{AUTHORIZATION, COOKIE, HOST, ORIGIN};
use axum::http::{HeaderMap, Uri};
use cell_run::spec::PageSecrets;
use subtle::ConstantTimeEq;

use crate::page::role::Role;

/// Result of exchanging the token of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exchange {
    /// The cookie of this role.
    Role(Role),
    /// Nothing: the link was used before.
    Used,
    /// Nothing: it is not a token of this run.
    Wrong,
}

/// Decides about every request.
#[derive(Clone, Debug)]
pub struct AccessControl {
    address: SocketAddr,
    host: Option<String>,
    keys: Arc<Mutex<Keys>>,
    cookie: String,
}

#[derive(Debug)]
struct Keys {
    secrets: PageSecrets,
    /// The last operator token that was exchanged.
    used: String,
    /// File in which a new operator token is written after each exchange; without it a link can
    /// be used again.
    file: Option<PathBuf>,
}

impl Keys {
    /// Replaces the operator token, so that a link in a browser history, a chat or
    /// a list of processes opens nothing.
    fn replace_operator_token(&mut self) -> io::Result<()> {
        let Some(file) = &self.file else {
            return Ok(());
        };
        let next = self.secrets.with_new_operator_token()?;
        // Kept, to tell a used link from a wrong one: the person gets another advice.
        let used = mem::replace(&mut self.secrets, next);
        self.used = used.operator_token;
        // Last: if the file cannot be written the old token is
        // gone already, which is the safe side.
        self.secrets.save(file)
    }
}

impl AccessControl {
    /// The access control of a server that listens at `address`.
    pub fn new(address: SocketAddr, secrets: PageSecrets) -> Self {
        let cookie = PageSecrets::cookie_name(address.port());
        let keys = Keys {
            secrets,
            used: String::new(),
            file: None,
        };
        Self {
            address,
            host: None,
            keys: Arc::new(Mutex::new(keys)),
            cookie,
        }
    }

    /// The same, which replaces the operator token in `file` after each
    /// exchange.
    pub fn with_one_time_links(self, file: PathBuf) -> Self {
        self.keys().file = Some(file);
        self
    }

    /// The same, which also accepts the name `host`.
    pub fn with_host(self, host: Option<String>) -> Self {
        Self { host, ..self }
    }

    fn keys(&self) -> MutexGuard<'_, Keys> {
        self.keys.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the request was sent to this server under one of its own names. Another name is
    /// another site that resolves to this address.
    pub fn is_for_us(&self, uri: &Uri, headers: &HeaderMap) -> bool {
        let mut hosts = headers.get_all(HOST).iter();
        // Exactly one: with two, this check and a proxy could choose different ones.
        let (Some(host), None) = (hosts.next(), hosts.next()) else {
            return false;
        };
        // A request may name the server a second time, in its first line; both must be ours.
        let asked = uri
            .authority()
            .is_none_or(|asked| self.is_our_name(asked.as_str()));
        asked && host.to_str().is_ok_and(|host| self.is_our_name(host))
    }

    fn is_our_name(&self, host: &str) -> bool {
        let port = format!(":{}", self.address.port());
        let name = match host.strip_suffix(&port) {
            Some(name) => name,
            // Browsers leave out the default port.
            None if self.address.port() == 80 => host,
            None => return false,
        };
        let own = self.host.as_deref();
        if name.eq_ignore_ascii_case("localhost")
            || own.is_some_and(|own| name.eq_ignore_ascii_case(own))
        {
            return true;
        }
        // IPv6 addresses are in brackets; without them the last colon would be ambiguous.
        let bare = name
            .strip_prefix('[')
            .and_then(|rest| rest.strip_suffix(']'));
        let address = match bare {
            Some(v6) => v6.parse().ok().map(IpAddr::V6),
            None => name.parse().ok().map(IpAddr::V4),
        };
        let listens = self.address.ip();
        // A browser that names an address got it from its user, so where the server listens at
        // all addresses, each is its name.
        address.is_some_and(|ip| {
            ip.is_loopback() && is_plain_loopback(ip) || ip == listens || listens.is_unspecified()
        })
    }

    /// Whether a request that changes something, or stays open, is sent by our own page or by a
    /// program that shows its token.
    pub fn is_from_us(&self, headers: &HeaderMap) -> bool {
        let mut origins = headers.get_all(ORIGIN).iter();
        match (origins.next(), origins.next()) {
            // A program: browsers always send an origin with such requests.
            (None, _) => self.bearer(headers).is_some(),
            (Some(origin), None) => {
                let host = headers.get(HOST).and_then(|host| host.to_str().ok());
                let ours = host.map(|host| format!("http://{host}"));
                ours.is_some_and(|ours| origin.as_bytes().eq_ignore_ascii_case(ours.as_bytes()))
            }
            _ => false,
        }
    }

    /// Role of the sender of a request.
    pub fn role(&self, headers: &HeaderMap) -> Option<Role> {
        // The token first: a program with a token is not limited by a viewer's cookie.
        self.bearer(headers).or_else(|| self.cookie_role(headers))
    }

    /// The role of the holder of a token.
    pub fn role_of_token(&self, token: &str) -> Option<Role> {
        let keys = self.keys();
        let secrets = &keys.secrets;
        Self::role_of(token, &secrets.operator_token, &secrets.viewer_token)
    }

    /// Exchanges the token of a link. A link of an operator works once, a link of a viewer is
    /// for several viewers.
    pub fn exchange(&self, token: &str) -> Exchange {
        let role = self.role_of_token(token);
        // A second lock: `role_of_token` takes it as well, and it is not reentrant.
        let mut keys = self.keys();
        match role {
            Some(Role::Operator) => {
                if let Err(error) = keys.replace_operator_token() {
                    cell_worker::warn(format_args!(
                        "the next link to the page cannot be written: {error}; \
                         `robocell restart monitor` makes the last one valid again"
                    ));
                }
                Exchange::Role(Role::Operator)
            }
            Some(role) => Exchange::Role(role),
            None if is_same(token, &keys.used) => Exchange::Used,
            None => Exchange::Wrong,
        }
    }

    /// The header line that gives a client its role.
    pub fn set_cookie(&self, role: Role) -> String {
        let keys = self.keys();
        let value = match role {
            Role::Operator => &keys.secrets.operator_cookie,
            Role::Viewer => &keys.secrets.viewer_cookie,
        };
        // Not readable by scripts, and not sent with requests of other sites.
        format!("{}={value}; Path=/; HttpOnly; SameSite=Strict", self.cookie)
    }

    fn bearer(&self, headers: &HeaderMap) -> Option<Role> {
        let line = headers.get(AUTHORIZATION)?.to_str().ok()?;
        let (scheme, token) = line.split_once(' ')?;
        if !scheme.eq_ignore_ascii_case("bearer") {
            return None;
        }
        self.role_of_token(token.trim())
    }

    fn cookie_role(&self, headers: &HeaderMap) -> Option<Role> {
        let lines = headers
            .get_all(COOKIE)
            .iter()
            .filter_map(|line| line.to_str().ok());
        let pairs = lines.flat_map(|line| line.split(';'));
        let ours = pairs.filter_map(|pair| {
            let (name, value) = pair.trim().split_once('=')?;
            (name == self.cookie).then_some(value)
        });
        let keys = self.keys();
        let secrets = &keys.secrets;
        ours.filter_map(|value| {
            Self::role_of(value, &secrets.operator_cookie, &secrets.viewer_cookie)
        })
        // A browser may hold cookies of both roles; the higher one counts.
        .max()
    }

    fn role_of(given: &str, operator: &str, viewer: &str) -> Option<Role> {
        // Both are compared in any case, so that the time does not tell the role.
        let (operator, viewer) = (is_same(given, operator), is_same(given, viewer));
        match (operator, viewer) {
            (true, _) => Some(Role::Operator),
            (_, true) => Some(Role::Viewer),
            _ => None,
        }
    }
}

/// In constant time; an empty secret is never the same.
fn is_same(given: &str, secret: &str) -> bool {
    !secret.is_empty() && bool::from(given.as_bytes().ct_eq(secret.as_bytes()))
}

/// 127.0.0.1 and `::1`; the rest of 127/8 names no server.
fn is_plain_loopback(ip: IpAddr) -> bool {
    ip == IpAddr::from([127, 0, 0, 1]) || ip == IpAddr::from([0, 0, 0, 0, 0, 0, 0, 1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    fn access(address: &str) -> AccessControl {
        let secrets = PageSecrets {
            operator_token: "a".repeat(32),
            viewer_token: "b".repeat(32),
            operator_cookie: "c".repeat(32),
            viewer_cookie: "d".repeat(32),
        };
        AccessControl::new(address.parse().unwrap(), secrets)
    }

    fn headers(lines: &[(&'static str, &str)]) -> HeaderMap {
        let mut map = HeaderMap::new();
        for (name, value) in lines {
            map.append(*name, HeaderValue::from_str(value).unwrap());
        }
        map
    }

    #[test]
    fn only_our_own_names_are_answered() {
        let loopback = access("127.0.0.1:8000");
        for host in [
            "localhost:8000",
            "127.0.0.1:8000",
            "[::1]:8000",
            "LOCALHOST:8000",
        ] {
            assert!(loopback.is_our_name(host), "{host}");
        }
        let strange = [
            "",
            ":8000",
            "localhost",
            "localhost:8001",
            "evil.example:8000",
            "127.0.0.2:8000",
            "localhost.evil.example:8000",
            "localhost:8000.evil.example",
            "192.168.0.7:8000",
            "[::ffff:127.0.0.1]:8000",
            "user@localhost:8000",
            "0.0.0.0:8000",
        ];
        for host in strange {
            assert!(!loopback.is_our_name(host), "{host}");
        }
        assert!(access("192.168.0.7:8000").is_our_name("192.168.0.7:8000"));
        assert!(!access("192.168.0.7:8000").is_our_name("192.168.0.8:8000"));
        assert!(access("0.0.0.0:8000").is_our_name("192.168.0.8:8000"));
        assert!(!access("0.0.0.0:8000").is_our_name("evil.example:8000"));
        let two = headers(&[("host", "localhost:8000"), ("host", "evil.example")]);
        assert!(!loopback.is_for_us(&Uri::from_static("/"), &two));
        let ours = headers(&[("host", "localhost:8000")]);
        let absolute = Uri::from_static("http://evil.example/");
        assert!(!loopback.is_for_us(&absolute, &ours));
    }

    #[test]
    fn a_page_of_another_origin_is_a_stranger_and_a_program_shows_its_token() {
        let access = access("127.0.0.1:8000");
        let from = |lines: &[(&'static str, &str)]| {
            let mut all = headers(lines);
            all.insert(HOST, HeaderValue::from_static("localhost:8000"));
            access.is_from_us(&all)
        };
        let token = format!("Bearer {}", "a".repeat(32));
        assert!(from(&[("origin", "http://localhost:8000")]));
        assert!(!from(&[("origin", "http://localhost:8001")]));
        assert!(!from(&[("origin", "https://localhost:8000")]));
        assert!(!from(&[("origin", "null")]));
        assert!(!from(&[]));
        assert!(from(&[("authorization", &token)]));
        assert!(!from(&[
            ("authorization", &token),
            ("origin", "http://evil.example")
        ]));
        assert!(!from(&[("authorization", "Bearer x")]));
    }

    #[test]
    fn the_best_cookie_counts_and_those_of_other_cells_do_not() {
        let access = access("127.0.0.1:8000");
        let role = |line: &str| access.role(&headers(&[("cookie", line)]));
        let (operator, viewer) = ("c".repeat(32), "d".repeat(32));
        assert_eq!(role(&format!("robocell_8000={viewer}")), Some(Role::Viewer));
        let both = format!("x=1; robocell_8000={viewer}; robocell_8000={operator}");
        assert_eq!(role(&both), Some(Role::Operator));
        assert_eq!(role(&format!("robocell_8001={operator}")), None);
        assert_eq!(role("robocell_8000="), None);
        assert_eq!(
            role(&format!("robocell_8000={}", "a".repeat(32))),
            None,
            "a token"
        );
    }
}

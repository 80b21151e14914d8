//! Where the page listens.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};

use crate::failure::Failure;

/// Ports that are tried, in this order: away from those of the tools people run
/// beside a cell.
const PORTS: std::ops::Range<u16> = 8600..8700;

/// The address `listen` names (`ADDR` or `ADDR:PORT`), or loopback. A port that
/// was asked for has to be free; otherwise the first free one is taken.
pub(crate) fn address(listen: Option<&str>) -> Result<SocketAddr, Failure> {
    let (ip, port) = match listen {
        None => (IpAddr::V4(Ipv4Addr::LOCALHOST), None),
        Some(text) => parse(text)?,
    };
    let free = |port: &u16| TcpListener::bind((ip, *port)).is_ok();
    match port {
        Some(port) if free(&port) => Ok(SocketAddr::new(ip, port)),
        Some(port) => Err(Failure::configuration(format!(
            "--listen {ip}:{port}: cannot listen there; the address has to be one of this machine and the \
             port free (`--listen {ip}` takes the first free one from {})",
            PORTS.start
        ))),
        None => PORTS
            .clone()
            .find(free)
            .map(|port| SocketAddr::new(ip, port))
            .ok_or_else(|| {
                Failure::configuration(format!(
                    "no port from {} to {} is free at {ip}; `--listen ADDR:PORT` names another, \
                     `--headless` starts no page",
                    PORTS.start,
                    PORTS.end - 1
                ))
            }),
    }
}

fn parse(text: &str) -> Result<(IpAddr, Option<u16>), Failure> {
    if let Ok(address) = text.parse::<SocketAddr>() {
        return Ok((address.ip(), Some(address.port())));
    }
    let bare = text.trim_start_matches('[').trim_end_matches(']');
    if bare == "localhost" {
        return Ok((IpAddr::V4(Ipv4Addr::LOCALHOST), None));
    }
    bare.parse().map(|ip| (ip, None)).map_err(|_| {
        Failure::usage(format!(
            "--listen is {text:?}; allowed are an IP address of this machine, or ADDRESS:PORT, as in 0.0.0.0:8600"
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_as_people_write_them() {
        let ip = |text: &str| parse(text).unwrap();
        assert_eq!(ip("0.0.0.0"), ([0, 0, 0, 0].into(), None));
        assert_eq!(ip("127.0.0.1:9000"), ([127, 0, 0, 1].into(), Some(9000)));
        assert_eq!(ip("localhost").0, IpAddr::V4(Ipv4Addr::LOCALHOST));
        assert!(ip("[::1]").0.is_loopback() && ip("::").0.is_unspecified());
        for bad in ["", "here", "1.2.3", "1.2.3.4:99999"] {
            let message = parse(bad).unwrap_err().to_string();
            assert!(message.contains("0.0.0.0:8600"), "{message}");
        }
    }

    #[test]
    fn a_taken_port_is_passed_over_but_not_when_it_was_asked_for() {
        let first = address(None).unwrap();
        let taken = TcpListener::bind(first).unwrap();
        assert_ne!(address(None).unwrap(), first);
        let message = address(Some(&first.to_string())).unwrap_err().to_string();
        assert!(message.contains(&first.port().to_string()), "{message}");
        drop(taken);
    }
}

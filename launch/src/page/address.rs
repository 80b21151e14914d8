//! Where the page listens.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, UdpSocket};
use std::path::Path;
use std::sync::Arc;

use cell_rt::lock::Lock;
use supervisor::failure::{Context, Failure};
use supervisor::rundir::shared_locks;

/// Ports that are tried, in this order: away from those of the tools people run
/// beside a cell.
const PORTS: std::ops::Range<u16> = 8600..8700;

/// An address that no other launcher takes while this value lives.
#[derive(Clone, Debug)]
pub(crate) struct ListenAddress {
    /// Where to listen.
    pub(crate) address: SocketAddr,
    _reserved: Option<Arc<Lock>>,
}

/// The address `listen` names (`ADDR` or `ADDR:PORT`), or loopback. A port that
/// was asked for has to be free; otherwise the first free one is taken.
pub(crate) fn place(listen: Option<&str>) -> Result<ListenAddress, Failure> {
    let (ip, port) = match listen {
        None => (IpAddr::V4(Ipv4Addr::LOCALHOST), None),
        Some(text) => parse(text)?,
    };
    if let Some(port) = port {
        if !is_free(ip, port) {
            return Err(Failure::configuration(format!(
                "--listen {ip}:{port}: cannot listen there; the address has to be one of this machine and the \
                 port free (`--listen {ip}` takes the first free one from {})",
                PORTS.start
            )));
        }
        return Ok(ListenAddress {
            address: SocketAddr::new(ip, port),
            _reserved: None,
        });
    }
    // Any port: an address of another machine is told apart from ports that are all taken.
    if let Err(error) = TcpListener::bind((ip, 0)) {
        return Err(Failure::configuration(format!(
            "--listen {ip}: cannot listen there ({error}); give an address of this machine, as `ip address` \
             lists them, 0.0.0.0 for all of them"
        )));
    }
    first_free(ip, &shared_locks()?)
}

/// The first port of `ip` that is free and that no launcher with locks in `locks` has chosen.
fn first_free(ip: IpAddr, locks: &Path) -> Result<ListenAddress, Failure> {
    for port in PORTS {
        // Reserved first: two launchers that start at once would both find the port free.
        let Some(reserved) = reserve(port, locks)? else {
            continue;
        };
        if is_free(ip, port) {
            return Ok(ListenAddress {
                address: SocketAddr::new(ip, port),
                _reserved: Some(Arc::new(reserved)),
            });
        }
    }
    Err(Failure::configuration(format!(
        "no port from {} to {} is free at {ip}; `--listen ADDR:PORT` names another, \
         `--headless` starts no page",
        PORTS.start,
        PORTS.end - 1
    )))
}

/// Addresses that other machines reach this one by: those of the routes to networks far
/// away. A route is looked up; nothing is sent.
pub(crate) fn of_this_machine() -> Vec<IpAddr> {
    // Kept free for documentation (RFC 5737, RFC 3849): every default route leads there.
    let routes = [("0.0.0.0:0", "192.0.2.1:9"), ("[::]:0", "[2001:db8::1]:9")];
    let own = routes.into_iter().filter_map(|(from, to)| {
        let socket = UdpSocket::bind(from).ok()?;
        socket.connect(to).ok()?;
        Some(socket.local_addr().ok()?.ip())
    });
    let mut own: Vec<IpAddr> = own.filter(|ip| !ip.is_loopback()).collect();
    if own.is_empty() {
        own.push(IpAddr::V4(Ipv4Addr::LOCALHOST));
    }
    own
}

fn is_free(ip: IpAddr, port: u16) -> bool {
    TcpListener::bind((ip, port)).is_ok()
}

/// Between the choice of a port and the moment the monitor listens there,
/// another launcher could choose the same. `None`: another one has chosen `port`.
fn reserve(port: u16, locks: &Path) -> Result<Option<Lock>, Failure> {
    let path = locks.join(format!("port-{port}.lock"));
    let lock = Lock::try_new(&path);
    lock.cannot(format!(
        "reserve port {port} for the page by the lock {} (a plain file of this user that may be removed)",
        path.display()
    ))
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
    fn an_address_of_another_machine_is_not_called_busy() {
        // Kept free for documentation (RFC 5737).
        let message = place(Some("192.0.2.1")).unwrap_err().message;
        assert!(message.contains("an address of this machine"), "{message}");
    }

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
    fn a_lock_that_cannot_be_taken_is_named_and_no_link_is_followed() {
        let locks = tempfile::tempdir().unwrap();
        let (link, target) = (locks.path().join("port-8600.lock"), locks.path().join("x"));
        std::os::unix::fs::symlink(&target, &link).unwrap();
        let failure = first_free(Ipv4Addr::LOCALHOST.into(), locks.path()).unwrap_err();
        let message = failure.message;
        assert!(message.contains(&link.display().to_string()), "{message}");
        assert!(!message.contains("is free"), "{message}");
        assert!(!target.exists());
    }

    #[test]
    fn a_taken_port_is_passed_over_but_not_when_it_was_asked_for() {
        let locks = tempfile::tempdir().unwrap();
        let choose = || first_free(Ipv4Addr::LOCALHOST.into(), locks.path()).unwrap();
        let first = choose();
        assert_ne!(choose().address, first.address, "reserved");
        let taken = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = taken.local_addr().unwrap();
        let message = place(Some(&address.to_string())).unwrap_err().to_string();
        assert!(message.contains(&address.port().to_string()), "{message}");
    }
}

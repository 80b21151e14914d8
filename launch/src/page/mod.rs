//! The page of a run: its address, its links and its files.

mod address;
mod browser;
pub(crate) mod dist;

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream};
use std::time::Duration;

use cell_run::spec::{PageSecrets, PageSpec};
use supervisor::failure::{Context, Failure};
use supervisor::rundir::RunDir;

use crate::args::PageArgs;

use address::{ListenAddress, place};
pub(crate) use browser::open;
use dist::built;

/// The page of a run, from its choice of an address to its end, and of those
/// that take its place.
#[derive(Clone, Debug)]
pub(crate) struct Page {
    place: ListenAddress,
    host: Option<String>,
    secrets: PageSecrets,
}

impl Page {
    /// A page with a new token, at the address of the arguments.
    pub(crate) fn new(args: &PageArgs) -> Result<Self, Failure> {
        Ok(Self {
            place: place(args.listen.as_deref())?,
            host: args.host.clone(),
            secrets: PageSecrets::random().cannot("make the token of the page")?,
        })
    }

    /// What the monitor is told, for a run in `dir`.
    pub(crate) fn spec(&self, dir: &RunDir) -> PageSpec {
        let (dist, hint) = built();
        PageSpec {
            address: self.place.address,
            host: self.host.clone(),
            dist,
            hint,
            secrets: dir.page(),
        }
    }

    /// What opens it.
    pub(crate) fn secrets(&self) -> &PageSecrets {
        &self.secrets
    }
}

/// An address of this machine answers at once.
const CONNECT: Duration = Duration::from_millis(50);

/// Whether a server listens at the address of `page`.
pub(crate) fn listens(page: &PageSpec) -> bool {
    TcpStream::connect_timeout(&reachable(page.address), CONNECT).is_ok()
}

/// The link to the page for operators; `None` when it cannot be read.
pub(crate) fn link(page: &PageSpec) -> Option<String> {
    // Read each time: the monitor replaces the token of an operator once it was used.
    let secrets = PageSecrets::load(&page.secrets).ok()?;
    Some(link_with(page.address, &secrets.operator_token))
}

/// What `run` says about the page, line by line; the first is the bare link.
pub(crate) fn lines(page: &PageSpec, secrets: &PageSecrets) -> Vec<String> {
    let mut lines = vec![link_with(page.address, &secrets.operator_token)];
    if page.address.ip().is_loopback() {
        let link = link_with(page.address, &secrets.viewer_token);
        lines.push(format!("to look only: {link}"));
    } else {
        let port = page.address.port();
        let hosts = network_hosts(page);
        let links = |token: &str| {
            let links = hosts.iter();
            let links = links.map(|host| format!("http://{host}:{port}/?token={token}"));
            links.collect::<Vec<_>>().join(" ")
        };
        lines.push(format!(
            "from other machines: {}",
            links(&secrets.operator_token)
        ));
        lines.push(format!(
            "warning: the page listens at {} and can be reached from the network; it is not encrypted. \
             Anyone with a link above can move the arms. A link that only shows the cell: {}",
            page.address,
            links(&secrets.viewer_token)
        ));
    }
    lines.extend((!page.hint.is_empty()).then(|| format!("note: {}", page.hint)));
    lines
}

/// What other machines call this one: its name, where one was given, or its addresses.
fn network_hosts(page: &PageSpec) -> Vec<String> {
    if let Some(host) = &page.host {
        return vec![host.clone()];
    }
    let ip = page.address.ip();
    let ips = if ip.is_unspecified() {
        address::of_this_machine()
    } else {
        vec![ip]
    };
    let text = |ip: IpAddr| match ip {
        IpAddr::V4(v4) => v4.to_string(),
        IpAddr::V6(v6) => format!("[{v6}]"),
    };
    ips.into_iter().map(text).collect()
}

/// An address that means every interface is no place to go to: from this
/// machine it is loopback.
fn reachable(address: SocketAddr) -> SocketAddr {
    let ip = match address.ip() {
        ip if ip.is_unspecified() => IpAddr::V4(Ipv4Addr::LOCALHOST),
        ip => ip,
    };
    SocketAddr::new(ip, address.port())
}

fn link_with(address: SocketAddr, token: &str) -> String {
    format!("http://{}/?token={token}", reachable(address))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_listens_when_its_port_is_open() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let page = PageSpec {
            address: listener.local_addr().unwrap(),
            host: None,
            dist: None,
            hint: String::new(),
            secrets: "page.json".into(),
        };
        assert!(listens(&page));
        drop(listener);
        assert!(!listens(&page));
    }

    #[test]
    fn who_listens_to_the_network_is_warned() {
        let secrets = PageSecrets {
            operator_token: "aa".to_owned(),
            viewer_token: "bb".to_owned(),
            operator_cookie: String::new(),
            viewer_cookie: String::new(),
        };
        let mut page = PageSpec {
            address: ([127, 0, 0, 1], 8600).into(),
            host: None,
            dist: None,
            hint: String::new(),
            secrets: "page.json".into(),
        };
        let links = [
            "http://127.0.0.1:8600/?token=aa",
            "to look only: http://127.0.0.1:8600/?token=bb",
        ];
        assert_eq!(lines(&page, &secrets), links);
        page.address = ([0, 0, 0, 0], 8600).into();
        let said = lines(&page, &secrets);
        assert_eq!(said[0], "http://127.0.0.1:8600/?token=aa");
        assert!(
            said[1].starts_with("from other machines: http://"),
            "{said:?}"
        );
        assert!(said[2].contains("warning") && said[2].contains("token=bb"));
        page.host = Some("lab-3.local".to_owned());
        let said = lines(&page, &secrets);
        let link = "from other machines: http://lab-3.local:8600/?token=aa";
        assert_eq!(said[1], link);
    }
}
